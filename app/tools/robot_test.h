#pragma once

#include <functional>
#include <optional>
#include <string>
#include <tl/expected.hpp>
#include <utility>
#include <vector>

#include "app/experiment/experiment.h"
#include "app/run/session_clock.h"
#include "app/session/plant.h"
#include "app/session/wheel_check.h"
#include "app/tools/plant_loop.h"

namespace skein::app {

/// The result of testing one robot.
struct RobotTestResult {
  RobotStatus status;                      ///< version, battery, round trip
  double left_steps = 0, right_steps = 0;  ///< of each wheel while it was commanded alone [steps]
  int tag = -1;                            ///< that turned with it; -1: the camera saw none, or there is no camera
  std::optional<double> wheel_diameter;    ///< from the camera's and the encoders' distance [m]
  std::optional<double> track;             ///< from the camera's and the encoders' rotation [m]
  /// How long after the last byte from the host it stopped by itself: its watchdog. 0: it has none, it drove on for the
  /// whole second in which nothing was sent. Empty: not tested. [s]
  std::optional<double> watchdog;
  std::vector<std::string> faults;  ///< a sentence each; empty: none found
  bool tag_fault = false;           ///< one of them is the tag's; the others are the wheels'
  std::vector<std::string> notes;   ///< tests that were not possible, and why
};

/// The results that a file of robots stores: its keys, with values as TOML text.
std::vector<std::pair<std::string, std::string>> values_to_keep(const RobotTestResult& result);

/// The watchdog time of a robot that was commanded `speed` and then nothing for `silence`, from the steps that its
/// wheels made in that time: see RobotTestResult::watchdog. `speed` as its wheels count it. [steps/s], [s]
double watchdog_of(double steps, double speed, double silence) noexcept;

/// Tests robots one after the other, while all others stand: turns each wheel about 10 mm forward and compares its
/// encoder and the speeds that it reports, and with a camera the tags, with the command; with a camera it then drives 6
/// cm forward and back and turns by 110 degrees and back, and computes wheel diameter and track. Encoders count the
/// commanded steps: only a camera detects swapped motor cables, a slipping wheel or a wrong tag.
class RobotTest {
 public:
  /// `plant`: opened with SessionOptions::every_tag. `believed`: the files' values for its robots, in order. `keep_on`
  /// is called in every tick; false ends the test.
  RobotTest(Plant& plant, SessionClock& clock, const Experiment& believed, std::function<bool()> keep_on);

  /// The error: the robot, or the camera, was lost meanwhile, or the test was ended. Then all robots stand.
  tl::expected<RobotTestResult, std::string> test(std::size_t robot);

 private:
  /// One tag before and after a manoeuvre, the robot standing.
  struct Moved {
    int tag = -1;
    core::Pose before, after;
    double forward() const;  // along the mean heading [m]
    double turned() const { return core::wrap_angle(after.theta - before.theta); }
  };
  struct Manoeuvre {
    OneWheelTurn wheels;      // encoders
    std::vector<Moved> tags;  // those that were seen before and after
  };

  tl::expected<void, std::string> stand();
  tl::expected<Manoeuvre, std::string> drive(std::size_t robot, double left, double right, double seconds);
  tl::expected<void, std::string> read_counters(std::size_t robot);
  tl::expected<void, std::string> cut_line(std::size_t robot, RobotTestResult& result);
  void judge_camera(std::size_t robot, const Manoeuvre& left, const Manoeuvre& right, RobotTestResult& result) const;
  tl::expected<void, std::string> calibrate(std::size_t robot, RobotTestResult& result);
  bool free_way(int tag, double distance, double radius) const;
  std::string whose(int tag) const;
  std::string why_not_seen(std::size_t robot) const;

  Plant& plant_;
  SessionClock& clock_;
  const Experiment& believed_;
  PlantLoop loop_;
  std::vector<int> wanted_;
  std::vector<core::Pose> resting_;  // mean pose of every tag in the last stand(); NaN: not seen
  bool looked_ = false;              // the camera has shown all tags that there are
};

}  // namespace skein::app
