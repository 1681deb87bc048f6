// The tick allocates nothing, and what reads long runs little: counted in a program of its own, which replaces operator
// new.
#include <gtest/gtest.h>

#include <atomic>
#include <cmath>
#include <cstdlib>
#include <new>
#include <string>
#include <vector>

#include "app/experiment/experiment_file.h"
#include "app/session/record_channel.h"
#include "app/tick/control_tick.h"
#include "core/estimation/identification.h"
#include "core/simulation/simulated_robot.h"
#include "tests/places.h"

namespace {
std::atomic<long> allocations{0}, bytes{0};
}

// Not inlined: GCC would see malloc paired with delete, and warn.
[[gnu::noinline]] void* operator new(std::size_t size) {
  allocations.fetch_add(1, std::memory_order_relaxed);
  bytes.fetch_add(static_cast<long>(size), std::memory_order_relaxed);
  if (void* memory = std::malloc(size)) return memory;
  throw std::bad_alloc();
}
[[gnu::noinline]] void operator delete(void* memory) noexcept {
  std::free(memory);
}
[[gnu::noinline]] void operator delete(void* memory, std::size_t) noexcept {
  std::free(memory);
}

namespace skein::app {
namespace {

/// It goes through them some hundred times.
TEST(Allocation, IdentificationTakesFewTimesTheMemoryOfItsPoses) {
  core::IdentificationInput input;
  for (int k = 0; k < 3000; ++k) {
    const double t = 0.04 * k, way = 0.05 * t, step = 1000.0 * way / (core::pi * input.believed.wheel_diameter);
    input.wheels.push_back({t, step * (1.0 + 0.1 * std::sin(t)), step});
    input.poses.push_back({t, {way, 1e-3 * std::sin(7.0 * k), 1e-3 * std::cos(5.0 * k)}});
  }
  const long before = bytes;
  const core::Identification found = core::identify(input);
  EXPECT_LT(bytes - before, 6 * static_cast<long>(input.poses.size() * sizeof(input.poses.front())));
  EXPECT_EQ(found.innovations.size(), input.poses.size() - 1);
}

TEST(Allocation, TheTickAndItsChannelAllocateNothing) {
  Experiment experiment = paper_experiment();
  // Everything that a tick can be busy with: avoidance, shield, limits, gains on their way, a robot that comes and
  // goes.
  experiment.obstacles = {{0.3, -0.45, 0.05}};
  GainChange change;
  change.t = 1.0;
  change[core::GainName::k_xx] = core::PairTable(4, 0.002);
  change[core::GainName::l_xx] = core::PairTable(4, 150.0);
  experiment.gain_changes = {change};
  experiment.failure.runaway = FailureSpec::Runaway::ignored;  // these poses follow no commands
  experiment.camera.source = "synthetic";                      // which is bumped in the end
  experiment.failure.camera_moved = FailureSpec::CameraMoved::go_on;
  ControlTick tick(experiment);
  RecordChannel channel(8, tick.record());
  const auto reference = make_reference(experiment);

  std::vector<core::Measurement> measurements(4);
  std::vector<core::Pose> truth(4);
  const OperatorCommand start = commands::Start{};
  const OperatorCommand gain = commands::SetGain{core::GainName::k_yy, 1.0};
  const OperatorCommand pairs[] = {commands::SetPairGain{2, 0, core::GainName::k_tt, 0.01},
                                   commands::Couple{1, 2, false}, commands::Couple{2, 1, true}};

  const long before = allocations.load();
  int avoided = 0, shielded_ticks = 0, limited_ticks = 0, lost_ticks = 0, bumps = 0;
  for (int k = 0; k < 1500; ++k) {
    const double now = k / 25.0;
    for (std::size_t i = 0; i < 4; ++i) {
      core::Pose pose = reference->at(i, now).pose;
      if (k > 200 && (k < 1200 || k > 1350) && i == 1) pose.x += 0.12 * std::sin(0.01 * k);  // through its neighbours
      if (k > 700 && i == 2) pose.y += pose.y > 0.0 ? -0.6 : 0.6;  // far off, but inside the arena
      const core::Pose seen{k < 1300 ? pose.x : pose.x + 0.05, pose.y, pose.theta};
      if (k < 900 || i != 3) measurements[i] = {seen, now};
      truth[i] = pose;
    }
    TickInput input;
    input.now = now;
    input.measurements = measurements;
    input.truth = truth;
    if (k == 0) input.commands = {&start, 1};
    if (k == 500) input.commands = {&gain, 1};
    if (k >= 501 && k < 504) input.commands = {&pairs[k - 501], 1};
    const TickRecord& record = tick.step(input);
    bumps += record.events.contains<events::CameraMoved>() ? 1 : 0;
    channel.push(record);
    channel.drain([](const TickRecord&) {});
    for (const RobotRecord& robot : record.robots) {
      avoided += robot.is(avoiding);
      shielded_ticks += robot.is(shielded);
      limited_ticks += robot.is(limited);
      lost_ticks += robot.is(lost);
    }
  }
  EXPECT_EQ(allocations.load() - before, 0);
  EXPECT_GT(avoided, 0);
  EXPECT_GT(shielded_ticks, 0);
  EXPECT_GT(limited_ticks, 0);
  EXPECT_GT(lost_ticks, 0);
  EXPECT_EQ(bumps, 1);
}

/// Of parameters that the file names, of others that the controller has declared, and of one beyond those.
TEST(Allocation, AChangeOfALawsParametersIsNone) {
  Experiment experiment = paper_experiment();
  experiment.controller.law.command = "mine";
  experiment.controller.law.own_parameters = {{"k0", 1.0}};
  ControlTick tick(experiment);
  std::vector<OperatorCommand> commands;
  for (std::size_t k = 0; k <= most_parameters; ++k)
    commands.emplace_back(commands::SetParameter{ParameterName("k" + std::to_string(k)), 1.0, 2.0});
  const std::vector<core::Measurement> measurements(4);
  const std::vector<core::Pose> truth(4);
  const long before = allocations.load();
  TickInput input;
  input.measurements = measurements;
  input.truth = truth;
  input.commands = commands;
  const std::size_t changes = tick.step(input).events.size();
  EXPECT_EQ(allocations.load() - before, 0);
  EXPECT_EQ(changes, most_parameters);
}

/// Two cameras with frames out of step, one of which says at times what the other contradicts.
TEST(Allocation, TheFusionOfSeveralCamerasIsNothing) {
  Experiment experiment = paper_experiment();
  experiment.camera.source = "synthetic";
  experiment.camera.also = {experiment.camera};
  experiment.failure.camera_moved = FailureSpec::CameraMoved::go_on;
  ControlTick tick(experiment);
  RecordChannel channel(8, tick.record());
  const auto reference = make_reference(experiment);
  std::vector<core::Measurement> measurements(8);
  const OperatorCommand start = commands::Start{};
  const long before = allocations.load();
  int disagreements = 0, kidnaps = 0;
  for (int k = 0; k < 600; ++k) {
    const double now = k / 25.0;
    for (std::size_t i = 0; i < 4; ++i)
      for (std::size_t camera = 0; camera < 2; ++camera) {
        const double at = camera == 0 ? now : std::max(0.0, now - 0.05);
        core::Pose pose = reference->at(i, at).pose;
        if (camera == 1 && i == 2 && k > 300 && k < 320) pose.y += 0.05;
        measurements[4 * camera + i] = {pose, at, 1e-4, 1e-3, core::How::tracked};
      }
    TickInput input;
    input.now = now;
    input.measurements = measurements;
    if (k == 0) input.commands = {&start, 1};
    const TickRecord& record = tick.step(input);
    for (const Event& event : record.events) {
      disagreements += is<events::CamerasDisagree>(event) ? 1 : 0;
      kidnaps += is<events::Kidnap>(event) ? 1 : 0;
    }
    channel.push(record);
    channel.drain([](const TickRecord&) {});
  }
  EXPECT_EQ(allocations.load() - before, 0);
  EXPECT_EQ(disagreements, 1);
  EXPECT_EQ(kidnaps, 0);
}

/// Every kind of reference, with everything that it can be busy with.
class AllocationOf : public testing::TestWithParam<const char*> {};

TEST_P(AllocationOf, AReferenceIsNothing) {
  const auto experiment = parse_experiment(GetParam(), "e.toml");
  ASSERT_TRUE(experiment) << experiment.error().front().message();
  ControlTick tick(*experiment);
  const std::size_t n = experiment->robots.size();
  std::vector<core::Measurement> measurements(n);
  const OperatorCommand start = commands::Start{};
  const auto reference = make_reference(*experiment);
  const long before = allocations.load();
  for (int k = 0; k < 600; ++k) {
    const double now = k / 25.0;
    for (std::size_t i = 0; i < n; ++i) measurements[i] = {reference->at(i, now).pose, now};
    TickInput input;
    input.now = now;
    input.measurements = measurements;
    if (k == 0) input.commands = {&start, 1};
    tick.step(input);
  }
  EXPECT_EQ(allocations.load() - before, 0);
}

INSTANTIATE_TEST_SUITE_P(
    References, AllocationOf,
    testing::Values(
        "reference.kind = 'platoon'",
        "[reference]\nkind = 'formation'\nspeed = 0.03\nshape = 'v'\nspacing = 0.15\npath = { shape = "
        "'ellipse', width = 1.2, height = 0.8 }\nchange = [{ t = 3, duration = 15, shape = 'v', spacing = 0.2 }]",
        "[reference]\nkind = 'independent'\nmay_meet = true\n[[robot]]\ntrajectory = { path = { shape = "
        "'line', from = [-0.5, 0], to = [0.5, 0] }, turn_rate = 0.5 }\n[[robot]]\ntrajectory = { path = { shape "
        "= 'spline', points = [[0.5, 0.3], [0, 0], [-0.5, 0.3]] } }\n[[robot]]\ntrajectory = { path = { "
        "shape = 'circle', radius = 0.2, centre = [0, 0.4] } }"));

/// Drives an experiment on simulated robots, from wherever they stand, and counts what its ticks allocate; how often
/// somebody was found stuck is told as well.
long allocated(const Experiment& e, int ticks, int& deadlocks, int& staging_ticks) {
  ControlTick tick(e);
  const auto reference = make_reference(e);
  const std::size_t n = e.robots.size();
  std::vector<core::SimulatedRobot> robots;
  for (std::size_t i = 0; i < n; ++i) {
    robots.emplace_back(e.robots[i].drive, e.robots[i].motor, e.simulation, e.seed, i);
    robots.back().place(e.robots[i].start.value_or(reference->at(i, 0.0).pose));
  }
  std::vector<core::Measurement> measurements(n);
  const OperatorCommand begin = e.robots[0].start ? OperatorCommand(commands::Stage{}) : commands::Start{};
  const OperatorCommand start = commands::Start{};
  const long before = allocations.load();
  for (int k = 0; k < ticks; ++k) {
    TickInput input;
    input.now = k * e.period();
    for (std::size_t i = 0; i < n; ++i) measurements[i] = robots[i].measure(input.now);
    input.measurements = measurements;
    if (k == 0) input.commands = {&begin, 1};
    if (k > 0 && tick.record().phase == Phase::ready) input.commands = {&start, 1};
    const TickRecord& record = tick.step(input);
    staging_ticks += record.phase == Phase::staging;
    for (const Event& event : record.events) deadlocks += is<events::Deadlock>(event);
    for (std::size_t i = 0; i < n; ++i) {
      robots[i].command(record.robots[i].wheels);
      robots[i].step(e.period());
    }
  }
  return allocations.load() - before;
}

TEST(Allocation, DetoursDeadlocksAndStagingAllocateNothing) {
  const std::string swap = test::in_source("resources/experiments/antipodal-swap-10.toml");
  int deadlocks = 0, staging_ticks = 0;
  EXPECT_EQ(allocated(*load_experiment(swap), 700, deadlocks, staging_ticks), 0);
  EXPECT_EQ(deadlocks + staging_ticks, 0);
  // The field alone, which does jam.
  EXPECT_EQ(allocated(*load_experiment(swap, {"avoidance.horizon=0"}), 700, deadlocks, staging_ticks), 0);
  EXPECT_GT(deadlocks, 0);
  EXPECT_EQ(allocated(*load_experiment(swap, {"avoidance.kind=plan"}), 700, deadlocks, staging_ticks), 0);
  Experiment planned = paper_experiment();  // kicked by hand, and with obstacles on its way
  planned.avoidance.kind = core::AvoidanceKind::plan;
  planned.obstacles = {{0.3, 0.47, 0.03}, {0.65, 0.0, 0.03}};
  EXPECT_EQ(allocated(planned, 900, deadlocks, staging_ticks), 0);
  Experiment platoon = paper_experiment();
  for (std::size_t i = 0; i < 4; ++i)
    platoon.robots[i].start = core::Pose{-0.3 + 0.2 * static_cast<double>(i), 0.1, 1.0};
  EXPECT_EQ(allocated(platoon, 900, deadlocks, staging_ticks), 0);
  EXPECT_GT(staging_ticks, 0);
}

TEST(Allocation, TrackingGainsOnTheirWayAllocateNothing) {
  Experiment experiment = paper_experiment();
  experiment.controller.policy = core::GainPolicy::fixed;
  experiment.controller.k_x = 0.024;
  experiment.controller.k_theta = 0.3;
  GainChange change;
  change.t = 1.0;
  change.tracking[core::TrackingGain::k_x].assign(4, 0.02);
  experiment.gain_changes = {change};
  ControlTick tick(experiment);
  const auto reference = make_reference(experiment);
  std::vector<core::Measurement> measurements(4);
  const OperatorCommand start = commands::Start{};
  const long before = allocations.load();
  for (int k = 0; k < 100; ++k) {
    const double now = k / 25.0;
    for (std::size_t i = 0; i < 4; ++i) measurements[i] = {reference->at(i, now).pose, now};
    TickInput input;
    input.now = now;
    input.measurements = measurements;
    if (k == 0) input.commands = {&start, 1};
    tick.step(input);
  }
  EXPECT_EQ(allocations.load(), before);
  EXPECT_DOUBLE_EQ(tick.record().robots[0].k_x, 0.02) << "it never moved";
}

}  // namespace
}  // namespace skein::app
