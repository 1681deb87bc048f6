// What a run will do, computed before it does it: the same bits for a simulation that nobody touches.
#include "app/session/forecast.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "app/controllers/adversary.h"
#include "app/experiment/experiment_file.h"
#include "app/session/session.h"
#include "tests/app/rows.h"
#include "tests/places.h"

namespace skein::app {
namespace {

using test::Rows;

Experiment platoon(const std::string& more, const std::vector<std::string>& sets = {}) {
  auto experiment = parse_experiment(paper_experiment().source + more, "forecast.toml", sets);
  EXPECT_TRUE(experiment) << experiment.error().front().message();
  return experiment.value_or(Experiment{});
}

/// Robots as bad as real ones, and something in their way.
Experiment rough(const std::string& more = {}) {
  return platoon(
      more, {"duration=26", "simulation.pose_noise=0.001", "simulation.heading_noise=0.01", "simulation.latency=0.06",
             "simulation.dropout=0.05", "simulation.slip=0.02", "obstacle=[{x=0.55,y=0.33,radius=0.04}]"});
}

std::vector<TickRecord> rows_of(const Experiment& experiment) {
  Rows rows;
  auto session = Session::open(experiment, Session::Clock::virtual_, {false, {&rows}});
  EXPECT_TRUE(session);
  (*session)->run();
  return rows.rows;
}

std::size_t row_at(const std::vector<TickRecord>& rows, double t) {
  return static_cast<std::size_t>(
      std::find_if(rows.begin(), rows.end(), [&](const TickRecord& row) { return row.t >= t - 1e-9; }) - rows.begin());
}

/// Everything until this time.
void follow(Forecast& forecast, const std::vector<TickRecord>& rows, double t) {
  for (std::size_t k = 0; k <= row_at(rows, t); ++k) forecast.follow(rows[k]);
}

/// The first row of `ahead` that is not that of the run, bit for bit; -1: none is.
int first_different(const std::vector<TickRecord>& rows, std::size_t after, const std::vector<TickRecord>& ahead) {
  const auto bits = [](const auto& value) {
    return std::bit_cast<std::array<std::uint64_t, sizeof(value) / sizeof(std::uint64_t)>>(value);
  };
  const auto same = [&](const auto& a, const auto& b) { return bits(a) == bits(b); };
  for (std::size_t k = 0; k < ahead.size(); ++k) {
    const TickRecord &is = rows.at(after + 1 + k), &was = ahead[k];
    if (!same(is.t, was.t) || !same(is.k_xx, was.k_xx) || !same(is.V, was.V)) return static_cast<int>(k);
    for (std::size_t i = 0; i < is.robots.size(); ++i) {
      const RobotRecord &a = is.robots[i], &b = was.robots[i];
      if (!same(a.truth, b.truth) || !same(a.command, b.command) || !same(a.reference.pose, b.reference.pose) ||
          !same(a.measurement.pose, b.measurement.pose) || a.mode != b.mode)
        return static_cast<int>(k);
    }
  }
  return -1;
}

TEST(Forecast, IsToTheBitWhatAnUndisturbedSimulationThenDoes) {
  const Experiment experiment = rough();
  const std::vector<TickRecord> rows = rows_of(experiment);
  Forecast forecast(experiment);
  follow(forecast, rows, 10.0);
  const std::vector<TickRecord> ahead = forecast.ahead(250, {}, {});  // over the file's kick at 18 s
  ASSERT_EQ(ahead.size(), 250U);
  EXPECT_TRUE(forecast.exact());
  EXPECT_EQ(first_different(rows, row_at(rows, 10.0), ahead), -1);
  // It has not touched what it follows.
  for (std::size_t k = row_at(rows, 10.0) + 1; k <= row_at(rows, 14.0); ++k) forecast.follow(rows[k]);
  EXPECT_EQ(first_different(rows, row_at(rows, 14.0), forecast.ahead(250, {}, {})), -1);
}

TEST(Forecast, OfAnotherGainIsTheRunInWhichTheGainIsChanged) {
  const std::vector<TickRecord> without = rows_of(rough());
  const std::vector<TickRecord> with =
      rows_of(rough("\n[[operator]]\nt = 17.0\ndoes = \"gain k_xx 0.008 -> 0.001 ramp=0.5\"\n"));
  Forecast forecast(rough());
  follow(forecast, without, 16.96);
  const OperatorCommand gain = commands::SetGain{core::GainName::k_xx, 0.001, 0.5};
  const std::vector<TickRecord> ahead = forecast.ahead(200, {&gain, 1}, {});
  const std::size_t now = row_at(with, 16.96);
  ASSERT_EQ(ahead.size(), 200U);
  EXPECT_EQ(first_different(with, now, ahead), -1);
  EXPECT_NE(first_different(without, now, ahead), -1) << "the control: the other gain must matter";
}

/// `from`: only from then on is it asked within searches. [s]
void expect_forecast_within_searches(const Experiment& experiment, double from) {
  const std::vector<TickRecord> rows = rows_of(experiment);
  Forecast forecast(experiment);
  std::size_t searched = 0;
  for (std::size_t k = 0; k + 1 < rows.size(); ++k) {
    forecast.follow(rows[k]);
    const bool searches = rows[k].planning > 0 && rows[k].t >= from;
    if (rows[k].phase != Phase::running || (!searches && k % 100 != 0) || (searches && searched++ > 20)) continue;
    const std::vector<TickRecord> ahead = forecast.ahead(50, {}, {});
    ASSERT_FALSE(ahead.empty() && rows[k + 1].phase == Phase::running) << rows[k].t;
    ASSERT_EQ(first_different(rows, k, ahead), -1) << "from " << rows[k].t << " s on";
  }
  EXPECT_GT(searched, 0U);
  EXPECT_TRUE(forecast.exact());
}

TEST(Forecast, OfPlannedRoutesIsTheRunAlsoInTheMiddleOfASearch) {
  expect_forecast_within_searches(
      platoon("", {"duration=30", "avoidance.kind=\"plan\"", "obstacle=[{x=0.55,y=0.33,radius=0.04}]"}), 0.0);
}

TEST(Forecast, OfACrowdIsTheRunAlsoWhereBetterWaysAreSoughtWhileAllDrive) {
  const auto experiment = load_experiment(test::in_source("resources/experiments/antipodal-swap-10.toml"),
                                          {"avoidance.kind=plan", "duration=12"});
  ASSERT_TRUE(experiment.has_value());
  expect_forecast_within_searches(*experiment, 4.0);
}

TEST(Forecast, OfAnotherParameterIsTheRunInWhichItIsChanged) {
  const std::vector<std::string> law{"controller.kind=\"virtual_structure\""};
  const Experiment experiment = platoon("", law);
  const auto& declared = declared_parameters(experiment.controller.law);
  ASSERT_FALSE(declared.empty());
  const LawParameter& one = declared.front();
  const double other = 0.5 * (one.value + one.high);
  const std::string name = one.name;
  const std::vector<TickRecord> without = rows_of(experiment);
  const std::vector<TickRecord> with =
      rows_of(platoon("\n[[operator]]\nt = 18.2\ndoes = \"" +
                          describe(events::Parameter{ParameterName(name), one.value, other}) + "\"\n",
                      law));
  Forecast forecast(experiment);
  follow(forecast, without, 18.16);
  const OperatorCommand set = commands::SetParameter{ParameterName(name), one.value, other};
  const std::vector<TickRecord> ahead = forecast.ahead(200, {&set, 1}, {});
  ASSERT_EQ(ahead.size(), 200U);
  EXPECT_EQ(first_different(with, row_at(with, 18.16), ahead), -1);
  EXPECT_NE(first_different(without, row_at(with, 18.16), ahead), -1) << "the control: the other value must matter";
}

TEST(Forecast, EndsWithTheRunAndIsEmptyAfterIt) {
  const Experiment experiment = platoon("", {"duration=4"});
  const std::vector<TickRecord> rows = rows_of(experiment);
  Forecast forecast(experiment);
  EXPECT_TRUE(forecast.ahead(10, {}, {}).empty()) << "nothing was seen of the run";
  follow(forecast, rows, 3.0);
  EXPECT_EQ(forecast.ahead(250, {}, {}).size(), 24U) << "3.04 to 3.96 s";
  for (std::size_t k = row_at(rows, 3.0) + 1; k < rows.size(); ++k) forecast.follow(rows[k]);
  EXPECT_TRUE(forecast.ahead(250, {}, {}).empty());

  Forecast stopped(experiment);
  follow(stopped, rows, 2.0);
  TickRecord stop = rows[row_at(rows, 2.0) + 1];
  stop.phase = Phase::stopped;
  stop.events.add(events::Stop{});
  stopped.follow(stop);
  EXPECT_TRUE(stopped.ahead(250, {}, {}).empty());
}

TEST(Forecast, IsGivenUpAtTheNextTick) {
  const Experiment experiment = platoon("");
  const std::vector<TickRecord> rows = rows_of(experiment);
  Forecast forecast(experiment);
  follow(forecast, rows, 2.0);
  int asked = 0;
  EXPECT_TRUE(forecast.ahead(250, {}, [&] { return ++asked < 5; }).empty());
  EXPECT_EQ(asked, 5);
  EXPECT_EQ(forecast.ahead(250, {}, {}).size(), 250U);
}

TEST(Forecast, ThatMissedARecordDrivesAsTheModelDoes) {
  const Experiment experiment = platoon("", {"duration=26"});  // ideal robots: the model is what they are
  const std::vector<TickRecord> rows = rows_of(experiment);
  Forecast forecast(experiment);
  const std::size_t now = row_at(rows, 6.0);
  for (std::size_t k = 0; k <= now; ++k)
    if (k != 20) forecast.follow(rows[k]);
  EXPECT_FALSE(forecast.exact());
  const std::vector<TickRecord> ahead = forecast.ahead(250, {}, {});
  ASSERT_EQ(ahead.size(), 250U);
  double away = 0.0, way = 0.0;
  for (std::size_t i = 0; i < 4; ++i) {
    away = std::max(away, core::distance(ahead.back().robots[i].truth, rows[now + 250].robots[i].truth));
    way = std::max(way, core::distance(rows[now].robots[i].truth, rows[now + 250].robots[i].truth));
  }
  EXPECT_LT(away, 0.005);
  EXPECT_GT(way, 0.2) << "the control: robots that stand would be so far away";
}

TEST(Forecast, SaysWhatItCannotCompute) {
  EXPECT_FALSE(Forecast::impossible(platoon("")));
  EXPECT_FALSE(Forecast::impossible(platoon("", {"avoidance.kind=\"plan\""})));
  EXPECT_TRUE(Forecast::impossible(platoon("", {"controller.command=\"true\""})));
  EXPECT_FALSE(Forecast::impossible(platoon("", {"controller.command=\"true\"", "controller.preview=true"})));
}

std::string law_program() {
  return std::filesystem::path(test::program()).replace_filename("skein_test_law").string();
}
std::vector<std::string> own_law(const std::string& command) {
  return {"controller.command=\"" + command + "\"", "controller.preview=true"};
}
/// It does this where it is started for a preview, and drives otherwise.
std::vector<std::string> law_whose_preview(const std::string& does) {
  return own_law("sh -c 'test -z \\\"$SKEIN_PREVIEW\\\" || " + does + "; exec " + law_program() + "'");
}

TEST(Forecast, OfAControllerOfTheUsersOwnAsksASecondProcess) {
  const std::vector<std::string> law = own_law(law_program());
  const auto changed = [](double t, const std::string& what) {
    return "\n[[operator]]\nt = " + std::to_string(t) + "\ndoes = \"parameter " + what + "\"\n";
  };
  // Changed once before: the second process has to know.
  const std::string before = changed(5.0, "k_y 8 -> 12");
  const std::vector<TickRecord> without = rows_of(platoon(before, law));
  const std::vector<TickRecord> with = rows_of(platoon(before + changed(18.2, "k_x 2 -> 0.5"), law));
  const std::vector<TickRecord> never = rows_of(platoon(changed(18.2, "k_x 2 -> 0.5"), law));
  Forecast forecast(platoon("", law));
  follow(forecast, without, 18.16);
  const OperatorCommand set = commands::SetParameter{ParameterName("k_x"), 2.0, 0.5};
  const std::size_t now = row_at(with, 18.16);
  EXPECT_TRUE(forecast.ahead(200, {&set, 1}, {}).empty()) << "there is no process yet";
  for (int again = 0; again < 2; ++again) {
    forecast.prepare({});
    const std::vector<TickRecord> ahead = forecast.ahead(200, {&set, 1}, {});
    ASSERT_EQ(ahead.size(), 200U) << forecast.failure();
    EXPECT_TRUE(forecast.exact());
    EXPECT_EQ(first_different(with, now, ahead), -1);
    EXPECT_NE(first_different(without, now, ahead), -1) << "the control: the other value must matter";
    EXPECT_NE(first_different(never, now, ahead), -1) << "and so must the change before";
  }
  EXPECT_TRUE(forecast.ahead(200, {&set, 1}, {}).empty()) << "a process that was asked is not asked again";
}

TEST(Forecast, SaysWhyASecondProcessGaveNone) {
  const std::vector<TickRecord> rows = rows_of(platoon("", {"duration=20"}));
  const auto failure = [&](const std::string& does) {
    Forecast forecast(platoon("", law_whose_preview(does)));
    follow(forecast, rows, 0.2);
    forecast.prepare({});
    const bool none = forecast.ahead(60, {}, {}).empty();
    EXPECT_EQ(none, !forecast.failure().empty()) << does;
    return forecast.failure();
  };
  const auto adversary = [](Adversary kind) {
    std::uint64_t seed = 0;
    while (adversary_of(seed) != kind) ++seed;
    return "exec " + test::program() + " controller-host --adversary " + std::to_string(seed);
  };
  EXPECT_EQ(failure("true"), "") << "the control: it drives";
  EXPECT_THAT(failure("exit 3"), testing::HasSubstr("it exited with status 3"));
  EXPECT_THAT(failure(adversary(Adversary::hang)), testing::HasSubstr("has no answer within 2 s"));
  EXPECT_THAT(failure(adversary(Adversary::crash)), testing::HasSubstr("the controller is gone"));
}

TEST(Forecast, DoesNotWaitForAProcessThatIsNoLongerWanted) {
  Forecast forecast(platoon("", law_whose_preview("exec sleep 1000")));
  int asked = 0;
  forecast.prepare([&] { return ++asked < 3; });
  EXPECT_EQ(asked, 4) << "the last time, whether anybody still asks why it failed";
  EXPECT_EQ(forecast.failure(), "");
}

}  // namespace
}  // namespace skein::app
