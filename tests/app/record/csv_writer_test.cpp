// The CSV: its exact text, and that it reads back to the same bits.
#include "app/record/csv_writer.h"

#include <bit>
#include <sstream>

#include "app/experiment/experiment_file.h"
#include "app/record/csv_reader.h"
#include "tests/app/fixture.h"
#include "tests/property.h"

namespace skein::app {
namespace {

Experiment robots(std::size_t n, std::string source = "name = \"x\"\n") {
  Experiment e;
  e.name = "x";
  e.seed = 42;
  e.robots.resize(n);
  e.source = std::move(source);
  return e;
}

std::string csv(const Experiment& e, const std::vector<TickRecord>& rows) {
  std::ostringstream out;
  CsvWriter writer(out, e);
  for (const TickRecord& row : rows) writer.record(row);
  return out.str();
}

std::vector<TickRecord> read(const std::string& text) {
  std::istringstream in(text);
  auto reader = CsvReader::open(in, "run.csv");
  EXPECT_TRUE(reader) << reader.error();
  std::vector<TickRecord> rows;
  TickRecord row;
  for (;;) {
    const auto more = reader->next(row);
    EXPECT_TRUE(more) << more.error();
    if (!more || !*more) return rows;
    rows.push_back(row);
  }
}

std::string read_error(const std::string& text) {
  std::istringstream in(text);
  auto reader = CsvReader::open(in, "run.csv");
  if (!reader) return reader.error();
  TickRecord row;
  for (;;) {
    const auto more = reader->next(row);
    if (!more) return more.error();
    if (!*more) return "";
  }
}

/// A row in which every value is another one.
TickRecord numbered(std::size_t n) {
  TickRecord row;
  double next = 1.0;
  const auto value = [&] { return next++ / 8.0; };
  row.t = value();
  row.tick = 25;
  row.k_xx = value(), row.k_tt = value(), row.k_yy = value(), row.V = value(), row.V_dot = -value();
  for (std::size_t i = 0; i + 1 < n; ++i) row.delta.push_back(value());
  row.min_distance = value();
  row.period = value();
  row.events.add(events::Perturb{1, 0.05, -0.15, 0.0});
  row.events.add(events::Lost{0});
  for (std::size_t i = 0; i < n; ++i) {
    RobotRecord robot;
    robot.pose = {value(), value(), value()};
    if (i == 0) robot.truth = {value(), value(), value()};
    robot.nominal = {{value(), value(), value()}, {value(), value()}};
    robot.reference = {{value(), value(), value()}, {value(), value()}};
    if (i == 0) robot.error = {value(), value(), value()};
    robot.law = {value(), value()};
    robot.command = {value(), value()};
    robot.wheels = {value(), value()};
    robot.mode = i == 0 ? tracking | limited : stopped | lost;
    robot.limits = i == 0 ? limit_v | limit_wheels : 0;
    if (i == 0)
      robot.pose_age = value(),
      robot.measurement = {{value(), value(), value()}, value(), value(), value(), core::How::tracked},
      robot.actuation_delay = 0.0625;
    row.robots.push_back(robot);
  }
  row.latency[Stage::capture] = value(), row.latency.total = value();
  row.now = value();
  return row;
}

TEST(CsvWriter, WritesExactlyWhatTheContractSays) {
  EXPECT_EQ(
      csv(robots(2, "name = \"x\"\n\n# end\n"), {numbered(2)}),
      "# skein " SKEIN_VERSION
      "\n# experiment: x\n# hash: 4eefc1c6185f8c8b\n# seed: 42\n#| name = \"x\"\n#| \n#| # end\n"
      "t,tick,k_xx,k_tt,k_yy,V,V_dot,delta_1_2,min_distance,period,compute_time,event,"
      "r1_x,r1_y,r1_theta,r1_x_true,r1_y_true,r1_theta_true,r1_x_nom,r1_y_nom,r1_theta_nom,r1_v_nom,r1_omega_nom,"
      "r1_x_ref,r1_y_ref,r1_theta_ref,r1_v_ref,r1_omega_ref,r1_x_e,r1_y_e,r1_theta_e,r1_v_law,r1_omega_law,"
      "r1_v,r1_omega,r1_wheel_left,r1_wheel_right,r1_mode,r1_pose_age,r1_x_meas,r1_y_meas,r1_theta_meas,r1_t_meas,r1_"
      "sigma_xy,r1_sigma_theta,r1_actuation_delay,r1_how,"
      "r1_link,r1_link_rtt,r1_battery,r1_left_steps,r1_right_steps,r1_limit,"
      "r1_link_rtt_p99,r1_link_bytes,r1_link_losses,r1_link_reconnects,"
      "r2_x,r2_y,r2_theta,r2_x_true,r2_y_true,r2_theta_true,r2_x_nom,r2_y_nom,r2_theta_nom,r2_v_nom,r2_omega_nom,"
      "r2_x_ref,r2_y_ref,r2_theta_ref,r2_v_ref,r2_omega_ref,r2_x_e,r2_y_e,r2_theta_e,r2_v_law,r2_omega_law,"
      "r2_v,r2_omega,r2_wheel_left,r2_wheel_right,r2_mode,r2_pose_age,r2_x_meas,r2_y_meas,r2_theta_meas,r2_t_meas,r2_"
      "sigma_xy,r2_sigma_theta,r2_actuation_delay,r2_how,"
      "r2_link,r2_link_rtt,r2_battery,r2_left_steps,r2_right_steps,r2_limit,"
      "r2_link_rtt_p99,r2_link_bytes,r2_link_losses,r2_link_reconnects,"
      "latency_capture,latency_dequeue,latency_detect,latency_hand_over,latency_estimate,latency_law,latency_write,"
      "latency_acknowledge,latency_total,now\n"
      "0.125,25,0.25,0.375,0.5,0.625,-0.75,0.875,1,1.125,,perturb r2 dx=0.05 dy=-0.15 dtheta=0; lost r1,"
      "1.25,1.375,1.5,1.625,1.75,1.875,2,2.125,2.25,2.375,2.5,2.625,2.75,2.875,3,3.125,3.25,3.375,3.5,3.625,3.75,"
      "3.875,4,4.125,4.25,tracking+limited,4.375,4.5,4.625,4.75,4.875,5,5.125,"
      "0.0625,tracked,,,,,,v+wheels,,,,,"
      "5.25,5.375,5.5,,,,5.625,5.75,5.875,6,6.125,6.25,6.375,6.5,6.625,6.75,,,,6.875,7,7.125,7.25,7.375,7.5,"
      "stopped+lost,,,,,,,,,,,,,,,,,,,,7.625,,,,,,,,7.75,7.875\n");
}

TEST(CsvWriter, WritesNothingWhereThereIsNoValue) {
  TickRecord row;
  row.robots.resize(1);
  const std::string text = csv(robots(1), {row});
  EXPECT_EQ(text.find("nan"), std::string::npos);
  EXPECT_EQ(text.find("-1e"), std::string::npos) << "the time of a measurement that never was";
}

TEST(CsvWriter, WritesGainsOfPairsWhereTheyDiffer) {
  Experiment e = robots(3);
  TickRecord row = numbered(3);
  row.pair_gains.fill(core::PairTable(3, 0.0));
  for (const core::GainName gain : core::gain_names)
    row.pair_gains[static_cast<std::size_t>(gain)].fill(row.gain(gain));
  EXPECT_EQ(csv(e, {row}).find("k_xx_1_2"), std::string::npos) << "all pairs have the same";
  e.controller.gains.k_xx = core::PairTable(3, 0.01);
  e.controller.gains.k_xx.set(0, 2, 0.0);
  row.pair_gains[0].set(0, 2, 0.03125);
  const std::string text = csv(e, {row});
  EXPECT_NE(text.find(",k_xx_1_2,k_xx_1_3,k_xx_2_3,k_tt_1_2,k_tt_1_3,k_tt_2_3,k_yy_1_2,k_yy_1_3,k_yy_2_3,now\n"),
            std::string::npos);
  std::istringstream in(text);
  auto reader = CsvReader::open(in, "run.csv");
  TickRecord read;
  ASSERT_TRUE(reader->next(read).value());
  EXPECT_EQ(reader->cell("k_xx_1_2"), "");
  EXPECT_EQ(reader->cell("k_xx_1_3"), "0.03125");
  EXPECT_EQ(read.pair_gains, row.pair_gains);
  EXPECT_EQ(read.pair_gain(core::GainName::k_xx, 2, 0), 0.03125);
}

TEST(CsvWriter, WritesTheLagOfAFormationThatWaits) {
  Experiment e = robots(1);
  TickRecord row;
  row.robots.resize(1);
  row.lag = 1.25;
  EXPECT_EQ(csv(e, {row}).find("lag"), std::string::npos);
  e.avoidance.formation_waits = true;
  const std::string text = csv(e, {row});
  EXPECT_NE(text.find(",lag,now\n"), std::string::npos);
  EXPECT_EQ(read(text).at(0).lag, 1.25);
}

TEST(CsvReader, ReadsTheHead) {
  std::istringstream in(csv(robots(3, "name = \"x\"\n\n  # end\n"), {}));
  const auto reader = CsvReader::open(in, "run.csv");
  ASSERT_TRUE(reader) << reader.error();
  EXPECT_EQ(reader->head().version, SKEIN_VERSION);
  EXPECT_EQ(reader->head().name, "x");
  EXPECT_EQ(reader->head().seed, 42u);
  EXPECT_EQ(reader->head().source, "name = \"x\"\n\n  # end\n");
  EXPECT_TRUE(reader->head().intact);
  EXPECT_EQ(reader->robots(), 3u);
  EXPECT_EQ(reader->columns().front(), "t");
}

TEST(CsvReader, NoticesAnExperimentThatSomebodyEdited) {
  std::string text = csv(robots(1), {});
  text.replace(text.find("#| name"), 7, "#| nome");
  std::istringstream in(text);
  EXPECT_FALSE(CsvReader::open(in, "run.csv")->head().intact);
}

/// A copy without the lines before the header row is not one of the paper's experiment.
TEST(CsvReader, WithoutAnExperimentThereIsNone) {
  const std::string text = csv(robots(4), {});
  std::istringstream in(text), plain(text.substr(text.find("\nt,") + 1));
  EXPECT_EQ(CsvReader::open(plain, "run.plain.csv")->experiment().error(),
            "run.plain.csv: there is no experiment before the header row, as in a copy by `skein export --to csv`, "
            "allowed: the CSV that `skein run --csv` wrote");
  std::istringstream empty(csv(robots(4, ""), {}));
  EXPECT_TRUE(CsvReader::open(empty, "run.csv")->experiment()) << "the control: one whose text is empty";
}

TEST(CsvReader, FindsCellsByName) {
  std::istringstream in(csv(robots(2), {numbered(2)}));
  auto reader = CsvReader::open(in, "run.csv");
  TickRecord row;
  ASSERT_TRUE(reader->next(row).value());
  EXPECT_EQ(reader->cell("r1_mode"), "tracking+limited");
  EXPECT_EQ(reader->cell("compute_time"), "");
  EXPECT_EQ(reader->cell("no_such_column"), "");
  ASSERT_EQ(row.events.size(), 2u);
  EXPECT_TRUE(is<events::Perturb>(*row.events.begin()));
  EXPECT_EQ(robot_of(*row.events.begin()), 1u);
  EXPECT_EQ(std::get<events::Perturb>(*row.events.begin()).dy, -0.15);
}

TEST(CsvReader, SaysWhereAFileIsBroken) {
  EXPECT_EQ(read_error(""), "run.csv: it is empty, allowed: a CSV written by `skein run --csv`");
  EXPECT_EQ(read_error("# skein 1\n# seed: x\n"), "run.csv:2: the seed is not a whole number");
  EXPECT_EQ(read_error("a,b\n1,2\n"),
            "run.csv:1: the header row has no column t, allowed: a CSV written by `skein run --csv`");
  EXPECT_EQ(read_error("t,tick,r1_x\n1,2,3\n1,2\n"), "run.csv:3: found 2 cells, allowed: 3 as in the header row");
  EXPECT_EQ(read_error("t,tick,r1_x\n1,2,3x\n"),
            "run.csv:2: column r1_x: found \"3x\", allowed: a number from -1e9 to 1e9, or nothing");
  EXPECT_EQ(read_error("t,tick,r1_x\n1,2.5,3\n"), "run.csv:2: column tick: found \"2.5\", allowed: a whole number");
  EXPECT_EQ(read_error("t,tick,r1_x,r1_mode\n1,2,3,flying\n"),
            "run.csv:2: column r1_mode: found \"flying\", allowed: modes joined by +");
  EXPECT_EQ(read_error("t,tick,r1_x,event\n1,2,3,boo\n"),
            "run.csv:2: column event: found \"boo\", allowed: events joined by \"; \"");
  EXPECT_EQ(read_error("t,tick,r1_x,r1_how\n1,2,3,seen\n"),
            "run.csv:2: column r1_how: found \"seen\", allowed: detected, tracked, recovered or nothing");
  EXPECT_EQ(read_error("t,tick,r1_x,r1_limit\n1,2,3,speed\n"),
            "run.csv:2: column r1_limit: found \"speed\", allowed: v, omega, wheels and link, joined by +");
  EXPECT_EQ(read_error("other,t,tick,r1_x\r\nhello,1,2,3\r\n"), "") << "unknown columns and Windows line ends";
}

TEST(CsvReader, ReadsAFileThatAnotherProgramSavedWithTheLineEndsOfWindowsAndAByteOrderMark) {
  std::string text = "\xEF\xBB\xBF";
  for (const char c : csv(robots(2), {numbered(2)})) text += c == '\n' ? std::string("\r\n") : std::string(1, c);
  std::istringstream in(text), original(csv(robots(2), {numbered(2)}));
  auto reader = CsvReader::open(in, "run.csv");
  ASSERT_TRUE(reader) << reader.error();
  EXPECT_TRUE(reader->head().intact) << "the experiment is said to have been changed";
  EXPECT_EQ(reader->head().source, CsvReader::open(original, "run.csv")->head().source);
  TickRecord row;
  EXPECT_TRUE(reader->next(row).value());
  EXPECT_FALSE(reader->next(row).value());
  EXPECT_FALSE(reader->torn());
  EXPECT_EQ(reader->whole_bytes(), text.size());
}

TEST(CsvReader, KeepsLineEndsOfWindowsThatTheExperimentHasOfItsOwn) {
  std::istringstream in("# skein 1\n#| name = \"x\"\r\nt,tick,r1_x\n1,2,3\n");
  EXPECT_EQ(CsvReader::open(in, "run.csv")->head().source, "name = \"x\"\r\n") << "its hash is of these";
}

TEST(CsvReader, ReadsUpToATornRowAndSaysSo) {
  for (const std::string& tail : {std::string("2,3"), std::string("2,3,4"), std::string("\0\0\0\0", 4)}) {
    std::istringstream in("t,tick,r1_x\n1,2,3\n" + tail);
    auto reader = CsvReader::open(in, "run.csv");
    ASSERT_TRUE(reader);
    TickRecord row;
    EXPECT_TRUE(*reader->next(row));
    EXPECT_FALSE(reader->torn());
    const auto more = reader->next(row);
    ASSERT_TRUE(more) << more.error();
    EXPECT_FALSE(*more);
    ASSERT_TRUE(reader->torn()) << tail;
    EXPECT_NE(reader->torn()->find("run.csv:3"), std::string::npos) << *reader->torn();
    EXPECT_EQ(reader->whole_bytes(), 18u);
  }
}

TEST(CsvReader, ACommandThatItPrintsHoldsForANameWithABlank) {
  std::istringstream in("t,tick,r1_x\n1,2,3\n2,3");
  auto reader = CsvReader::open(in, "lab one/it's.csv");
  ASSERT_TRUE(reader);
  TickRecord row;
  while (*reader->next(row)) {
  }
  ASSERT_TRUE(reader->torn());
  EXPECT_NE(reader->torn()->find("`skein replay 'lab one/it'\\''s.csv' --repair`"), std::string::npos)
      << *reader->torn();
}

TEST(CsvReader, HasLimits) {
  std::string header = "t,tick";
  for (int i = 1; i <= 65; ++i) header += ",r" + std::to_string(i) + "_x";
  EXPECT_EQ(read_error(header + "\n"), "run.csv:1: the header row has more than 64 robots, allowed: 1 to 64");
  for (const char* number : {"inf", "nan", "-inf", "1e300", "1.1e9"})
    EXPECT_EQ(read_error(std::string("t,tick,r1_x\n1,2,") + number + "\n"),
              std::string("run.csv:2: column r1_x: found \"") + number +
                  "\", allowed: a number from -1e9 to 1e9, or nothing");
}

bool same(double a, double b) {
  return std::bit_cast<std::uint64_t>(a) == std::bit_cast<std::uint64_t>(b) || (std::isnan(a) && std::isnan(b));
}

TEST(CsvReader, ReadsBackTheSameBits) {
  test::holds("every double survives", [] {
    // Of every size that the reader takes: more than 1e9, inf and nan are refused, as the test above shows.
    const auto any = [] {
      const double value = std::bit_cast<double>(*rc::gen::arbitrary<std::uint64_t>());
      return std::abs(value) <= 1e9 ? value : std::fmod(std::isfinite(value) ? value : 1.0, 1e9);
    };
    TickRecord row = numbered(1);
    row.V = any();
    row.robots[0].pose.x = any();
    row.robots[0].law.omega = any();
    row.compute_time = any();
    row.now = any();
    row.robots[0].mode = static_cast<std::uint8_t>(*rc::gen::inRange(0, 128));
    const std::vector<TickRecord> rows = read(csv(robots(1), {row}));
    RC_ASSERT(rows.size() == 1u);
    RC_ASSERT(same(rows[0].V, row.V));
    RC_ASSERT(same(rows[0].robots[0].pose.x, row.robots[0].pose.x));
    RC_ASSERT(same(rows[0].robots[0].law.omega, row.robots[0].law.omega));
    RC_ASSERT(same(rows[0].compute_time, row.compute_time));
    RC_ASSERT(same(rows[0].now, row.now));
    RC_ASSERT(rows[0].robots[0].mode == row.robots[0].mode);
  });
}

TEST(CsvReader, AWholeRunWritesTheSameTextAgain) {
  Experiment e = paper_experiment();
  e.duration = 20.0;
  const std::string text = csv(e, test::simulate(e));
  const std::vector<TickRecord> rows = read(text);
  ASSERT_EQ(rows.size(), 500u);
  EXPECT_EQ(csv(e, rows), text);
}

}  // namespace
}  // namespace skein::app
