#include "vision/track/track_tracker.h"

#include <fmt/format.h>

#include <cmath>
#include <numeric>
#include <sstream>

#include "tests/vision/support.h"
#include "vision/recording/recorder.h"
#include "vision/synthetic/synthetic_camera.h"

namespace skein::vision {
namespace {

/// A film of 25 frames a second, and what the tracker says of it.
struct FilmLab {
  test::Folder folder;
  Calibration calibration = overhead_calibration(2.0, 1.5);
  std::ostringstream csv;
  std::vector<std::string> told;
  std::vector<FrameLatency> latencies;

  std::string film(const std::function<std::vector<SyntheticTag>(int frame)>& scene, int frames) {
    const std::string path = folder.file("film.mkv");
    auto recorder = Recorder::open(path, {});
    EXPECT_TRUE(recorder) << recorder.error();
    SyntheticCamera camera(calibration, {}, 3);
    Frame frame;
    for (int k = 0; k < frames; ++k) {
      camera.render(scene(k), 0.04 * k, frame);
      frame.captured_at = 0.04 * k;
      frame.index = k;
      (*recorder)->add(frame);
    }
    EXPECT_EQ((*recorder)->finish().problem, "");
    return "video:" + path;
  }

  TrackTrackerOptions options(const std::string& source, std::vector<int> tags = {}) {
    return {.track = {.source = source, .calibration = calibration, .csv = &csv},
            .tags = std::move(tags),
            .latency = [this](const FrameLatency& frame) { latencies.push_back(frame); },
            .tell = [this](const std::string& sentence) { told.push_back(sentence); }};
  }
};

TEST(TrackTracker, FollowsTheTagsOfTheFirstFrameAndCounts) {
  FilmLab lab;
  const auto at = [](int k) { return core::Pose{0.2 + 0.004 * k, 0.1, 0.5}; };
  const std::string film = lab.film(
      [&](int k) {
        std::vector<SyntheticTag> tags{{2, {-0.7, -0.4, -2.5}}};
        if (k != 6) tags.push_back({1, at(k)});  // hidden for a frame
        if (k == 11) tags.push_back({9, {-0.5, 0.4, 1.0}});
        return tags;
      },
      12);
  TrackTrackerOptions options = lab.options(film);
  double time = 0.0;
  options.clock = [&] { return time += 0.001; };  // a millisecond between any two looks at it
  const auto summary = track_with_tracker(options);
  ASSERT_TRUE(summary) << summary.error();
  EXPECT_EQ(summary->track.frames, 12);
  EXPECT_EQ(summary->followed, (std::vector{1, 2}));
  EXPECT_EQ(summary->track.ids, (std::vector{1, 2}));
  EXPECT_EQ(summary->track.detections, 23);
  EXPECT_EQ(summary->detected, 2);
  EXPECT_EQ(summary->detected + summary->tracked + summary->recovered, 23);
  EXPECT_EQ(summary->lost, 1);
  EXPECT_EQ(summary->counters.frames, 12);
  EXPECT_EQ(summary->counters.poses, 23);
  EXPECT_EQ(summary->counters.rejected, 0);
  EXPECT_GE(summary->counters.decoded, 2);
  EXPECT_EQ(lab.told, std::vector<std::string>{"tag 9 came later and was not followed: name it with --tags"});

  const auto rows = test::read_csv(lab.csv.str());
  ASSERT_EQ(rows.size(), 23U);
  for (const auto& row : rows) {
    const int k = std::stoi(row.at("frame"));
    EXPECT_NEAR(std::stod(row.at("t")), 0.04 * k, 1e-9);
    if (row.at("tag") == "1") {
      EXPECT_NEAR(std::stod(row.at("x")), at(k).x, 1e-3);
    }
  }

  ASSERT_EQ(lab.latencies.size(), 12U);
  for (const FrameLatency& frame : lab.latencies) {
    EXPECT_TRUE(std::isnan(frame.arrival)) << "a film has no arrivals";
    EXPECT_NEAR(frame.grey, 0.001, 1e-9);
    for (const double stage : frame.stages) EXPECT_NEAR(stage, 0.001, 1e-9);
    EXPECT_GE(frame.tracker, std::accumulate(frame.stages.begin(), frame.stages.end(), 0.0));
  }
}

TEST(TrackTracker, SaysOnceWhyATagIsNotTaken) {
  FilmLab lab;
  const std::string film = lab.film(
      [](int) {
        return std::vector<SyntheticTag>{
            {1, {0.2, 0.1, 0.5}, 0.06}, {2, {-0.7, -0.4, -2.5}}, {3, {0.5, 0.5, 0.0}}, {3, {-0.5, 0.5, 0.0}}};
      },
      20);
  const auto summary = track_with_tracker(lab.options(film, {1, 2, 3, 4}));
  ASSERT_TRUE(summary) << summary.error();
  EXPECT_EQ(summary->followed, (std::vector{1, 2, 3, 4}));
  EXPECT_EQ(summary->track.ids, std::vector{2});
  EXPECT_GT(summary->counters.misshapen, 0) << "tag 1, of another size";
  EXPECT_GT(summary->counters.ghosts, 0) << "tag 3, twice";
  EXPECT_EQ(summary->counters.rejected,
            summary->counters.misshapen + summary->counters.unlike + summary->counters.odd + summary->counters.lifted);
  ASSERT_EQ(lab.told.size(), 3U) << fmt::format("{}", fmt::join(lab.told, "\n"));
  EXPECT_TRUE(lab.told[0].starts_with("tag 1 is there, but its edge is 60 mm, 50 % larger")) << lab.told[0];
  EXPECT_TRUE(lab.told[1].starts_with("tag 3 is there twice")) << lab.told[1];
  EXPECT_EQ(lab.told[2], "no tag 4 is in the picture");
}

TEST(TrackTracker, WritesAPictureOfATagThatIsNotTaken) {
  FilmLab lab;
  const std::string film = lab.film(
      [](int) {
        return std::vector<SyntheticTag>{{1, {0.2, 0.1, 0.5}, 0.06}, {2, {-0.7, -0.4, -2.5}}};
      },
      20);
  TrackTrackerOptions options = lab.options(film, {1, 2, 4});
  options.crops = lab.folder.file("crops");
  ASSERT_TRUE(track_with_tracker(options));
  ASSERT_EQ(lab.told.size(), 2U) << fmt::format("{}", fmt::join(lab.told, "\n"));
  EXPECT_TRUE(lab.told[0].ends_with(" (picture: " + options.crops + "/tag-1.png)")) << lab.told[0];
  EXPECT_EQ(lab.told[1], "no tag 4 is in the picture") << "the control: nothing shows it";
  TrackOptions again{.source = "images:" + options.crops};
  const auto read = track(again);
  ASSERT_TRUE(read) << read.error();
  EXPECT_EQ(read->ids, std::vector{1}) << "the picture shows the tag";
  EXPECT_EQ(read->frames, 1);
  // Of pictures that are searched one by one, each has its own.
  SyntheticCamera camera(lab.calibration, {}, 2);
  Frame frame;
  camera.render(std::vector<SyntheticTag>{{1, {0.2, 0.1, 0.5}, 0.06}}, 0.0, frame);
  test::write_pgm(lab.folder.file("a.pgm"), frame);
  lab.told.clear();
  TrackTrackerOptions stills = lab.options("images:" + lab.folder.file("a.pgm"));
  stills.crops = options.crops;
  ASSERT_TRUE(track_with_tracker(stills));
  ASSERT_EQ(lab.told.size(), 1U);
  EXPECT_TRUE(lab.told[0].ends_with("/a.pgm-tag-1.png)")) << lab.told[0];
}

TEST(TrackTracker, AGoodFilmHasNothingToSay) {
  FilmLab lab;
  const std::string film = lab.film(
      [](int) {
        return std::vector<SyntheticTag>{{1, {0.2, 0.1, 0.5}}, {2, {-0.7, -0.4, -2.5}}};
      },
      20);
  const auto summary = track_with_tracker(lab.options(film, {1, 2}));
  ASSERT_TRUE(summary) << summary.error();
  EXPECT_EQ(lab.told, std::vector<std::string>{});
  EXPECT_EQ(summary->lost + summary->counters.rejected, 0);
  EXPECT_EQ(summary->track.why_no_tag, "");
}

TEST(TrackTracker, PicturesAreSearchedEachByItself) {
  FilmLab lab;
  SyntheticCamera camera(lab.calibration, {}, 2);
  Frame frame;
  camera.render(std::vector<SyntheticTag>{{1, {0.2, 0.1, 0.5}}, {2, {-0.7, -0.4, -2.5}}}, 0.0, frame);
  test::write_pgm(lab.folder.file("a.pgm"), frame);
  camera.render(std::vector<SyntheticTag>{{5, {0.6, 0.1, 0.5}}, {6, {-0.6, -0.4, -2.5}, 0.06}}, 0.0, frame);
  test::write_pgm(lab.folder.file("b.pgm"), frame);
  const auto summary = track_with_tracker(lab.options("images:" + lab.folder.path()));
  ASSERT_TRUE(summary) << summary.error();
  EXPECT_EQ(summary->track.frames, 2);
  EXPECT_EQ(summary->followed, (std::vector{1, 2, 5, 6}));
  EXPECT_EQ(summary->track.ids, (std::vector{1, 2, 5}));
  EXPECT_EQ(summary->detected, 3);
  EXPECT_EQ(summary->lost, 0);
  EXPECT_EQ(summary->counters.full_searches, 2) << "b.pgm, at both resolutions; of a.pgm the gate finds all";
  ASSERT_EQ(lab.told.size(), 1U);
  EXPECT_TRUE(lab.told[0].starts_with("b.pgm: tag 6 is there, but its edge is 60 mm")) << lab.told[0];
}

TEST(TrackTracker, NamesTagsThatNoPictureShows) {
  FilmLab lab;
  SyntheticCamera camera(lab.calibration, {}, 2);
  Frame frame;
  camera.render(std::vector<SyntheticTag>{{1, {0.2, 0.1, 0.5}}, {6, {-0.6, -0.4, -2.5}, 0.06}}, 0.0, frame);
  test::write_pgm(lab.folder.file("a.pgm"), frame);
  const auto told_of = [&](std::vector<int> tags) {
    lab.told.clear();
    EXPECT_TRUE(track_with_tracker(lab.options("images:" + lab.folder.path(), std::move(tags))));
    return lab.told;
  };
  EXPECT_EQ(told_of({1, 4}), std::vector<std::string>{"no tag 4 is in the picture"});
  camera.render(std::vector<SyntheticTag>{{2, {0.6, 0.1, 0.5}}}, 0.0, frame);
  test::write_pgm(lab.folder.file("b.pgm"), frame);
  EXPECT_EQ(told_of({1, 2, 4}), std::vector<std::string>{"tag 4 is in none of the pictures"})
      << "the control: each of the others is in one";
  const std::vector<std::string> of_six = told_of({6});
  ASSERT_EQ(of_six.size(), 1U) << "what was said of it is enough";
  EXPECT_TRUE(of_six[0].starts_with("a.pgm: tag 6 is there, but")) << of_six[0];
}

/// Of soft pictures the reason is the same for all tags.
TEST(TrackTracker, SaysOnceThatPicturesAreSoft) {
  FilmLab lab;
  const std::vector<SyntheticTag> tags{{1, {0.2, 0.1, 0.5}}, {2, {-0.7, -0.4, -2.5}}};
  const auto write = [&](const std::string& name, double blur) {
    SyntheticCamera camera(lab.calibration, {.blur_px = blur}, 2);
    Frame frame;
    camera.render(tags, 0.0, frame);
    test::write_pgm(lab.folder.file(name), frame);
  };
  const auto told = [&] {
    lab.told.clear();
    EXPECT_TRUE(track_with_tracker(lab.options("images:" + lab.folder.path(), {1, 2})));
    return lab.told;
  };
  write("a.pgm", 6.0);
  write("b.pgm", 0.7);
  write("c.pgm", 6.0);
  std::vector<std::string> said = told();
  ASSERT_EQ(said.size(), 1U) << fmt::format("{}", fmt::join(said, "\n"));
  EXPECT_TRUE(said[0].starts_with("a.pgm, c.pgm: none of tags 1, 2 is found, and each picture is blurred (its edges"))
      << said[0];
  for (const char* name : {"d.pgm", "e.pgm", "f.pgm"}) write(name, 6.0);
  said = told();
  ASSERT_EQ(said.size(), 1U) << fmt::format("{}", fmt::join(said, "\n"));
  EXPECT_TRUE(said[0].starts_with("5 pictures from a.pgm to f.pgm: none of tags 1, 2 is found, and each")) << said[0];
}

TEST(TrackTracker, SaysThatPicturesAreSoftBeforeAnErrorEndsIt) {
  FilmLab lab;
  const std::vector<SyntheticTag> tags{{1, {0.2, 0.1, 0.5}}, {2, {-0.7, -0.4, -2.5}}};
  const auto write = [&](const std::string& name, const Calibration& calibration) {
    SyntheticCamera camera(calibration, {.blur_px = 6.0}, 2);
    Frame frame;
    camera.render(tags, 0.0, frame);
    test::write_pgm(lab.folder.file(name), frame);
  };
  write("a.pgm", lab.calibration);
  Calibration other = lab.calibration;
  other.width -= 160;
  write("b.pgm", other);
  const auto summary = track_with_tracker(lab.options("images:" + lab.folder.path(), {1, 2}));
  ASSERT_FALSE(summary);
  EXPECT_NE(summary.error().find("b.pgm"), std::string::npos) << summary.error();
  ASSERT_EQ(lab.told.size(), 1U) << fmt::format("{}", fmt::join(lab.told, "\n"));
  EXPECT_TRUE(lab.told[0].starts_with("a.pgm: none of tags 1, 2 is found, and the picture is blurred")) << lab.told[0];
}

TEST(TrackTracker, SaysOnceThatAFilmIsSoft) {
  FilmLab lab;
  const std::string path = lab.folder.file("film.mkv");
  auto recorder = Recorder::open(path, {});
  ASSERT_TRUE(recorder) << recorder.error();
  SyntheticCamera camera(lab.calibration, {.blur_px = 6.0}, 3);
  Frame frame;
  for (int k = 0; k < 20; ++k) {
    camera.render(std::vector<SyntheticTag>{{1, {0.2, 0.1, 0.5}}, {2, {-0.7, -0.4, -2.5}}}, 0.04 * k, frame);
    frame.captured_at = 0.04 * k;
    frame.index = k;
    (*recorder)->add(frame);
  }
  EXPECT_EQ((*recorder)->finish().problem, "");
  ASSERT_TRUE(track_with_tracker(lab.options("video:" + path, {1, 2})));
  ASSERT_EQ(lab.told.size(), 1U) << fmt::format("{}", fmt::join(lab.told, "\n"));
  EXPECT_TRUE(lab.told[0].starts_with("none of tags 1, 2 is found, and the picture is blurred (its edges"))
      << lab.told[0];
}

TEST(TrackTracker, NeedsAWorldFrame) {
  FilmLab lab;
  lab.calibration.world_from_camera.reset();
  const auto summary = track_with_tracker(lab.options("images:" + lab.folder.path()));
  ASSERT_FALSE(summary);
  EXPECT_EQ(summary.error(),
            "the tracker needs a calibration with a world frame (skein calibrate floor): it places tags on the floor");
}

}  // namespace
}  // namespace skein::vision
