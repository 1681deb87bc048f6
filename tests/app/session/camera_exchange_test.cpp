// Two cameras whose calibration files were exchanged, in whole runs from pictures: what is known of it before a robot
// drives, and where nothing is.
#include <gmock/gmock.h>

#include <algorithm>
#include <filesystem>
#include <optional>
#include <utility>

#include "app/calibration/calibration_file.h"
#include "app/session/experiment_cameras.h"
#include "app/session/readiness.h"
#include "app/session/session.h"
#include "tests/app/experiment_texts.h"
#include "tests/app/folder.h"
#include "tests/app/rows.h"
#include "tests/pgm.h"
#include "vision/synthetic/synthetic_camera.h"

namespace skein::app {
namespace {

using ::testing::AllOf;
using ::testing::AnyOf;
using ::testing::ContainsRegex;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;

/// A camera over a part of the floor, and four tags that lie there.
struct HungCamera {
  HungCamera(double x, int first_mark) : calibration(vision::overhead_calibration(1.2, 1.0, {x, 0.0})) {
    if (first_mark < 0) return;
    for (int k = 0; k < 4; ++k)
      calibration.marks.push_back({.name = "tag " + std::to_string(first_mark + k),
                                   .tag = first_mark + k,
                                   .x = x + (k % 2 == 0 ? -0.35 : 0.35),
                                   .y = k < 2 ? -0.3 : 0.3,
                                   .size = 0.06});
  }
  vision::Calibration calibration;
};

/// One robot under two cameras at x = -0.5 and 0.5, whose pictures are files.
struct Filmed {
  Filmed(const vision::Calibration& west, const vision::Calibration& east, const core::Pose& robot) {
    write(west, robot, "west");
    write(east, robot, "east");
  }

  /// With these files for the first and the second camera.
  Experiment experiment(const std::string& first, const std::string& second, const Sets& more = {}) const {
    Sets sets{"camera.source=images:" + (folder / "pictures-west"), "camera.calibration=" + (folder / first),
              "camera.also=[{source=\"images:" + (folder / "pictures-east") + "\",calibration=\"" + (folder / second) +
                  "\"}]",
              "duration=0.4", "staging.automatic=false"};
    sets.insert(sets.end(), more.begin(), more.end());
    return good(
        "[reference]\nkind = \"independent\"\n[arena]\nwidth = 3.0\n[[robot]]\ntag = 1\n"
        "trajectory = { path = { shape = \"line\", from = [0.0, -0.2], to = [0.0, 0.3] }, speed = 0.08 }\n",
        sets);
  }

  test::Folder folder;

 private:
  void write(const vision::Calibration& calibration, const core::Pose& robot, const std::string& name) const {
    EXPECT_TRUE(save_calibration(calibration, folder / (name + ".toml")));
    const std::string pictures = folder / ("pictures-" + name);
    std::filesystem::create_directories(pictures);
    std::vector<vision::SyntheticTag> tags{{1, robot, calibration.tag_size}};
    for (const vision::FloorMark& mark : calibration.marks)
      tags.push_back({.tag = mark.tag,
                      .pose = {mark.x, mark.y, 0.0},
                      .size = mark.size,
                      .lifted = -calibration.tag_height,
                      .bare = true});
    vision::Frame frame;
    vision::SyntheticCamera(calibration).render(tags, 0.0, frame);
    skein::test::write_pgm(pictures + "/0.pgm", frame);
    for (int k = 1; k < 1500; ++k)  // a minute: marks are looked at late on a busy machine
      std::filesystem::create_hard_link(pictures + "/0.pgm", pictures + "/" + std::to_string(k) + ".pgm");
  }
};

struct FilmedRun {
  explicit FilmedRun(const Experiment& experiment, Session::Clock clock = Session::Clock::wall) {
    auto session = Session::open(experiment, clock, {false, {&sink}});
    EXPECT_TRUE(session) << session.error();
    const auto look = [&] {
      for (std::string& sentence : (*session)->alarms()) told.push_back(std::move(sentence));
      (*session)->drain([&](const TickRecord& record) {
        newest = record;
        began = began || record.phase == Phase::running;
      });
      const TickRecord* const record = newest ? &*newest : nullptr;
      const Check check =
          readiness(experiment, nullptr, record, (*session)->robots(), (*session)->camera_status()).front();
      if (!began) listed.push_back(check);
      return true;
    };
    (*session)->run(look);
    look();
    if (const auto again = (*session)->start(); !again) refusal = again.error();
    (*session)->close();
    failure = (*session)->failure().value_or("");
  }
  bool drove() const {
    return std::any_of(sink.rows.begin(), sink.rows.end(),
                       [](const TickRecord& row) { return row.phase == Phase::running; });
  }
  test::Rows sink;
  std::optional<TickRecord> newest;
  bool began = false;
  std::vector<std::string> told;
  std::vector<Check> listed;  // the check list's line about the cameras, before the start
  std::string failure, refusal;
};

constexpr core::Pose in_the_overlap{0.0, 0.0, 0.3}, in_the_east{0.5, 0.1, 0.3};

TEST(ExchangedCalibrations, AreKnownBeforeTheStartByARobotThatBothCamerasSee) {
  const Filmed filmed(HungCamera(-0.5, -1).calibration, HungCamera(0.5, -1).calibration, in_the_overlap);
  const FilmedRun run(filmed.experiment("east.toml", "west.toml"));
  EXPECT_THAT(run.failure, HasSubstr("cameras 1 and 2 see robot 1 2000 mm apart"));
  EXPECT_THAT(run.failure, HasSubstr("has the calibration of another camera"));
  EXPECT_THAT(run.failure, HasSubstr("no robot drives"));
  EXPECT_FALSE(run.drove());
  ASSERT_FALSE(run.listed.empty());
  EXPECT_EQ(run.listed.back().state, Check::State::fails) << run.listed.back().reason;
  EXPECT_TRUE(run.listed.back().hard);
  EXPECT_THAT(run.listed.back().reason, HasSubstr("cameras 1 and 2 see robot 1 2000 mm apart"));
}

TEST(ExchangedCalibrations, TheControlStarts) {
  const Filmed filmed(HungCamera(-0.5, -1).calibration, HungCamera(0.5, -1).calibration, in_the_overlap);
  const FilmedRun run(filmed.experiment("west.toml", "east.toml"));
  EXPECT_TRUE(run.drove()) << run.failure;
  ASSERT_FALSE(run.listed.empty());
  EXPECT_EQ(run.listed.back().state, Check::State::holds);
  EXPECT_EQ(run.listed.back().reason, "2 cameras") << "a robot that both see has shown whose calibrations they are";
}

/// Where the file allows it, as after a bump.
TEST(ExchangedCalibrations, AreNoReasonWhereTheFileSaysSo) {
  const Filmed filmed(HungCamera(-0.5, -1).calibration, HungCamera(0.5, -1).calibration, in_the_overlap);
  const FilmedRun run(filmed.experiment("east.toml", "west.toml", {"failure.camera_moved=go_on"}));
  EXPECT_TRUE(run.drove()) << run.failure;
}

/// No robot is where both look: the marks tell, also those of one of the two alone.
TEST(ExchangedCalibrations, AreKnownBeforeTheStartByTheMarksOnTheFloor) {
  const auto known = [](const Filmed& filmed, Session::Clock clock) {
    const FilmedRun run(filmed.experiment("east.toml", "west.toml"), clock);
    EXPECT_THAT(run.failure, AnyOf(HasSubstr("camera 1: the marks on the floor show that "),
                                   HasSubstr("camera 2: the marks on the floor show that ")));
    EXPECT_THAT(run.failure, HasSubstr("is this camera's calibration: no robot drives"));
    EXPECT_EQ(run.refusal, run.failure) << "whoever asks";
    EXPECT_FALSE(run.drove());
    ASSERT_FALSE(run.listed.empty());
    EXPECT_THAT(run.listed.back().reason, HasSubstr("is this camera's calibration"));
    EXPECT_TRUE(run.listed.back().hard);
  };
  const Filmed both(HungCamera(-0.5, 20).calibration, HungCamera(0.5, 30).calibration, in_the_east);
  known(both, Session::Clock::wall);
  known(both, Session::Clock::virtual_);
  const FilmedRun control(both.experiment("west.toml", "east.toml"));
  EXPECT_TRUE(control.drove()) << control.failure;
  for (const auto& [west_marks, east_marks] : {std::pair(20, -1), std::pair(-1, 30)})
    known(Filmed(HungCamera(-0.5, west_marks).calibration, HungCamera(0.5, east_marks).calibration, in_the_east),
          Session::Clock::virtual_);
}

TEST(ExchangedCalibrations, ThatNothingShowsAreSpokenOf) {
  const vision::Calibration west = HungCamera(-0.5, -1).calibration, east = HungCamera(0.5, -1).calibration;
  const Filmed filmed(west, east, in_the_east);
  const FilmedRun run(filmed.experiment("west.toml", "east.toml"));
  EXPECT_TRUE(run.drove()) << run.failure;
  EXPECT_THAT(run.told,
              ElementsAre(HasSubstr("west.toml has no marks on the floor: until another camera sees the same robot"),
                          HasSubstr("east.toml has no marks on the floor: until another camera sees the")));
  ASSERT_FALSE(run.listed.empty());
  EXPECT_THAT(run.listed.back().reason, HasSubstr("west.toml has no marks on the floor"));
}

TEST(ExchangedCalibrations, OfViewsThatDoNotOverlapNeedMarks) {
  const auto sentences = [](double x, int west_marks, int east_marks) {
    const Filmed filmed(HungCamera(-x, west_marks).calibration, HungCamera(x, east_marks).calibration, {x, 0.0, 0.0});
    std::vector<std::string> all;
    for (const UnguardedCalibration& one : unguarded_calibrations(filmed.experiment("west.toml", "east.toml")))
      all.push_back(one.sentence);
    return all;
  };
  EXPECT_THAT(sentences(0.8, -1, -1), ElementsAre(HasSubstr("this view overlaps with no other camera's: nothing shows"),
                                                  HasSubstr("this view overlaps with no other camera's")));
  EXPECT_THAT(sentences(0.8, 20, -1), ElementsAre(HasSubstr("camera 2: ")));
  EXPECT_THAT(sentences(0.8, 20, 30), IsEmpty());
  EXPECT_THAT(unguarded_calibrations(
                  good(paper_experiment().source, {"camera.source=synthetic", "camera.also=[{source=\"synthetic\"}]"})),
              IsEmpty())
      << "they hang where their calibrations have them";
}

/// Less than a bump: the operator may start all the same. Not even where frames come so slowly that half a second is
/// not enough to compare them does the start come first.
TEST(CamerasThatDiffer, AreInTheCheckListBeforeTheStart) {
  const vision::Calibration west = HungCamera(-0.5, -1).calibration, east = HungCamera(0.5, -1).calibration;
  const Filmed filmed(west, east, in_the_overlap);
  vision::Calibration off = east;
  off.world_from_camera->position.x() += 0.01;
  ASSERT_TRUE(save_calibration(off, filmed.folder / "off.toml"));
  for (const Sets& frames : {Sets{}, Sets{"rate=3", "estimation.bridge=0.5"}}) {
    const FilmedRun run(filmed.experiment("west.toml", "off.toml", frames));
    EXPECT_TRUE(run.drove()) << run.failure;
    ASSERT_FALSE(run.listed.empty());
    EXPECT_EQ(run.listed.back().state, Check::State::fails) << run.listed.back().reason;
    EXPECT_FALSE(run.listed.back().hard);
    EXPECT_THAT(run.listed.back().reason, ContainsRegex("cameras 1 and 2 see robot 1 (9|10) mm apart, and go on to"));
  }
}

/// A digit that was typed wrongly.
TEST(FocalLengths, ThatDifferAreTold) {
  const test::Folder folder;
  const auto told = [&](double share) {
    vision::Calibration calibration = vision::overhead_calibration(2.0, 1.5);
    calibration.fx *= 1.0 + share;
    EXPECT_TRUE(save_calibration(calibration, folder / "cal.toml"));
    return uneven_focal_lengths(
        good(paper_experiment().source, {"camera.source=synthetic", "camera.calibration=" + (folder / "cal.toml")}));
  };
  EXPECT_THAT(told(0.0), IsEmpty());
  EXPECT_THAT(told(0.1), ElementsAre(AllOf(HasSubstr("fx and fy of "), HasSubstr("cal.toml differ by 10.1 %"))));
}

}  // namespace
}  // namespace skein::app
