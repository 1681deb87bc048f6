#pragma once

#include <functional>
#include <string>
#include <tl/expected.hpp>
#include <vector>

#include "app/experiment/experiment.h"
#include "app/run/session_clock.h"
#include "app/session/plant.h"
#include "core/estimation/latency_fit.h"

namespace skein::app {

/// How late one camera's time stamps are, beyond what camera.latency already corrects, from the headings and the wheel
/// counters of a robot that turned on the spot.
struct CameraLatency : core::LatencyFit {
  std::size_t poses = 0;
  std::string doubt{};     ///< why the data do not determine it; empty: they do
  std::size_t camera = 0;  ///< from 0
  double row = none;       ///< of the picture at which the robot's tag was, mean [px]
};

/// The fit to a turn, and whether it is reliable.
CameraLatency judge_latency(const core::TurnRecord& turn);

/// A camera's latency and row time, from robots that turned at different rows of its picture.
struct CameraRows {
  double row_time = none, row_time_sigma = none;  ///< the value for the calibration, and its standard deviation [s]
  double late = none;                             ///< as CameraLatency::late, at the first row [s]
  double late_sigma = none;                       ///< [s]
  std::string doubt{};                            ///< why the turns do not determine them; empty: they do
};

/// The line through the latencies of one camera over the rows. `row_time`: the one with which its poses were dated;
/// `height`: of its pictures [s, px].
CameraRows judge_rows(const std::vector<CameraLatency>& turns, double row_time, int height);

struct LatencyMeasurement {
  std::vector<CameraLatency> cameras;  ///< in their order
  double turned = 0.0;                 ///< in either direction, by the counters [rad]
  std::size_t counts = 0;              ///< readings of the counters that were used
  double round_trip = none;            ///< their median: counters may have been read half of it earlier or later [s]
};

/// Turns a robot to and fro on the spot for so many seconds, faster and faster within its limits, while all others
/// stand, and compares headings with counters. `plant`: opened without SessionOptions::every_tag. The error: it cannot
/// be done, was ended (`keep_on`), or the robot, its tag or the camera was lost; then all robots have been stopped.
tl::expected<LatencyMeasurement, std::string> measure_latency(Plant& plant, SessionClock& clock,
                                                              const Experiment& experiment, std::size_t robot,
                                                              double seconds, std::function<bool()> keep_on = {});

}  // namespace skein::app
