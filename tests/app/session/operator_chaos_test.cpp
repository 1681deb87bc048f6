// An operator who does everything at random while links break, fall silent and come back: the tick, the watch of the
// links, the sessions and four emulated e-pucks, in virtual time. No robot whose link was lost is sent a speed before
// the operator has released it since; nothing that is asked gets lost; after STOP everybody stands.
// SKEIN_CHAOS_SEED sets the first seed, SKEIN_CHAOS_RUNS how many runs of each rate (default 4).
#include <gtest/gtest.h>

#include <algorithm>
#include <cstdio>
#include <string>
#include <vector>

#include "app/experiment/experiment_file.h"
#include "app/tick/control_tick.h"
#include "core/simulation/random.h"
#include "core/simulation/simulated_robot.h"
#include "tests/app/session/failure_links.h"
#include "tests/app/simulated_robots.h"
#include "tests/from_environment.h"

namespace skein::app {
namespace {

struct OperatorTally {
  int requests = 0, losses = 0, releases = 0;
};

class OperatorChaos {
  static constexpr std::size_t robots = test::FailureLinks::robots;
  static constexpr double duration = 40.0, quiet = 8.0, fault_interval = 1.5;  // [s]

 public:
  OperatorChaos(double rate, std::uint64_t seed)
      : experiment_(parse_experiment(paper_experiment().source, "platoon.toml",
                                     {"failure.link_lost=others_go_on", "robot_defaults.model=epuck2",
                                      "shield.gamma=0.5", "rate=" + std::to_string(rate)})
                        .value()),
        tick_(experiment_),
        links_(comms::random_faults(robots, duration - quiet, fault_interval, seed), experiment_.failure.link_bridge,
               experiment_.period(), experiment_.command_silence()),
        random_(seed, 77),
        bodies_(test::robots_at_their_references(experiment_)),
        measured_(robots) {
    links_.on_tick = [this](const EventList& told) { step(told); };
  }

  OperatorTally run() {
    links_.run_until(duration - quiet + 2.0 * random_.uniform());
    stopped_ = true;
    links_.stop();
    links_.run_until(duration);
    EXPECT_EQ(tick_.record().phase, Phase::stopped);
    for (std::size_t i = 0; i < robots; ++i) {
      EXPECT_TRUE(links_.session(i).stop_acknowledged()) << links_.session(i).status(duration).reason;
      EXPECT_TRUE(links_.stands(i)) << "robot " << i + 1;
    }
    return tally_;
  }

 private:
  bool likely(double share) { return random_.uniform() < share; }
  std::size_t any_robot() { return static_cast<std::size_t>(random_.uniform() * robots); }

  /// What the operator asks of this tick: as Session, which releases no robot whose link is not up.
  std::vector<OperatorCommand> ask() {
    std::vector<OperatorCommand> asked;
    if (tick_.record().phase == Phase::ready)
      asked.emplace_back(likely(0.5) ? OperatorCommand(commands::Start{}) : OperatorCommand(commands::Stage{}));
    const std::size_t i = any_robot(), j = (i + 1) % robots;
    if (likely(0.02)) asked.emplace_back(commands::Pause{});
    if (likely(0.2)) asked.emplace_back(commands::Resume{});
    if (likely(0.05)) asked.emplace_back(commands::Hold{i, true});
    if (likely(0.02)) asked.emplace_back(commands::Couple{i, j, likely(0.5)});
    if (likely(0.02)) asked.emplace_back(commands::SetGain{core::GainName::k_xx, 0.01 * random_.uniform(), 0.0});
    if (likely(0.02)) asked.emplace_back(commands::PutObstacle{0, {random_.uniform(), random_.uniform(), 0.04}});
    for (std::size_t r = 0; r < robots; ++r)
      if (links_.session(r).up() && likely(0.2)) asked.emplace_back(commands::Hold{r, false});
    return asked;
  }

  void step(const EventList& told) {
    now_ = links_.now();
    for (std::size_t i = 0; i < robots; ++i) {
      bodies_[i].command(links_.robot(i).wheels());
      bodies_[i].step(experiment_.period());
      measured_[i] = bodies_[i].measure(now_);
    }
    const std::vector<OperatorCommand> asked = stopped_ ? std::vector<OperatorCommand>{} : ask();
    std::vector<LinkInput> inputs(robots);
    for (std::size_t i = 0; i < robots; ++i)
      inputs[i] = {.linked = true, .sent = {}, .sent_at = none, .blind_way = links_.blind_way(i)};
    TickInput input;
    input.now = now_;
    input.stop = stopped_;
    input.measurements = measured_;
    input.links = inputs;
    input.commands = asked;
    input.events = told;
    const TickRecord& record = tick_.step(input);
    judge(record, told, asked);
    if (stopped_) return;
    for (std::size_t i = 0; i < robots; ++i) {
      const core::WheelSpeeds& wheels = record.robots[i].wheels;
      if (wheels != core::WheelSpeeds{}) {
        EXPECT_LE(links_.opened_at(i), released_at_[i])
            << "robot " << i + 1 << " is driven at " << now_ << " s, and nobody has released it since its link is back";
      }
      links_.command(i, comms::clamped(static_cast<int>(wheels.left), static_cast<int>(wheels.right)));
    }
  }

  /// What became of what was asked, in the record's words.
  void judge(const TickRecord& record, const EventList& told, const std::vector<OperatorCommand>& asked) {
    std::vector<std::string> expected, said;
    const auto hold = [&](std::size_t i, bool on) {
      if (held_[i] == on) return;
      held_[i] = on;
      expected.push_back(on ? describe(events::Hold{i}) : describe(events::Release{i}));
    };
    for (const Event& event : told)
      if (const auto* const link = std::get_if<events::Link>(&event)) {
        lost_[link->robot] = link->state != LinkState::up;
        tally_.losses += lost_[link->robot] ? 1 : 0;
      }
    for (const OperatorCommand& command : asked) {
      ++tally_.requests;
      const auto* const asks = std::get_if<commands::Hold>(&command);
      if (!asks) continue;
      hold(asks->robot, asks->on);
      if (!asks->on && !lost_[asks->robot]) released_at_[asks->robot] = now_, ++tally_.releases;
    }
    for (std::size_t i = 0; i < robots; ++i)
      if (lost_[i]) hold(i, true);
    for (const Event& event : record.events)
      if (is<events::Hold, events::Release>(event)) said.push_back(describe(event));
    // Where robots begin to drive, those who are held by then are named once more.
    if (record.events.contains<events::Start>() || record.events.contains<events::Stage>()) {
      for (const std::string& one : expected)
        EXPECT_NE(std::find(said.begin(), said.end(), one), said.end()) << one << " at " << now_ << " s";
    } else {
      EXPECT_EQ(said, expected) << "at " << now_ << " s";
    }
    for (std::size_t i = 0; i < robots; ++i)
      if (held_[i]) {
        EXPECT_EQ(record.robots[i].wheels, core::WheelSpeeds{}) << "robot " << i + 1 << " at " << now_ << " s";
      }
    EXPECT_EQ(record.events.dropped(), 0u);
  }

  Experiment experiment_;
  ControlTick tick_;
  test::FailureLinks links_;
  core::Random random_;
  std::vector<core::SimulatedRobot> bodies_;
  std::vector<core::Measurement> measured_;
  double now_ = 0.0;
  bool stopped_ = false;
  std::array<bool, robots> held_{}, lost_{};
  std::array<double, robots> released_at_{};
  OperatorTally tally_;
};

TEST(OperatorChaos, NobodyIsDrivenAfterALossUnlessReleasedAndNothingThatIsAskedIsLost) {
  const int first = static_cast<int>(test::number_from_environment("SKEIN_CHAOS_SEED", 1.0));
  const int runs = static_cast<int>(test::number_from_environment("SKEIN_CHAOS_RUNS", 4.0));
  for (const double rate : {25.0, 1.0}) {
    OperatorTally all;
    for (int seed = first; seed < first + runs; ++seed) {
      SCOPED_TRACE("seed " + std::to_string(seed) + ", " + std::to_string(rate) + " Hz");
      const OperatorTally one = OperatorChaos(rate, static_cast<std::uint64_t>(seed)).run();
      all.requests += one.requests, all.losses += one.losses, all.releases += one.releases;
    }
    std::printf("%g Hz: %d requests, %d losses of links, %d releases\n", rate, all.requests, all.losses, all.releases);
    EXPECT_GT(all.losses, 5 * runs) << "or it proves little";
  }
}

}  // namespace
}  // namespace skein::app
