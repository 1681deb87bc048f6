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

/// Runs the film of one of a run's cameras through the same tracker again.
class ReplayFilm {
 public:
  /// The error says why this is not a film recorded by `skein run --video`.
  static tl::expected<ReplayFilm, std::string> open(const std::string& path, const Experiment& experiment);

  /// Processes every further frame up to the one of the newest measurement by this camera that a tick recorded; then
  /// every robot's newest measurement by the film is in `newest`.
  tl::expected<void, std::string> advance(std::span<const core::Measurement> recorded,
                                          std::span<core::Measurement> newest);

  /// The text of the experiment in which it was recorded; empty: it does not say.
  std::string experiment() const;
  /// Whether its pixels are those that the tracker saw during the run.
  bool lossless() const;

  /// Whether the tracker has received the same pixels as in the run so far: the film is lossless and lacks no frame.
  bool exact() const noexcept { return exact_; }
  std::int64_t frames() const noexcept { return frames_; }  ///< processed
  double short_by() const noexcept {
    return short_by_;
  }  ///< how long before the newest recorded measurement it ends [s]
  std::int64_t missing() const noexcept { return missing_; }  ///< that the recorder had dropped before those

 private:
  ReplayFilm(std::unique_ptr<vision::FrameSource> source, vision::TagTracker tracker, std::vector<int> wanted)
      : source_(std::move(source)), tracker_(std::move(tracker)), wanted_(std::move(wanted)), exact_(lossless()) {}

  std::unique_ptr<vision::FrameSource> source_;
  vision::TagTracker tracker_;
  std::vector<int> wanted_;
  vision::Frame next_;
  bool has_next_ = false, ended_ = false, exact_;
  std::int64_t frames_ = 0, missing_ = 0, last_index_ = -1;
  double last_at_ = 0.0, short_by_ = 0.0;  // [s]
};

}  // namespace skein::app
