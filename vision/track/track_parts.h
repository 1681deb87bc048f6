#pragma once

#include <cstdint>
#include <iosfwd>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <tl/expected.hpp>
#include <vector>

#include "vision/calibration/calibration.h"
#include "vision/frames/frame_source.h"
#include "vision/recording/recorder.h"
#include "vision/tags/detection.h"
#include "vision/tags/tag_pose.h"

/// What both bodies of `skein track` have in common.
namespace skein::vision::detail {

/// The table of tags, see vision::track.
class Table {
 public:
  /// csv: null: nothing is written.
  Table(std::ostream* csv, const std::optional<Calibration>& calibration);

  /// With a calibration the pose is that of the corners.
  void add(const Frame& frame, const Detection& detection, How how);
  void add(const Frame& frame, const TagPose& seen);
  bool well() const;
  bool finish();

 private:
  void begin(const Frame& frame, double t, int tag, const Corners& corners);
  void pose(const core::Pose& pose, double sigma_xy, double sigma_theta);
  void end(How how);
  void text(std::string_view value);
  void number(double value);
  void number(std::int64_t value);
  void separate();

  std::ostream* csv_;
  std::optional<Calibration> calibration_;
  std::string line_;  // one buffer for all rows
};

/// Into ids in ascending order, each once.
void insert(std::vector<int>& ascending, int id);

/// Empty, or that the calibration holds for another size.
std::string wrong_size(const Frame& frame, const std::string& source, const std::optional<Calibration>& calibration);

/// Null where no film is wanted. `source`: its address, which the film notes.
tl::expected<std::unique_ptr<Recorder>, std::string> open_recorder(const std::string& film, FilmNotes notes,
                                                                   const std::string& source);

/// Empty, or that none of a source's pictures could be read.
std::string nothing_read(const FrameSource& source, std::int64_t frames);

}  // namespace skein::vision::detail
