#pragma once

#include <array>
#include <cstddef>
#include <deque>
#include <functional>
#include <vector>

namespace skein::ui {

/// The curves of a run over one time: of every curve each sample, and of every 32 and 1024 of them the smallest and the
/// largest. So half an hour is drawn with as many points as the screen has columns, no peak is lost, and the drawing
/// time does not depend on the length of the run. Bounded: the oldest samples go first.
class PlotHistory {
 public:
  static constexpr std::size_t block_size = 1024, part_size = 32;

  /// A point of a curve to be drawn; value NaN: a gap.
  struct Point {
    double t, value;
  };
  struct Range {
    double low, high;  ///< low > high: there is no value
  };

  explicit PlotHistory(std::size_t curves = 0, std::size_t most_samples = std::size_t{1} << 17)
      : curves_(curves), most_(most_samples) {}

  std::size_t curves() const { return curves_; }
  std::size_t size() const { return blocks_.empty() ? 0 : (blocks_.size() - 1) * block_size + blocks_.back().size; }
  bool empty() const { return size() == 0; }
  double first_time() const { return blocks_.front().t[0]; }
  double last_time() const { return blocks_.back().t[blocks_.back().size - 1]; }

  /// One sample of every curve, NaN where it has no value; t grows.
  void add(double t, const std::vector<double>& values);

  /// The curve between two times with one sample beyond either end, in at most some 4 * `columns` points: each sample
  /// where there are few, else the smallest and the largest of every column.
  void points(std::size_t curve, double from, double to, std::size_t columns, std::vector<Point>& out) const;
  /// The smallest and the largest value between two times.
  Range range(std::size_t curve, double from, double to) const;
  /// The value of the last sample at or before t; NaN: there is none.
  double value(std::size_t curve, double t) const;
  /// Every sample between two times, in order: its time, and a function that returns a curve's value.
  void each(double from, double to,
            const std::function<void(double t, const std::function<double(std::size_t curve)>& value)>& take) const;

 private:
  static constexpr std::size_t parts = block_size / part_size;
  struct Curve {
    std::array<double, block_size> value;
    std::array<Range, parts> part;
    Range whole;
  };
  struct Block {
    std::size_t size = 0;
    std::array<double, block_size> t;
    std::vector<Curve> curves;
  };

  std::size_t index_after(double t) const;  // of the first sample later than t
  double time(std::size_t index) const { return blocks_[index / block_size].t[index % block_size]; }
  double at(std::size_t curve, std::size_t index) const {
    return blocks_[index / block_size].curves[curve].value[index % block_size];
  }
  Range range_of(std::size_t curve, std::size_t begin, std::size_t end) const;

  std::size_t curves_, most_;
  std::deque<Block> blocks_;
};

/// Leaves out what is not seen: of a stretch whose values stay within `tolerance` of its first one, all points between
/// the first and the last. What is left deviates from the curve by 2 * `tolerance` at most; gaps stay.
void drop_level_points(std::vector<PlotHistory::Point>& points, double tolerance);

}  // namespace skein::ui
