// Why a robot's tag is not seen, asked of a camera that runs, and calibrations that are missing.
#include "app/session/camera_rig.h"
#include "app/calibration/calibration_file.h"

#include <fmt/format.h>
#include <gtest/gtest.h>
#include <sys/resource.h>
#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <filesystem>
#include <future>
#include <string>
#include <thread>
#include <vector>

#include "app/experiment/experiment_file.h"
#include "app/session/experiment_cameras.h"
#include "app/session/session.h"
#include "tests/app/folder.h"
#include "tests/eventually.h"
#include "tests/pgm.h"
#include "vision/sources/open_source.h"
#include "vision/synthetic/synthetic_camera.h"

namespace skein::app {
namespace {

namespace fs = std::filesystem;

/// A folder with a calibration for 60 mm tags and a film, as pictures, of one tag of 40 mm.
struct Lab {
  static constexpr int frames = 1500;  // 60 s: a busy machine takes long to search one
  const test::Folder own_folder;
  const fs::path folder = own_folder.path;

  Lab() {
    fs::create_directories(folder / "film");
    vision::Calibration calibration = vision::overhead_calibration(2.0, 1.5);
    calibration.tag_size = 0.06;
    EXPECT_TRUE(save_calibration(calibration, folder / "cal.toml"));
    vision::Frame frame;
    vision::SyntheticCamera(calibration)
        .render(std::vector<vision::SyntheticTag>{{1, {0.3, -0.2, 0.4}, 0.04}}, 0.0, frame);
    skein::test::write_pgm(folder / "film" / "0.pgm", frame);
    for (int k = 1; k < frames; ++k)
      fs::create_hard_link(folder / "film" / "0.pgm", folder / "film" / (std::to_string(k) + ".pgm"));
  }

  Experiment experiment(const std::string& calibration, std::vector<std::string> sets = {}) const {
    sets.push_back("camera.source=images:" + (folder / "film").string());
    sets.push_back("camera.calibration=" + (folder / calibration).string());
    auto e = parse_experiment(paper_experiment().source, "platoon.toml", sets);
    EXPECT_TRUE(e) << (e ? "" : e.error().front().message());
    return *e;
  }
};

/// The cameras of an experiment, on a clock and with a world of their own.
struct OpenRig {
  OpenRig(const Experiment& experiment, bool wall_clock) : clock(wall_clock), world(experiment) {
    auto opened = CameraRig::open(experiment, clock, world, false, wanted_tags(experiment));
    EXPECT_TRUE(opened) << opened.error();
    if (opened) rig = std::move(*opened);
  }
  SessionClock clock;
  SimulatedWorld world;
  std::unique_ptr<CameraRig> rig;
};

/// What an open camera says of the tags that it does not see.
std::vector<UnseenTag> not_seen(const Experiment& experiment, TagCrops* crops = nullptr) {
  OpenRig opened(experiment, true);
  if (!opened.rig) return {};
  opened.rig->keep_crops(crops);
  opened.rig->start();
  const std::vector<UnseenTag> why = opened.rig->why_not_seen();
  opened.rig->end();
  return why;
}

TEST(CameraRig, FindsOutByItselfWhyATagWasNeverSeen) {
  const Lab lab;
  const Experiment experiment = lab.experiment("cal.toml");
  OpenRig opened(experiment, true);
  auto& [clock, world, rig] = opened;
  ASSERT_TRUE(rig);
  EXPECT_EQ(rig->why_lost().at(0).sentence, "") << "nobody has looked yet";
  rig->start();
  EXPECT_TRUE(test::eventually([&rig = rig] { return !rig->why_lost().at(0).sentence.empty(); }));
  EXPECT_EQ(rig->why_lost().at(0).why, core::NotSeen::wrong_size);
  EXPECT_TRUE(rig->why_lost().at(0).sentence.starts_with("tag 1 is there, but its edge is 40 mm"));
  EXPECT_EQ(rig->why_lost().at(1).sentence, "no tag 2 is in the picture");
  EXPECT_NEAR(rig->why_lost().at(0).size, 0.04, 0.001);
  ASSERT_TRUE(rig->why_lost().at(0).picture) << "the part of the frame that shows the tag";
  EXPECT_EQ(rig->why_lost().at(0).file, "") << "nobody wanted it as a file";
  EXPECT_FALSE(rig->why_lost().at(1).picture) << "the control: nothing shows this one";
  EXPECT_TRUE(rig->alarms().empty()) << "it is no news that a robot is not there yet";
  rig->end();
}

TEST(CameraRig, SaysWhyATagIsNotSeen) {
  const Lab lab;
  const Experiment experiment = lab.experiment("cal.toml");
  const std::vector<UnseenTag> why = not_seen(experiment);
  ASSERT_EQ(why.size(), 4U) << "one sentence a robot";
  EXPECT_TRUE(why[0].sentence.starts_with("tag 1 is there, but its edge is 40 mm, 33 % smaller than [tags] size 60 mm"))
      << why[0].sentence;
  EXPECT_EQ(why[1].sentence, "no tag 2 is in the picture");
}

TEST(CameraRig, WritesAPictureOfATagThatIsNotSeen) {
  const Lab lab;
  const Experiment experiment = lab.experiment("cal.toml");
  const fs::path folder = lab.folder / "crops", other = lab.folder / "other";
  TagCrops crops;
  crops.begin({folder, other});
  const std::vector<UnseenTag> why = not_seen(experiment, &crops);
  ASSERT_EQ(why.size(), 4U);
  EXPECT_EQ(why[0].file, folder / "tag-1.png");
  EXPECT_TRUE(why[0].text().ends_with(" (picture: " + why[0].file + ")")) << why[0].text();
  EXPECT_EQ(why[1].text(), "no tag 2 is in the picture");
  auto written = vision::open_source("images:" + why[0].file);
  ASSERT_TRUE(written) << written.error();
  vision::Frame picture;
  ASSERT_TRUE((*written)->read(picture).value_or(false));
  EXPECT_TRUE(std::ranges::equal(picture.grey, why[0].picture->grey)) << "the pixels of the frame";
  EXPECT_TRUE(fs::exists(other / "tag-1.png")) << "in each folder";
  const std::vector<TagCrop> all = crops.all();
  ASSERT_EQ(all.size(), 1U) << "of the others there is nothing to show";
  EXPECT_EQ(all[0].robot, 0U);
  EXPECT_EQ(all[0].file, "tag-1.png");
  EXPECT_EQ(all[0].sentence, why[0].sentence);
  EXPECT_EQ(all[0].picture->grey, why[0].picture->grey);
  // A folder that cannot be written is no failure of the run.
  crops.begin({why[0].file + "/below-a-file"});
  EXPECT_TRUE(crops.all().empty()) << "those of the run before";
  EXPECT_NE(not_seen(experiment, &crops).at(0).text().find("tag-1.png: cannot be written)"), std::string::npos);
}

TEST(TagCrops, AfterTheirEndNoFileIsWritten) {
  const Lab lab;
  const fs::path folder = lab.folder / "crops";
  const auto picture = std::make_shared<const Picture>(Picture{2, 1, {0, 255}});
  TagCrops crops;
  EXPECT_EQ(crops.add({1, crop_file(2, 0, 1), "gone", picture}), "") << "nobody wants a file";
  EXPECT_EQ(crops.all().size(), 1U);
  crops.begin({folder});
  EXPECT_EQ(crops.add({1, crop_file(2, 1, 2), "gone", picture}), folder / "camera-2-tag-2.png");
  crops.add({0, crop_file(1, 0, 2), "dark", picture});
  crops.add({1, crop_file(2, 1, 2), "lifted", picture});
  crops.end_files();
  EXPECT_EQ(crops.add({2, crop_file(3, 0, 2), "gone", picture}), "");
  EXPECT_FALSE(fs::exists(folder / "camera-1-tag-3.png"));
  const std::vector<TagCrop> all = crops.all();
  ASSERT_EQ(all.size(), 3U) << "of each tag and camera the newest";
  EXPECT_EQ(all[0].sentence, "dark");
  EXPECT_EQ(all[1].sentence, "lifted");
}

TEST(CameraRig, TheExperimentsTagSizeHoldsInPlaceOfTheCalibrations) {
  const Lab lab;
  const Experiment experiment = lab.experiment("cal.toml", {"tags.size=0.04"});
  EXPECT_EQ(camera_calibration(lab.experiment("cal.toml"))->tag_size, 0.06) << "the control";
  EXPECT_EQ(camera_calibration(experiment)->tag_size, 0.04);
  const std::vector<UnseenTag> why = not_seen(experiment);
  ASSERT_EQ(why.size(), 3U) << "robot 1 is seen";
  EXPECT_EQ(why[0].tag, 2);
}

TEST(CameraRig, ARunThatSeesNobodySaysTheSizeThatWouldFit) {
  const Lab lab;
  const std::string folder = lab.folder / "crops";
  TagCrops crops;
  crops.begin({folder});
  auto session = Session::open(lab.experiment("cal.toml"), Session::Clock::wall, {.crops = &crops});
  ASSERT_TRUE(session) << session.error();
  (*session)->run();
  const std::string failure = (*session)->failure().value_or("");
  EXPECT_TRUE(failure.starts_with("robot 1: its tag 1 is not seen: tag 1 is there, but its edge is 40 mm")) << failure;
  EXPECT_NE(failure.find("(picture: " + folder + "/tag-1.png); no tag 2 is in the picture"), std::string::npos)
      << failure;
  EXPECT_TRUE(failure.ends_with("; if the black edge of the tags measures 40 mm: --set tags.size=0.04")) << failure;
}

/// It said only that the stream was at its end.
TEST(CameraRig, AFilmThatEndsBeforeAllAreSeenNamesThoseThatItDoesNotShow) {
  Lab lab;
  for (int k = 20; k < Lab::frames; ++k) fs::remove(lab.folder / "film" / (std::to_string(k) + ".pgm"));
  const Experiment experiment = lab.experiment("cal.toml", {"tags.size=0.04"});
  OpenRig opened(experiment, false);
  ASSERT_TRUE(opened.rig);
  for (int k = 0; k < 21; ++k) {
    opened.clock.set(0.04 * k);
    opened.rig->process_frame(opened.clock.now());
  }
  EXPECT_TRUE(opened.rig->failed());
  EXPECT_EQ(opened.rig->reason(), "images:" + (lab.folder / "film").string() +
                                      ": the stream is at its end; tags never seen: 2 (robot 2), 3 (robot 3), "
                                      "4 (robot 4)");
}

/// By a film of two seconds nobody waits the ten until a run asks for the reason.
TEST(CameraRig, AFilmThatEndsBeforeItsTagsAreAcceptedSaysWhyTheyAreNot) {
  Lab lab;
  for (int k = 20; k < Lab::frames; ++k) fs::remove(lab.folder / "film" / (std::to_string(k) + ".pgm"));
  const Experiment experiment = lab.experiment("cal.toml");
  OpenRig opened(experiment, false);
  ASSERT_TRUE(opened.rig);
  for (int k = 0; k < 21; ++k) {
    opened.clock.set(0.04 * k);
    opened.rig->process_frame(opened.clock.now());
  }
  EXPECT_TRUE(opened.rig->reason().ends_with(
      "4 (robot 4); tag 1 is there, but its edge is 40 mm, 33 % smaller than [tags] size 60 mm: correct the size, or "
      "[tags] height if all robots' tags are off by as much"))
      << opened.rig->reason();
}

TEST(CameraRig, AFrameThatIsDueIsWatchedForWithoutSleeping) {
  const Lab lab;
  const Experiment experiment = lab.experiment("cal.toml");
  OpenRig opened(experiment, true);
  auto& [clock, world, rig] = opened;
  ASSERT_TRUE(rig);
  rig->start();
  const auto sleeps = [] {
    rusage use{};
    ::getrusage(RUSAGE_THREAD, &use);
    return use.ru_nvcsw;
  };
  const double since = clock.now();
  const auto before = sleeps();
  rig->watch_for_frame(since, since + 60.0);
  EXPECT_EQ(sleeps(), before);
  std::vector<core::Measurement> newest(4);
  FrameTimes times;
  ASSERT_TRUE(rig->newest(newest, times));
  EXPECT_GE(times.ready_at, since);
  const double passed = clock.now();
  rig->watch_for_frame(passed + 60.0, passed);  // a time that has passed is not waited for
  rig->end();
}

TEST(CameraRig, AFilmThatIsEndedHasEveryFrameWhosePosesWereGiven) {
  const Lab lab;
  const Experiment experiment = lab.experiment("cal.toml");
  for (int repeat = 0; repeat < 5; ++repeat) {
    OpenRig opened(experiment, true);
    auto& [clock, world, rig] = opened;
    ASSERT_TRUE(rig);
    const std::string path = lab.folder / fmt::format("ended-{}.mkv", repeat);
    ASSERT_TRUE(rig->keep(path));
    rig->start();
    std::vector<core::Measurement> measurements(experiment.robots.size());
    FrameTimes times;
    while (!rig->newest(measurements, times)) std::this_thread::yield();
    const auto complete = rig->end_film();  // at once, as a run may end with the tick that takes these poses
    ASSERT_TRUE(complete);
    EXPECT_EQ(complete().dropped, 0);
    rig->end();
    auto film = vision::open_source("video:" + path);
    ASSERT_TRUE(film) << film.error();
    double last = -1.0;
    for (vision::Frame frame; (*film)->read(frame).value();) last = frame.captured_at;
    EXPECT_GE(last, times.captured_at) << "repeat " << repeat;
  }
}

TEST(CameraRig, SaysWhyARobotThatWasSeenIsLost) {
  // Robots 1 to 3 stand; after a second, 2 is held up and a hand lies on 3.
  const Lab lab;
  const auto film = lab.folder / "lost";
  fs::create_directories(film);
  const vision::Calibration calibration = *load_calibration(lab.folder / "cal.toml");
  vision::SyntheticCamera camera(calibration);
  std::vector<vision::SyntheticTag> tags{{1, {0.3, -0.2, 0.4}, 0.06},
                                         {2, {-0.5, 0.3, 1.0}, 0.06},
                                         {3, {-0.1, -0.4, 2.0}, 0.06},
                                         {4, {0.6, 0.3, 3.0}, 0.06}};
  vision::Frame frame;
  constexpr int fine = 40, frames = 70;
  for (int k = 0; k < frames; ++k) {
    std::vector<vision::SyntheticDisc> discs;
    if (k >= fine) tags[1].lifted = 0.04, discs.push_back({-0.1, -0.4});
    camera.render(tags, discs, 0.0, frame);
    skein::test::write_pgm(film / fmt::format("{:03}.pgm", k), frame);
  }
  const auto experiment =
      parse_experiment(paper_experiment().source, "platoon.toml",
                       std::vector<std::string>{"camera.source=images:" + film.string(),
                                                "camera.calibration=" + (lab.folder / "cal.toml").string()});
  ASSERT_TRUE(experiment);
  OpenRig opened(*experiment, false);
  auto& [clock, world, rig] = opened;
  ASSERT_TRUE(rig);
  std::vector<std::string> events, sentences;
  int said_at = 0;
  for (int k = 0; k < frames; ++k) {
    clock.set(0.04 * k);
    rig->process_frame(clock.now());
    EventList list(16);
    rig->tell(list);
    for (const Event& event : list) events.push_back(describe(event)), said_at = k;
    for (const std::string& sentence : rig->alarms()) sentences.push_back(sentence);
  }
  EXPECT_EQ(events, (std::vector<std::string>{"not_seen r2 lifted", "not_seen r3 not_found"}));
  EXPECT_NEAR(said_at, fine + 13, 1) << "half a second later, and once";
  ASSERT_EQ(sentences.size(), 2U);
  EXPECT_TRUE(sentences[0].starts_with("robot 2 is lost: tag 2 is there, but looks larger than the other tags"))
      << sentences[0];
  EXPECT_EQ(sentences[1], "robot 3 is lost: no tag 3 is in the picture");
}

TEST(CameraRig, SaysThatHeightOrSizeOfAllTagsIsWrong) {
  const Lab lab;
  const auto film = lab.folder / "standing";
  fs::create_directories(film);
  vision::Calibration calibration = *load_calibration(lab.folder / "cal.toml");
  const std::vector<vision::SyntheticTag> tags{{1, {0.3, -0.2, 0.4}, 0.06},
                                               {2, {-0.5, 0.3, 1.0}, 0.06},
                                               {3, {-0.1, -0.4, 2.0}, 0.06},
                                               {4, {0.6, 0.3, 3.0}, 0.06}};
  vision::Frame frame;
  vision::SyntheticCamera camera(calibration);
  constexpr int frames = 90;
  for (int k = 0; k < frames; ++k) {
    camera.render(tags, 0.0, frame);
    skein::test::write_pgm(film / fmt::format("{:03}.pgm", k), frame);
  }
  calibration.tag_height -= 0.03;
  ASSERT_TRUE(save_calibration(calibration, lab.folder / "low.toml"));

  const auto told = [&](const char* file) {
    const auto experiment =
        parse_experiment(paper_experiment().source, "platoon.toml",
                         std::vector<std::string>{"camera.source=images:" + film.string(),
                                                  "camera.calibration=" + (lab.folder / file).string()});
    SessionClock clock(false);
    SimulatedWorld world(*experiment);
    auto rig = CameraRig::open(*experiment, clock, world, false, wanted_tags(*experiment));
    std::vector<std::string> sentences;
    for (int k = 0; k < frames; ++k) {
      clock.set(0.04 * k);
      (*rig)->process_frame(clock.now());
      for (const std::string& sentence : (*rig)->alarms())
        if (sentence.starts_with("the tags look")) sentences.push_back(sentence);
    }
    return sentences;
  };
  EXPECT_TRUE(told("cal.toml").empty());
  const std::vector<std::string> sentences = told("low.toml");
  ASSERT_EQ(sentences.size(), 1U);
  EXPECT_NE(sentences[0].find("% larger than [tags] size 60.0 mm and height 30 mm make them"), std::string::npos)
      << sentences[0];
}

/// A camera whose stamps are late shows what was, and camera.latency says when that was.
TEST(CameraRig, CorrectsTheTimeOfCapture) {
  const auto experiment = parse_experiment(
      paper_experiment().source, "platoon.toml",
      std::vector<std::string>{"camera.source=synthetic", "camera.stamps_late=0.05", "camera.latency=0.04"});
  ASSERT_TRUE(experiment);
  OpenRig opened(*experiment, false);
  auto& [clock, world, rig] = opened;
  ASSERT_TRUE(rig);
  world.command(0, {500.0, 500.0});
  std::vector<core::Pose> truth(4);
  std::vector<core::Measurement> seen(4);
  FrameTimes times;
  for (int k = 0; k <= 25; ++k) {
    clock.set(0.04 * k);
    rig->process_frame(clock.now());
    ASSERT_TRUE(rig->newest(seen, times));
    EXPECT_DOUBLE_EQ(times.captured_at, 0.04 * k - 0.04);
    EXPECT_DOUBLE_EQ(times.arrived_at, 0.04 * k);
    EXPECT_DOUBLE_EQ(seen[0].captured_at, times.captured_at);
    world.poses_at(0.04 * k - 0.05, truth);
    EXPECT_LT(core::distance(seen[0].pose, truth[0]), 3e-4);
  }
  const core::Pose now = world.pose(0);
  const double speed = core::distance(now, truth[0]) / 0.05;
  EXPECT_NEAR(speed, 500.0 * core::DifferentialDrive{}.metres_per_step(), 1e-6);
  // Moved by hand: it was never half way.
  world.place(0, {0.5, 0.5, 0.0});
  world.poses_at(1.0 - 1e-9, truth);
  EXPECT_LT(core::distance(truth[0], now), 1e-6);
  world.advance(1.1);
  world.poses_at(1.05, truth);
  EXPECT_NEAR(truth[0].y, 0.5, 1e-9);
}

/// A run that ends for want of a tag has the time.
TEST(CameraRig, ThePictureThatTellsWhyMayTakeABusyMachineSeconds) {
  const Lab lab;
  const Experiment experiment = lab.experiment("cal.toml");
  OpenRig opened(experiment, true);
  auto& [clock, world, rig] = opened;
  ASSERT_TRUE(rig);
  auto why = std::async(std::launch::async, [&rig = rig] { return rig->why_not_seen(); });
  EXPECT_EQ(why.wait_for(std::chrono::milliseconds(1500)), std::future_status::timeout) << "no picture has come";
  do rig->process_frame(clock.now());
  while (why.wait_for(std::chrono::milliseconds(20)) == std::future_status::timeout);
  EXPECT_EQ(why.get().size(), 4U);
}

/// Whoever waits for a film is a busy machine, not a camera whose pictures take a second.
TEST(CameraRig, AFilmsFramesAreNotOldWhenTheyAreWorkedOffLate) {
  Lab lab;
  const Experiment experiment = lab.experiment("cal.toml");
  OpenRig opened(experiment, false);
  ASSERT_TRUE(opened.rig);
  for (int k = 0; k < 4; ++k) {
    opened.clock.set(1.0 + k);
    opened.rig->process_frame(opened.clock.now() - 0.9);
    EXPECT_TRUE(opened.rig->camera().up) << opened.rig->camera().reason;
  }
}

TEST(CameraRig, NothingIsCapturedAfterItHasArrived) {
  const auto experiment = parse_experiment(paper_experiment().source, "platoon.toml",
                                           std::vector<std::string>{"camera.source=synthetic", "camera.latency=-0.1"});
  ASSERT_TRUE(experiment);
  OpenRig opened(*experiment, false);
  auto& [clock, world, rig] = opened;
  ASSERT_TRUE(rig);
  clock.set(0.04);
  rig->process_frame(clock.now());
  std::vector<core::Measurement> seen(4);
  FrameTimes times;
  ASSERT_TRUE(rig->newest(seen, times));
  EXPECT_DOUBLE_EQ(times.captured_at, 0.04);
}

TEST(CameraRig, NamesAMissingCalibration) {
  const Lab lab;
  const auto missing = camera_calibration(lab.experiment("none.toml"));
  ASSERT_FALSE(missing);
  EXPECT_NE(missing.error().find("none.toml"), std::string::npos) << missing.error();
  EXPECT_TRUE(camera_calibration(lab.experiment("cal.toml")));
}

}  // namespace
}  // namespace skein::app
