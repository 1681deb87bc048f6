// Trajectories from CSV files: read with the places of mistakes, kept in the run's own text, checked for being
// drivable.
#include <gmock/gmock.h>
#include <stdlib.h>

#include <filesystem>
#include <fstream>
#include <sstream>

#include "app/record/csv_writer.h"
#include "app/replay/replay.h"
#include "app/session/session.h"
#include "tests/app/experiment_texts.h"

namespace skein::app {
namespace {

using testing::Contains;
using testing::EndsWith;
using testing::HasSubstr;

/// An experiment of one robot beside a CSV.
class SampleFile : public testing::Test {
 protected:
  SampleFile() {
    std::string name = (std::filesystem::temp_directory_path() / "skein samples XXXXXX").string();
    folder_ = mkdtemp(name.data());
  }
  ~SampleFile() override { std::filesystem::remove_all(folder_); }

  auto load(const std::string& csv, const std::string& more = "") {
    std::ofstream(folder_ / "way.csv") << csv;
    std::ofstream(folder_ / "e.toml")
        << "duration = 20\n[reference]\nkind = 'independent'\n[[robot]]\ntrajectory = { csv = "
           "'way.csv'" +
               more + " }\n";
    return load_experiment((folder_ / "e.toml").string());
  }
  std::string refusal(const std::string& csv, const std::string& more = "") {
    const auto e = load(csv, more);
    if (e) return "";
    std::string all;
    for (const Problem& problem : e.error()) all += problem.message() + "\n";
    return all;
  }
  std::filesystem::path folder_;
};

const std::string way = "t,x,y\n# a bend\n0,-0.4,0\n5,-0.2,0\n10,0,0.1\n\n15,0.1,0.3\n";

TEST_F(SampleFile, IsDrivenAndRepeatedWithoutIt) {
  const auto e = load(way);
  ASSERT_TRUE(e) << e.error().front().message();
  EXPECT_NEAR(make_reference(*e)->at(0, 10.0).pose.y, 0.1, 1e-12);
  std::ostringstream text;
  CsvWriter writer(text, *e);
  auto session = Session::open(*e, Session::Clock::virtual_, {.sinks = {&writer}});
  ASSERT_TRUE(session) << session.error();
  (*session)->run();
  (*session)->close();
  std::filesystem::remove(folder_ / "way.csv");
  std::istringstream recorded(text.str());
  const auto result = replay(recorded, "run.csv");
  ASSERT_TRUE(result) << result.error();
  EXPECT_EQ(result->ticks, 500);
  EXPECT_EQ(result->different, 0) << result->first;
}

TEST_F(SampleFile, IsRefusedWithTheLine) {
  EXPECT_THAT(refusal("t,x,y\n0,0,0\n1,zero,0\n"), HasSubstr("way.csv:3:"));
  EXPECT_THAT(refusal("t,x,y\n0,0,0\n1,zero,0\n"), HasSubstr("found \"1,zero,0\", allowed: 3 numbers, t,x,y"));
  EXPECT_THAT(refusal("0,0,0\n1,0.1,0,0\n"), HasSubstr("way.csv:2:"));
  EXPECT_THAT(refusal("0,0,0\n2,0.1,0\n2,0.2,0\n"), HasSubstr("found t = 2 after 2, allowed: times that increase"));
  EXPECT_THAT(refusal("0,0,0\n"), HasSubstr("found 1 lines of numbers, allowed: at least 2"));
  EXPECT_THAT(refusal(way, ", speed = 0.1"), HasSubstr("robot.1.trajectory.speed: unknown key"));
  std::filesystem::create_directory(folder_ / "dir");
  EXPECT_THAT(refusal(way, ", t = 1"), HasSubstr("robot.1.trajectory.t: unknown key"));
  EXPECT_THAT(messages("[reference]\nkind = 'independent'\n[[robot]]\ntrajectory = { csv = 'nowhere.csv' }"),
              Contains(HasSubstr("nowhere.csv: cannot be read")));
}

TEST_F(SampleFile, MustBeAUnicyclesWay) {
  EXPECT_EQ(refusal("0,0,0,0\n5,0.1,0,0\n10,0.2,0,0\n"), "");
  EXPECT_THAT(
      refusal("0,0,0,0\n5,0.1,0,1.2\n10,0.2,0,0\n"),
      HasSubstr("found theta = 1.2, allowed: 0 within 0.2 rad, the direction in which a unicycle drives through "
                "these places at t = 5 s"));
  EXPECT_THAT(refusal("0,0,0\n5,0,0\n10,0.2,0\n"), HasSubstr("found the same place again"));
  EXPECT_THAT(refusal("0,0,0\n1,0.5,0\n"), HasSubstr("robot.1.trajectory.samples: found a reference of up to 0.75"));
}

}  // namespace
}  // namespace skein::app
