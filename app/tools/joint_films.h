#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <string>
#include <tl/expected.hpp>
#include <vector>

#include "app/experiment/experiment.h"
#include "vision/calibrate/joint_calibration.h"

namespace skein::app {

struct JointFilms {
  vision::JointCalibration joint;
  std::vector<std::string> files{};    ///< of each camera's calibration; empty: the synthetic camera's own
  std::vector<std::int64_t> frames{};  ///< of each film
  std::vector<std::size_t> sights{};   ///< of robots, likewise
  std::vector<std::string> skipped{};  ///< what could not be read of the films, a sentence each
};

/// Called before each frame with the camera whose film is searched, from 0, and the number of frames searched so far;
/// false ends the search.
using JointProgress = std::function<bool(std::size_t camera, std::int64_t frames)>;

/// vision::solve_joint from the films that a run of an experiment has left (`skein run --video`), one a camera. Every
/// frame is searched by AprilTag, so that nothing depends on what a camera's tracker knew of the other cameras.
/// `reference`: a camera, from 0. The error: a film or calibration is not that of the experiment, solve_joint's own, or
/// it was ended (`keep_on`).
tl::expected<JointFilms, std::string> joint_films(const Experiment& experiment, const std::string& film,
                                                  std::size_t reference, const JointProgress& keep_on = {});

}  // namespace skein::app
