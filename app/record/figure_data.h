#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <unordered_set>
#include <vector>

#include "app/experiment/experiment.h"
#include "app/run/tick_record.h"

namespace skein::app {

/// The lowest and the highest of numbers; none before the first.
struct Extent {
  double low = none, high = none;
  void include(double value);
};

/// A value over time for a figure. Of more points than `most` buckets hold, neighbouring buckets become one, of which
/// the lowest and the highest value stay: what sticks out for one tick is seen however long the run is.
class Curve {
 public:
  explicit Curve(std::size_t most) : most_(most) {}
  /// In the order of time [s]. A value that is not known (NaN) breaks the line, unless its bucket has others.
  void add(double t, double value);
  /// Lines of gnuplot, "t value" each; an empty one breaks the curve.
  std::string text() const;
  struct Point {
    double t, value;
  };
  /// Where it is farthest from zero, and there first; NaN: no value is known.
  Point peak() const;

 private:
  struct Bucket {
    Point low{none, none}, high{none, none};
    void include(const Point& point);
  };
  std::size_t most_;      // buckets
  std::size_t each_ = 1;  // points of a bucket
  std::size_t in_last_ = 0;
  std::vector<Bucket> buckets_;
};

/// A line on the floor for a figure. One of more points than `most` is thinned: the floor is divided into cells, and a
/// step between two cells is drawn once, however often the robot comes by. The cells begin at a thousandth of the
/// floor's size, and double until the line fits.
class FloorLine {
 public:
  /// `size`: of the floor [m].
  FloorLine(std::size_t most, double size) : most_(most), size_(size) {}
  /// `leads_here`: it goes on from the point before. A place that is not known (NaN) breaks it. [m]
  void add(double x, double y, bool leads_here);
  /// Lines of gnuplot, "x y" each; an empty one breaks the line.
  std::string text() const;

 private:
  struct Point {
    double x, y;
    bool begins;  // no line leads here
  };
  std::uint32_t cell(const Point& point) const;
  void take(const Point& point);
  std::size_t most_;
  double size_;
  double cell_ = 0.0;                        // its side [m]; 0: every point is drawn
  std::vector<Point> points_;                // what is drawn
  std::unordered_set<std::uint64_t> drawn_;  // steps between two cells
  Point at_{none, none, true};               // the first point in the cell that was reached last
  bool at_is_drawn_ = false;                 // it is the last of points_
};

/// What the paper's figures 3 and 4 show of a run, gathered row by row: all of a short run, and of a long one as much
/// as can be seen, in a memory that does not grow with it. While robots drive to their starts t stands still: that is
/// no part of it. One thread.
class FigureData final : public RecordSink {
 public:
  explicit FigureData(const Experiment& experiment);
  void record(const TickRecord& row) override;

  /// Blocks of data that gnuplot loads. Of robot i, from 1: $reference_i and $path_i ("x y", m), $moves_i, where it was
  /// put elsewhere ("x y dx dy", m), $ends_i (where its path begins and ends).
  std::string paths() const;
  /// $x_i, $y_i, $theta_i: the tracking errors ("t error", s and m or rad) in the world's frame, with the reference of
  /// the formation; $delta_i: the error (37) of the distance to the next robot [m]. $peaks_1 to $peaks_4: where
  /// curves of x, y, theta and delta are farthest from zero ("t error i"): at most eight, those that come farthest, and
  /// none that another one's number would cover.
  std::string errors() const;
  /// Between what everything lies that is drawn.
  struct Extents {
    Extent t;        ///< [s]
    Extent x, y;     ///< of the places of robots and references [m]
    Extent e_xy;     ///< of both [m]
    Extent e_theta;  ///< [rad]
    Extent delta;    ///< [m]
  };
  const Extents& extents() const noexcept { return extents_; }

 private:
  struct Robot {
    FloorLine reference, path;
    Curve x, y, theta, delta;
    std::string moves{};
    std::size_t moved = 0;
    core::Pose first{none, none, none}, last{none, none, none};
  };
  std::string peaks(std::size_t panel, Curve Robot::*curve, const Extent& values) const;
  std::vector<Robot> robots_;
  Extents extents_;
};

}  // namespace skein::app
