#pragma once

#include <string>
#include <utility>
#include <vector>

#include <tl/expected.hpp>

#include "app/experiment/experiment.h"
#include "app/run/tick_record.h"
#include "core/estimation/identification.h"

namespace skein::app {

/// What the rows of runs say about each robot: what its wheels were told, and where it was seen.

/// A robot's history, of one run or of several. Times on the clock of the first run's session.
struct RobotHistory {
  std::string key;                  ///< tells robots apart from run to run: the name, else the tag
  std::string name;                 ///< what messages call it
  RobotSpec spec;                   ///< as its newest run had it
  core::IdentificationInput input;  ///< `believed` is the newest run's
  double believed_delay = 0.0;      ///< actuation delay that its newest run went by, on average [s]
  std::size_t runs = 0;
  std::size_t carried = 0;  ///< how often it was put elsewhere by hand, kicked, or between two runs
};

/// Takes the rows of one run, in their order. Not for the tick: it allocates.
class RunHistory final : public RecordSink {
 public:
  explicit RunHistory(const Experiment& experiment);
  void record(const TickRecord& row) override;
  /// Of every robot that was seen; nothing is left here.
  std::vector<RobotHistory> finish() &&;

 private:
  struct Robot {
    explicit Robot(core::MotorModel motor) : log(motor) {}

    core::WheelLog log;
    core::WheelSpeeds commanded{none, none};  ///< newest in `log`
    double commanded_at = -1e9;
    core::WheelSpeeds told{none, none};  ///< what the tick before asked for
    std::vector<core::SeenPose> poses;
    bool moved = false;  ///< somebody moves it: where it is next says nothing of its wheels
    double moved_from = 0.0, moved_to = 0.0;
    double delays = 0.0, delays_known = 0.0;  ///< their sum, and how many
    std::size_t carried = 0;
  };
  void hear(const TickRecord& row);
  void drive(Robot& robot, const TickRecord& row, const RobotRecord& record) const;
  void see(Robot& robot, const TickRecord& row, std::size_t i) const;

  const Experiment experiment_;
  std::vector<Robot> robots_;
  double before_ = none;  ///< time of the newest row
};

/// Of a run's CSV. The error names file and place.
tl::expected<std::vector<RobotHistory>, std::string> read_history(const std::string& csv);

/// Puts the history of a later run behind that of the same robots; robots that are new come last.
void append(std::vector<RobotHistory>& robots, std::vector<RobotHistory> more);

struct IdentifiedRobot {
  RobotHistory history;
  core::Identification found;
  /// Correlation of one residual with the next, the largest of ahead, left and theta: near 0 where the model has all
  /// that matters.
  double persistence = 0.0;
  std::size_t outliers = 0;
};

/// All of them, each on a thread of its own as long as there are cores.
std::vector<IdentifiedRobot> identify_robots(std::vector<RobotHistory> robots);

/// Why something cannot be told, and what would help, a sentence each; empty: all is told.
std::vector<std::string> doubts(const IdentifiedRobot& robot);

/// What a file of robots keeps of it, keys with their values: of what the data tell, and of nothing else.
std::vector<std::pair<std::string, std::string>> values_to_keep(const IdentifiedRobot& robot);

/// residuals_N.csv, and as figures residuals_N.pdf, .svg, .png with the script that draws them, of each robot, into a
/// folder that is made. The error says what was missing.
tl::expected<void, std::string> write_residuals(const std::string& folder, const std::vector<IdentifiedRobot>& robots);

}  // namespace skein::app
