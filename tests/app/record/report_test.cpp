// The report: figures that gnuplot really drew, and errors that say what is wrong.
#include "app/record/report.h"

#include <fmt/format.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include <algorithm>
#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <map>
#include <regex>
#include <vector>

#include "app/experiment/experiment_file.h"
#include "app/record/csv_writer.h"
#include "tests/app/fixture.h"
#include "tests/files.h"

namespace skein::app {
namespace {

namespace fs = std::filesystem;

std::size_t count(const std::string& text, const std::string& what) {
  std::size_t n = 0;
  for (std::size_t at = text.find(what); at != std::string::npos; at = text.find(what, at + what.size())) ++n;
  return n;
}

class Report : public testing::Test {
 public:
  ~Report() override { fs::remove_all(directory); }

 protected:
  Report() {
    std::string name =
        (fs::temp_directory_path() / "skein report XXXXXX").string();  // with blanks, as people have them
    directory = mkdtemp(name.data());
  }

  /// Runs an experiment and draws it.
  tl::expected<void, std::string> draw(const Experiment& e) { return draw(e, test::simulate(e)); }
  tl::expected<void, std::string> draw(const Experiment& e, const std::vector<TickRecord>& rows) {
    Statistics statistics(e);
    {
      std::ofstream out(directory / "run.csv");
      CsvWriter csv(out, e);
      for (const TickRecord& row : rows) csv.record(row), statistics.record(row);
    }
    return write_report(directory.string(), e, statistics.summary());
  }
  void expect_figures() {
    for (const char* figure : {"figure3", "figure4"}) {
      EXPECT_TRUE(test::read_file(directory / (std::string(figure) + ".pdf")).starts_with("%PDF-")) << figure;
      EXPECT_TRUE(test::read_file(directory / (std::string(figure) + ".png")).starts_with("\x89PNG")) << figure;
      const std::string svg = test::read_file(directory / (std::string(figure) + ".svg"));
      EXPECT_TRUE(svg.find("<svg") != std::string::npos && svg.find("</svg>") != std::string::npos) << figure;
    }
  }
  std::size_t curves(const char* figure) {
    return count(test::read_file(directory / (std::string(figure) + ".svg")), "<g id=\"gnuplot_plot_");
  }

  fs::path directory;
};

Experiment experiment(const std::string& text) {
  return parse_experiment(text, "e.toml").value();
}

TEST_F(Report, DrawsThePaper) {
  const auto drawn = draw(paper_experiment());
  ASSERT_TRUE(drawn) << drawn.error();
  expect_figures();
  EXPECT_EQ(curves("figure3"), 4u * 5u) << "reference, path, moves, both ends of each robot";
  EXPECT_EQ(curves("figure4"), 3u * 4u + 3u) << "three errors of each robot, three pairs";
  const std::string summary = test::read_file(directory / "summary.json");
  EXPECT_NE(summary.find("\"formation_first\": true"), std::string::npos);
  const std::string script = test::read_file(directory / "figure4.gp");
  EXPECT_NE(script.find("n = 4 "), std::string::npos);
  EXPECT_NE(script.find("perturbed = \"18 46 65\""), std::string::npos);
  EXPECT_NE(script.find("settled = \"22.24 51.68 70.48\""), std::string::npos);
}

TEST_F(Report, DrawsAnyNumberOfRobotsWithoutPerturbations) {
  for (const int robots : {1, 2, 9}) {
    std::string text = "duration = 2\ncontroller.gains = { k_xx = 0, k_tt = 0, k_yy = 0 }\n";
    for (int i = 0; i < robots; ++i) text += "[[robot]]\n";
    const auto drawn = draw(experiment(text));
    ASSERT_TRUE(drawn) << robots << ": " << drawn.error();
    expect_figures();
    const auto n = static_cast<std::size_t>(robots);
    const bool numbered = n > 8;  // beside the paths, and where the errors are largest, in place of a legend
    EXPECT_EQ(curves("figure3"), (numbered ? 6u : 5u) * n);
    EXPECT_EQ(curves("figure4"), 3u * n + (n > 1 ? n - 1 : 1) + (numbered ? 4u : 0u));
    EXPECT_EQ(count(test::read_file(directory / "figure3.svg"), ">9</tspan></text>"), numbered ? 1u : 0u);
  }
}

/// gnuplot crashed at the number of a robot that was not seen yet at the start, or never.
TEST_F(Report, DrawsManyRobotsThatAreSeenLateOrNever) {
  for (const char* const unseen : {"latency = 0.12", "dropout = 1"}) {
    std::string text = fmt::format("duration = 1\n[simulation]\n{}\n", unseen);
    for (int i = 0; i < 9; ++i) text += "[[robot]]\n";
    const auto drawn = draw(experiment(text));
    ASSERT_TRUE(drawn) << unseen << ": " << drawn.error();
    expect_figures();
  }
}

/// In a file the rows after the end, when robots have driven back to their starts, look like those of the run.
TEST_F(Report, LeavesOutWhereRobotsStandAfterTheRun) {
  const Experiment e = experiment("duration = 1\n");
  const auto rows = test::simulate(e);
  const auto drawn = [&](const std::vector<TickRecord>& of) {
    EXPECT_TRUE(draw(e, of));
    return test::read_file(directory / "figure3.dat");
  };
  const std::string of_run = drawn(rows);
  auto with_the_end = rows;
  with_the_end.push_back(rows.front());
  with_the_end.back().phase = Phase::finished;
  with_the_end.back().tick = e.ticks();
  with_the_end.back().t = 1.0;
  EXPECT_EQ(drawn(with_the_end), of_run);
}

/// Their colours come again from robot 9 on. Robot k is k cm beside its place, robot 1 farther than all others.
TEST_F(Report, TellsWhichOfManyRobotsHadTheLargestErrors) {
  std::string text = "duration = 2\nreference.kind = \"independent\"\n[arena]\nwidth = 4\nheight = 4\n";
  for (int k = 1; k <= 12; ++k)
    text += fmt::format(
        "[[robot]]\nstart = [{:.2f}, {:.2f}, 0.0]\ntrajectory = {{ path = {{ shape = \"line\", from = [-1.0, {:.2f}],"
        " to = [1.0, {:.2f}] }} }}\n",
        -1.0 - (k == 1 ? 0.3 : 0.01 * k), -1.8 + 0.3 * k, -1.8 + 0.3 * k, -1.8 + 0.3 * k);
  const auto drawn = draw(experiment(text));
  ASSERT_TRUE(drawn) << drawn.error();
  const std::string data = test::read_file(directory / "figure4.dat");
  const std::size_t begin = data.find("$peaks_1 << end\n") + std::strlen("$peaks_1 << end\n");
  const std::string first = data.substr(begin, data.find('\n', begin) - begin);
  EXPECT_TRUE(first.ends_with(" 1")) << first;
  const auto lines = std::ranges::count(data.substr(begin, data.find("end", begin) - begin), '\n');
  EXPECT_GE(lines, 2);
  EXPECT_LE(lines, 8) << "numbers that cover one another";
}

/// Of a robot that drives straight on, the paths take no room across: the numbers of that axis need some.
TEST_F(Report, NumbersOfAStraightPathDoNotOverlap) {
  for (const char* const to : {"[0.6, 0.0]", "[0.0, 0.6]"}) {
    const auto drawn = draw(
        experiment(std::string("duration = 10\nreference.kind = \"independent\"\n[[robot]]\ntrajectory = { path = { "
                               "shape = \"line\", from = [0.0, 0.0], to = ") +
                   to + " } }\n"));
    ASSERT_TRUE(drawn) << drawn.error();
    const std::string svg = test::read_file(directory / "figure3.svg");
    const std::regex text(R"re(translate\(([0-9.]+),([0-9.]+)\)"[^>]*text-anchor="(end|middle)")re");
    std::vector<double> numbers_of_y;
    std::map<double, std::vector<double>> in_a_line;  // those of x, and the axes' names
    for (std::sregex_iterator found(svg.begin(), svg.end(), text), none; found != none; ++found)
      if ((*found)[3] == "end")
        numbers_of_y.push_back(-std::stod((*found)[2]));
      else
        in_a_line[std::stod((*found)[2])].push_back(std::stod((*found)[1]));
    const auto apart = [](const std::vector<double>& places) {
      double least = 1e9;
      for (std::size_t i = 1; i < places.size(); ++i) least = std::min(least, places[i] - places[i - 1]);
      return least;
    };
    EXPECT_GT(numbers_of_y.size(), 1u);
    EXPECT_GE(apart(numbers_of_y), 9.6) << to << ": the height of a letter";
    for (const auto& [y, places] : in_a_line) EXPECT_GE(apart(places), 20.0) << to;
  }
}

TEST_F(Report, DrawsARunOfOneRow) {
  const auto drawn = draw(experiment("duration = 0.04"));
  ASSERT_TRUE(drawn) << drawn.error();
  expect_figures();
}

TEST_F(Report, SaysThatThereIsNoRecord) {
  const auto drawn = write_report(directory.string(), paper_experiment(), {});
  ASSERT_FALSE(drawn);
  EXPECT_NE(drawn.error().find("run.csv: cannot be opened: No such file"), std::string::npos) << drawn.error();
}

TEST_F(Report, SaysWhatGnuplotSaid) {
  fs::create_directory(directory / "figure3.pdf");  // it cannot be drawn there
  const auto drawn = draw(experiment("duration = 1"));
  ASSERT_FALSE(drawn);
  EXPECT_NE(drawn.error().find("figure3.gp: gnuplot ended with status"), std::string::npos) << drawn.error();
  EXPECT_NE(drawn.error().find("Is a directory"), std::string::npos) << drawn.error();
}

TEST_F(Report, DrawsTheOthersIfARobotWasNeverSeen) {
  const Experiment e = experiment("duration = 2");
  std::vector<TickRecord> rows = test::simulate(e);
  for (TickRecord& row : rows) row.robots[1].pose = {none, none, none};
  const auto drawn = draw(e, rows);
  ASSERT_TRUE(drawn) << drawn.error();
  expect_figures();
}

TEST_F(Report, OfALongRunIsSmall) {
  const Experiment e = experiment("duration = 4");
  const std::vector<TickRecord> round = test::simulate(e);
  std::vector<TickRecord> rows;
  for (int again = 0; again < 300; ++again)
    for (TickRecord row : round) {
      row.t += 4.0 * again;
      for (RobotRecord& robot : row.robots)
        robot.pose.x += 1e-3 * static_cast<double>((again * 7 + row.tick * 13) % 11 - 5) / 5.0;
      rows.push_back(std::move(row));
    }
  const auto drawn = draw(e, rows);  // 30,000 rows
  ASSERT_TRUE(drawn) << drawn.error();
  expect_figures();
  for (const char* figure : {"figure3.svg", "figure4.svg", "figure3.dat", "figure4.dat"})
    EXPECT_LT(fs::file_size(directory / figure), 3u << 20) << figure;
}

TEST_F(Report, SaysThatGnuplotIsMissing) {
  const char* const before = std::getenv("PATH");
  ASSERT_NE(before, nullptr);
  const std::string path = before;
  setenv("PATH", "/nowhere", 1);
  const auto checked = check_report(directory.string());
  setenv("PATH", path.c_str(), 1);
  ASSERT_FALSE(checked);
  EXPECT_NE(checked.error().find("install the package gnuplot-nox"), std::string::npos) << checked.error();
}

TEST_F(Report, MakesItsDirectoryAndLeavesNothingInIt) {
  const fs::path deeper = directory / "a" / "b";
  const auto checked = check_report(deeper.string());
  ASSERT_TRUE(checked) << checked.error();
  EXPECT_TRUE(fs::is_empty(deeper));
}

TEST_F(Report, RefusesADirectoryThatCannotBe) {
  std::ofstream(directory / "file") << "x";
  const auto checked = check_report((directory / "file" / "below").string());
  ASSERT_FALSE(checked);
  EXPECT_NE(checked.error().find("file/below: cannot be made: Not a directory"), std::string::npos) << checked.error();

  EXPECT_FALSE(check_report("/proc/report"));
  const auto gone = write_report((directory / "gone").string(), paper_experiment(), {});
  ASSERT_FALSE(gone);
  EXPECT_NE(gone.error().find("summary.json: cannot be written: No such file"), std::string::npos) << gone.error();
}

TEST_F(Report, LeavesOutTheWayToTheStarts) {
  const Experiment e = experiment("duration = 2\nname = \"x\"");
  std::vector<TickRecord> rows = test::simulate(e);
  ASSERT_TRUE(draw(e, rows));
  const std::string path = test::read_file(directory / "figure3.svg"),
                    errors = test::read_file(directory / "figure4.svg");
  TickRecord on_the_way = rows.front();
  on_the_way.phase = Phase::staging;
  on_the_way.events.clear();
  for (RobotRecord& robot : on_the_way.robots) {
    robot.mode = staging;
    robot.pose.x += 0.4;
  }
  rows.insert(rows.begin(), 3, on_the_way);
  ASSERT_TRUE(draw(e, rows));
  EXPECT_EQ(test::read_file(directory / "figure3.svg"), path);
  EXPECT_EQ(test::read_file(directory / "figure4.svg"), errors);
}

}  // namespace
}  // namespace skein::app
