#pragma once

#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include <tl/expected.hpp>

#include "app/experiment/experiment.h"
#include "app/session/camera_film.h"
#include "core/estimation/measurement.h"
#include "vision/frames/frame_source.h"
#include "vision/tracker/tracker.h"

namespace skein::app {

/// When the newest frame of a camera that a tick knew of was taken; a frame in which no robot was seen may be unknown.
double newest_capture(std::span<const core::Measurement> by_camera) noexcept;

/// Runs the film of one of a run's cameras through the same tracker again.
class ReplayFilm {
 public:
  /// The error says why this is not a film recorded by `skein run --video`.
  static tl::expected<ReplayFilm, std::string> open(const std::string& path, const Experiment& experiment);

  /// Processes every further frame that was captured up to `time` (session's clock); then every robot's newest
  /// measurement by this camera is in `newest`.
  tl::expected<void, std::string> advance(double time, std::span<core::Measurement> newest);

  /// The text of the experiment in which it was recorded; empty: it does not say.
  std::string experiment() const;
  /// Whether its pixels are those that the tracker saw during the run.
  bool lossless() const;

  /// Whether the tracker has received every frame up to the last `time` that it received in the run.
  bool complete() const noexcept { return complete_; }
  std::int64_t frames() const noexcept { return frames_; }    ///< processed
  double short_by() const noexcept { return short_by_; }      ///< how long before the last `time` it ends [s]
  std::int64_t missing() const noexcept { return missing_; }  ///< that the recorder had dropped before those

 private:
  ReplayFilm(std::unique_ptr<vision::FrameSource> source, vision::TagTracker tracker, std::vector<int> wanted)
      : source_(std::move(source)), tracker_(std::move(tracker)), wanted_(std::move(wanted)) {}

  std::unique_ptr<vision::FrameSource> source_;
  vision::TagTracker tracker_;
  std::vector<int> wanted_;
  vision::Frame next_;
  bool has_next_ = false, ended_ = false, complete_ = true;
  std::int64_t frames_ = 0, missing_ = 0, last_index_ = -1;
  double last_at_ = 0.0, short_by_ = 0.0;  // [s]
};

}  // namespace skein::app
