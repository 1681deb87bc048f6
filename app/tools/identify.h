#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include <tl/expected.hpp>

#include "app/experiment/experiment.h"
#include "app/run/tick_record.h"
#include "core/estimation/identification.h"

namespace skein::app {

/// The data of runs about each robot: wheel commands and measured poses.

/// A robot's history, of one run or of several. Times on the clock of the first run's session.
struct RobotHistory {
  std::string key;                  ///< identifies the robot across runs: the name, else the tag
  std::string name;                 ///< its name in messages
  RobotSpec spec;                   ///< as its newest run had it
  core::IdentificationInput input;  ///< `believed` is the newest run's
  /// Of each run alone, in the order of the runs; empty: there is only one.
  std::vector<core::IdentificationInput> each{};
  double believed_delay = 0.0;  ///< mean actuation delay assumed in its newest run [s]
  std::size_t runs = 0;
  std::size_t carried = 0;  ///< how often it was moved by hand, kicked, or between two runs
};

/// Collects the rows of one run, in order. Not for the tick: it allocates.
class RunHistory final : public RecordSink {
 public:
  explicit RunHistory(const Experiment& experiment);
  void record(const TickRecord& row) override;
  /// Returns the histories of all robots that were seen; the collector is then empty.
  std::vector<RobotHistory> finish() &&;
  /// How often rows were missing before the next one.
  std::size_t gaps() const noexcept { return gaps_; }

 private:
  struct Robot {
    explicit Robot(core::MotorModel motor) : log(motor) {}

    core::WheelLog log;
    core::WheelSpeeds commanded{none, none};  ///< newest in `log`
    double commanded_at = -1e9;
    core::WheelSpeeds told{none, none};  ///< the previous tick's command
    std::vector<core::SeenPose> poses;
    bool moved = false;  ///< it is moved by hand: its wheels do not explain its next pose
    double moved_from = 0.0, moved_to = 0.0;
    double delays = 0.0, delays_known = 0.0;  ///< their sum and number
    std::size_t carried = 0;
  };
  static void carry(Robot& robot, double from, double to);
  void pass_over(const TickRecord& row);
  void hear(const TickRecord& row);
  void drive(Robot& robot, const TickRecord& row, const RobotRecord& record) const;
  void see(Robot& robot, const TickRecord& row, std::size_t i) const;

  const Experiment experiment_;
  std::vector<Robot> robots_;
  double before_ = none;    ///< time of the newest row
  double t_before_ = none;  ///< the experiment's
  std::size_t gaps_ = 0;
};

struct RecordedHistory {
  std::vector<RobotHistory> robots;
  std::optional<std::string> torn;  ///< where the file ends in the middle of a row, a sentence
  std::size_t gaps = 0;             ///< how often rows are missing
};
/// Of a run's CSV. The error names file and place.
tl::expected<RecordedHistory, std::string> read_history(const std::string& csv);

/// Whether both have the same measurements, at least as far as the shorter one goes: one run, in two files.
bool same_run(const std::vector<RobotHistory>& a, const std::vector<RobotHistory>& b);

/// Appends the histories of a later run to those of the same robots; new robots come last.
void append(std::vector<RobotHistory>& robots, std::vector<RobotHistory> more);

/// What one of several runs gives alone, where that cannot be the same robot as in all runs together.
struct OtherRobot {
  std::size_t run = 0;     ///< from 0
  std::string_view value;  ///< its name, such as wheel_ratio
  core::Estimate alone, together;
};

struct IdentifiedRobot {
  RobotHistory history;
  core::Identification found;
  /// Correlation of one residual with the next, the largest of ahead, left and theta: near 0 if the model is
  /// complete.
  double persistence = 0.0;
  std::size_t outliers = 0;
  std::vector<OtherRobot> others;  ///< at most one of each run
};

/// All of them, each on a thread of its own as long as there are cores.
std::vector<IdentifiedRobot> identify_robots(std::vector<RobotHistory> robots);

/// Why a value is not determined, and the remedy, a sentence each; empty: all are determined.
std::vector<std::string> doubts(const IdentifiedRobot& robot);

/// The keys and values for a file of robots: only of values that the data determine.
std::vector<std::pair<std::string, std::string>> values_to_keep(const IdentifiedRobot& robot);

/// residuals_N.csv, and as figures residuals_N.pdf, .svg, .png with the script that draws them, of each robot, into a
/// folder that is made. The error says what was missing.
tl::expected<void, std::string> write_residuals(const std::string& folder, const std::vector<IdentifiedRobot>& robots);

}  // namespace skein::app
