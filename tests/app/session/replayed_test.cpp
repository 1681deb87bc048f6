// A record follows from its inputs: whatever a tick is given while a run is staged, driven and paused, by links and
// cameras of any kind, the rows that the session records drive another tick bit for bit. SKEIN_CHAOS_RUNS sets how many
// runs of each kind (default 4).
#include <gtest/gtest.h>

#include <sstream>
#include <vector>

#include "app/experiment/experiment_file.h"
#include "app/record/csv_writer.h"
#include "app/replay/replay.h"
#include "app/session/session.h"
#include "app/session/session_wiring.h"
#include "core/simulation/random.h"
#include "tests/app/experiment_texts.h"
#include "tests/app/simulated_robots.h"
#include "tests/eventually.h"
#include "tests/from_environment.h"

namespace skein::app {
namespace {

/// Four robots with links that lag, lose what they are sent, and confirm commands late, around a tick; an operator who
/// pauses and resumes; deadlines that are missed.
class PausedRun {
 public:
  PausedRun(const Experiment& experiment, std::uint64_t seed)
      : experiment_(experiment),
        random_(seed, 11),
        tick_(experiment),
        bodies_(test::robots_at_their_references(experiment)),
        sent_(experiment.robots.size()),
        links_(experiment.robots.size()),
        measured_(experiment.robots.size()),
        delays_(experiment.robots.size(), 0.02),
        unseen_(experiment.robots.size()) {
    for (std::size_t i = 0; i < bodies_.size(); ++i)
      if (experiment.robots[i].start) bodies_[i].place(*experiment.robots[i].start);
  }

  std::string record(int ticks) {
    std::ostringstream text;
    CsvWriter writer(text, experiment_);
    bool started = false;
    for (int k = 0; k < ticks; ++k) {
      const TickRecord& row = step();
      started = started || row.phase == Phase::running || row.phase == Phase::staging || row.phase == Phase::paused;
      if (belongs_to_run(row, started)) writer.record(row);
    }
    return text.str();
  }
  int pauses = 0;

 private:
  bool likely(double share) { return random_.uniform() < share; }
  std::size_t any_robot() { return static_cast<std::size_t>(random_.uniform() * static_cast<double>(bodies_.size())); }

  std::vector<OperatorCommand> ask() {
    const TickRecord& now = tick_.record();
    const bool drives = now.phase == Phase::running || now.phase == Phase::staging;
    if (now.phase == Phase::ready && likely(0.3)) return change();
    if (now.phase == Phase::ready && likely(0.3))
      return {staged_ || likely(0.5) ? OperatorCommand(commands::Start{}) : OperatorCommand(commands::Stage{})};
    if (drives && !now.paused() && likely(0.05)) return ++pauses, std::vector<OperatorCommand>{commands::Pause{}};
    if (now.paused() && likely(0.2)) return {commands::Resume{}};
    if (likely(0.02)) return change();
    return {};
  }
  std::vector<OperatorCommand> change() {
    const std::size_t robot = any_robot(), other = (robot + 1) % bodies_.size();
    if (likely(0.3)) return {commands::Hold{robot, likely(0.3)}};
    if (likely(0.3)) return {commands::Couple{robot, other, likely(0.5)}};
    if (likely(0.5)) return {commands::SetGain{core::GainName::k_xx, 0.01 * random_.uniform(), 0.0}};
    return {commands::PutObstacle{0, {random_.uniform() - 0.5, random_.uniform() - 0.5, 0.04}}};
  }

  const TickRecord& step() {
    const int elapsed = likely(0.05) ? 2 : 1;
    // Never exactly a period: a wall clock's.
    const double dt = elapsed * experiment_.period() * (0.98 + 0.04 * random_.uniform());
    now_ += dt;
    for (std::size_t i = 0; i < bodies_.size(); ++i) {
      bodies_[i].command(sent_[i]);
      bodies_[i].step(dt);
      if (unseen_[i] > 0)
        --unseen_[i];
      else if (likely(0.005))
        unseen_[i] = 20;
      else
        measured_[i] = bodies_[i].measure(now_);
      const core::WheelSpeeds wheels = tick_.record().robots[i].wheels;
      if (!likely(0.2)) sent_[i] = wheels;  // or it has still those from before
      const double blind_way = likely(0.1) ? 0.05 * random_.uniform() : 0.002;
      links_[i] = {.linked = true, .sent = sent_[i], .sent_at = now_ - 0.01, .blind_way = blind_way};
      delays_[i] += 0.02 * (0.04 * random_.uniform() - delays_[i]);
    }
    const std::vector<OperatorCommand> asked = ask();
    TickInput input;
    if (likely(0.01)) {  // a hand
      const std::size_t robot = any_robot();
      const core::Pose pose{random_.uniform() - 0.5, random_.uniform() - 0.5, random_.uniform()};
      bodies_[robot].place(pose);
      input.events.add(events::Move{robot, pose});
    }
    input.now = now_;
    input.elapsed = elapsed;
    input.measurements = measured_;
    input.links = links_;
    input.delays = delays_;
    input.commands = asked;
    const TickRecord& row = tick_.step(input);
    staged_ = staged_ || row.phase == Phase::staging;
    return row;
  }

  Experiment experiment_;
  core::Random random_;
  ControlTick tick_;
  std::vector<core::SimulatedRobot> bodies_;
  std::vector<core::WheelSpeeds> sent_;
  std::vector<LinkInput> links_;
  std::vector<core::Measurement> measured_;
  std::vector<double> delays_;
  std::vector<int> unseen_;  // for so many ticks
  double now_ = 0.0;
  bool staged_ = false;
};

TEST(Replayed, ARunThatIsPausedAtAnyTimeIsRepeatedToTheBitFromItsRecord) {
  const Sets common{"duration=60", "robot_defaults.link=loopback", "failure.link_lost=others_go_on",
                    "shield.gamma=0.5"};
  const int runs = static_cast<int>(test::number_from_environment("SKEIN_CHAOS_RUNS", 4.0));
  for (const Sets& more : {Sets{"robot_defaults.model=epuck1"}, Sets{"robot_defaults.model=epuck2"},
                           Sets{"robot_defaults.model=epuck2", "simulation.latency=0.1", "simulation.pose_noise=0.001"},
                           Sets{"robot_defaults.model=epuck2", "robot.1.start=[-0.3, -0.2, 2.0]",
                                "robot.2.start=[0.6, 0.3, -3.0]", "robot.3.start=[0.1, 0.1, 0.0]"},
                           Sets{"robot_defaults.model=epuck2", "avoidance.kind=\"plan\""}}) {
    Sets sets = common;
    sets.insert(sets.end(), more.begin(), more.end());
    const Experiment experiment = good(paper_experiment().source, sets);
    int pauses = 0;
    for (int seed = 1; seed <= runs; ++seed) {
      SCOPED_TRACE(more.back() + ", seed " + std::to_string(seed));
      PausedRun run(experiment, static_cast<std::uint64_t>(seed));
      std::istringstream csv(run.record(1000));
      const auto again = replay(csv, "run.csv");
      ASSERT_TRUE(again) << again.error();
      EXPECT_EQ(again->different, 0) << "of " << again->commands << ", the first: " << again->first;
      pauses += run.pauses;
    }
    EXPECT_GT(pauses, 20) << "or it proves little";
  }
}

TEST(Replayed, ARunWithLinksThatIsPausedInRealTimeIsRepeatedToTheBit) {
  const Experiment experiment =
      good(paper_experiment().source, {"rate=50", "robot_defaults.link=loopback", "robot_defaults.model=epuck2",
                                       "failure.link_lost=others_go_on", "links.command_silence=1"});
  std::ostringstream text;
  CsvWriter writer(text, experiment);
  auto session = Session::open(experiment, Session::Clock::wall, {false, {&writer}});
  ASSERT_TRUE(session) << session.error();
  TickRecord latest;
  const auto drives_to = [&](std::int64_t tick) {
    return test::eventually([&] {
      (*session)->drain([&](const TickRecord& record) { latest = record; });
      return latest.phase == Phase::running && latest.tick >= tick;
    });
  };
  ASSERT_TRUE((*session)->start());
  for (int pause = 1; pause <= 5; ++pause) {
    ASSERT_TRUE(drives_to(latest.tick + 10));
    ASSERT_TRUE((*session)->pause());
    int stood = 0;
    ASSERT_TRUE(test::eventually([&] {
      (*session)->drain([&](const TickRecord& record) {
        latest = record;
        stood += record.phase == Phase::paused ? 1 : 0;
      });
      return stood > 5 * pause;
    }));
    ASSERT_TRUE((*session)->resume());
  }
  ASSERT_TRUE(drives_to(latest.tick + 10));
  (*session)->close();
  std::istringstream csv(text.str());
  const auto again = replay(csv, "run.csv");
  ASSERT_TRUE(again) << again.error();
  EXPECT_EQ(again->different, 0) << "of " << again->commands << ", the first: " << again->first;
}

}  // namespace
}  // namespace skein::app
