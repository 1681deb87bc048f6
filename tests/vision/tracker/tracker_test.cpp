#include "vision/tracker/tracker.h"

#include <algorithm>
#include <cmath>
#include <numeric>

#include "tests/vision/support.h"
#include "vision/synthetic/random.h"
#include "vision/synthetic/synthetic_camera.h"

namespace skein::vision {
namespace {

constexpr double frame_time = 0.04;

/// Errors of many poses against the truth.
struct Errors {
  double xy2 = 0.0;
  double theta2 = 0.0;
  double xy_over_sigma2 = 0.0;
  double theta_over_sigma2 = 0.0;
  int count = 0;

  void add(const TagPose& seen, const core::Pose& truth) {
    const double d2 = std::pow(core::distance(seen.pose, truth), 2);
    const double turned = core::wrap_angle(seen.pose.theta - truth.theta);
    xy2 += d2;
    theta2 += turned * turned;
    xy_over_sigma2 += 0.5 * d2 / (seen.sigma_xy * seen.sigma_xy);
    theta_over_sigma2 += turned * turned / (seen.sigma_theta * seen.sigma_theta);
    ++count;
  }
  double xy_mm() const { return 1e3 * std::sqrt(xy2 / count); }
  double theta_deg() const { return 180.0 / core::pi * std::sqrt(theta2 / count); }
};

/// A scene, its camera and its tracker.
struct TrackerLab {
  explicit TrackerLab(TrackerOptions options, const SceneOptions& scene = {}, double tag_size = default_tag_size)
      : calibration(make(tag_size)), camera(calibration, scene, 17), tracker(calibration, std::move(options)) {}

  static Calibration make(double tag_size) {
    Calibration calibration = overhead_calibration(2.0, 1.5);
    calibration.tag_size = tag_size;
    return calibration;
  }

  const std::vector<TagPose>& step(const std::vector<SyntheticTag>& tags,
                                   const std::vector<SeenElsewhere>& elsewhere = {}) {
    camera.render(tags, frame_time * static_cast<double>(tracker.counters().frames), frame);
    return tracker.process(frame, elsewhere);
  }

  Calibration calibration;
  SyntheticCamera camera;
  TagTracker tracker;
  Frame frame;
};

std::vector<int> first_ids(int count) {
  std::vector<int> ids(static_cast<std::size_t>(count));
  std::iota(ids.begin(), ids.end(), 0);
  return ids;
}

/// A dozen robots, each going round in its own part of the arena at an e-puck's full speed; together they cover all of
/// it.
std::vector<SyntheticTag> roundabout(double t, double size) {
  std::vector<SyntheticTag> tags;
  for (int i = 0; i < 12; ++i) {
    constexpr double radius = 0.2;
    const double angle = 0.5 * i + 0.13 * t / radius;
    const int column = i % 4, row = i / 4;
    tags.push_back({i,
                    {-0.75 + 0.5 * column + radius * std::cos(angle), -0.5 + 0.5 * row + radius * std::sin(angle),
                     core::wrap_angle(angle + core::pi / 2)},
                    size});
  }
  return tags;
}

void follow_roundabout(double tag_size, Errors& errors) {
  TrackerLab lab({.tags = first_ids(12)}, {}, tag_size);
  const int frames = test::sanitized ? 30 : 240;  // 9.6 s: each robot once around
  for (int k = 0; k < frames; ++k) {
    const auto tags = roundabout(k * frame_time, tag_size);
    const auto& poses = lab.step(tags);
    ASSERT_EQ(poses.size(), tags.size()) << "frame " << k;
    for (std::size_t i = 0; i < tags.size(); ++i) {
      ASSERT_EQ(poses[i].tag, tags[i].tag);
      EXPECT_EQ(poses[i].how, k == 0 ? How::detected : How::tracked);
      EXPECT_EQ(poses[i].captured_at, lab.frame.captured_at);
      EXPECT_LT(core::distance(poses[i].pose, tags[i].pose), 1e-3);
      errors.add(poses[i], tags[i].pose);
    }
  }
  const TrackerCounters& counters = lab.tracker.counters();
  EXPECT_LE(counters.full_searches, 1 + frames / 25) << "windows did the work";
  EXPECT_EQ(counters.poses, 12 * frames);
  EXPECT_EQ(counters.ghosts + counters.rejected + counters.wrong_frames, 0);
}

TEST(TagTracker, FollowsADozenRobotsOverTheArena) {
  Errors errors;
  follow_roundabout(0.06, errors);
  EXPECT_LT(errors.xy_mm(), 0.12);
  EXPECT_LT(errors.theta_deg(), 0.12);
  // The sigmas are honest: errors are as large as they say.
  EXPECT_NEAR(std::sqrt(errors.xy_over_sigma2 / errors.count), 1.0, 0.4);
  EXPECT_NEAR(std::sqrt(errors.theta_over_sigma2 / errors.count), 1.0, 0.4);
  RecordProperty("rms_mm", std::to_string(errors.xy_mm()));
  RecordProperty("rms_deg", std::to_string(errors.theta_deg()));
}

TEST(TagTracker, FollowsSmallTagsToo) {
  Errors errors;
  follow_roundabout(0.04, errors);  // the largest that fits an e-puck's body; 25 px
  EXPECT_LT(errors.xy_mm(), 0.2);
  EXPECT_LT(errors.theta_deg(), 0.3);
}

TEST(TagTracker, IsRightAtEveryPlaceAndHeading) {
  // Robots that are put somewhere else in every frame: nothing can be predicted, everything is searched.
  TrackerLab lab({.tags = first_ids(6), .search_parts = 1});
  detail::Random random(3);
  Errors errors;
  const int frames = test::sanitized ? 10 : 72;
  for (int k = 0; k < frames; ++k) {
    std::vector<SyntheticTag> tags;
    for (int i = 0; i < 6; ++i) {
      // Up to the arena's very edges, in cells of their own so that none covers another; every heading in steps of 5
      // degrees.
      const int column = i % 3, row = i / 3;
      const double x = std::clamp(-0.67 + 0.67 * column + random.between(-0.33, 0.33) * 0.85, -1.0, 1.0);
      const double y = std::clamp(-0.375 + 0.75 * row + random.between(-0.375, 0.375) * 0.85, -0.75, 0.75);
      tags.push_back(
          {i, {column == 2 && k % 5 == 0 ? 1.0 : x, y, core::wrap_angle((5.0 * k + 60.0 * i) * core::pi / 180.0)}});
    }
    const auto& poses = lab.step(tags);
    ASSERT_EQ(poses.size(), tags.size()) << "frame " << k;
    for (std::size_t i = 0; i < tags.size(); ++i) {
      ASSERT_EQ(poses[i].tag, tags[i].tag);
      errors.add(poses[i], tags[i].pose);
    }
  }
  EXPECT_LT(errors.xy_mm(), 0.3);
  EXPECT_LT(errors.theta_deg(), 0.3);
}

TEST(TagTracker, SeesInDimLightAfterAMoment) {
  TrackerLab lab({.tags = first_ids(12)}, {.noise_sigma = 2.0, .brightness = 0.15}, 0.06);
  int seen = 0;
  for (int k = 0; k < 12; ++k) seen = static_cast<int>(lab.step(roundabout(k * frame_time, 0.06)).size());
  EXPECT_EQ(seen, 12);
}

TEST(TagTracker, AMissingTagIsNotReportedAndComesBack) {
  TrackerLab lab({.tags = {3, 4}});
  const SyntheticTag stays{3, {0.5, 0.0, 0.3}};
  for (int k = 0; k < 60; ++k) {
    const SyntheticTag goes{4, {k < 20 ? -0.5 : -0.2, 0.2, -1.0}};  // and comes back elsewhere
    const bool there = k < 10 || k >= 30;
    const auto& poses = lab.step(there ? std::vector{stays, goes} : std::vector{stays});
    ASSERT_GE(poses.size(), 1U);
    EXPECT_EQ(poses[0].tag, 3);
    if (!there) {
      EXPECT_EQ(poses.size(), 1U) << "frame " << k;
    }
    if (k >= 35) {
      ASSERT_EQ(poses.size(), 2U) << "back within a search's interval";
      EXPECT_LT(core::distance(poses[1].pose, goes.pose), 1e-3);
    }
    if (there && poses.size() == 2) {
      static bool back = false;
      EXPECT_EQ(poses[1].how, k == 0 ? How::detected : k < 10 || back ? How::tracked : How::recovered) << k;
      back = k >= 30;
    }
  }
}

TEST(TagTracker, ACoveredTagIsNotReported) {
  TrackerLab lab({.tags = {4}});
  const SyntheticTag tag{4, {0.1, 0.2, 0.6}};
  EXPECT_EQ(lab.step({tag}).size(), 1U);
  EXPECT_EQ(lab.step({tag, {-1, {0.1, 0.2, 0.0}, 0.08}}).size(), 0U) << "paper over it";
  EXPECT_EQ(lab.step({tag, {-1, {0.12, 0.21, 0.6}, 0.03}}).size(), 0U) << "half of it";
  const auto& poses = lab.step({tag});
  ASSERT_EQ(poses.size(), 1U);
  EXPECT_LT(core::distance(poses[0].pose, tag.pose), 1e-3);
}

TEST(TagTracker, ATagThatIsGoneForGoodCostsFewSearches) {
  TrackerLab lab({.tags = {1, 2, 500}});
  for (int k = 0; k < 51; ++k) EXPECT_EQ(lab.step({{1, {0.5, 0.0, 0.3}}, {2, {-0.5, 0.0, 0.3}}}).size(), 2U);
  EXPECT_EQ(lab.tracker.counters().full_searches, 1) << "the first one";
  EXPECT_EQ(lab.tracker.counters().part_searches, 50) << "a forty-eighth of the frame each";
}

TEST(TagTracker, TheGateSeesTagsAtThePicturesVeryEdge) {
  TrackerLab lab({.tags = {1, 2}});
  const SyntheticTag one{1, {-0.5, -0.3, 0.3}};
  for (int k = 0; k < 5; ++k) lab.step({one});
  EXPECT_EQ(lab.tracker.counters().full_searches, 1);
  const double u1 = 1279.0 - 21.0;
  const double v1 = 959.0 - 21.0;
  const double edges[][2] = {{u1, 40.0}, {u1, 500.0}, {u1, v1}, {640.0, v1}, {21.0, v1}, {21.0, 300.0}, {640.0, 21.0}};
  for (const auto& [u, v] : edges) {
    const auto place = world_from_pixel(lab.calibration, {u, v}, lab.calibration.tag_height);
    ASSERT_TRUE(place);
    EXPECT_EQ(lab.step({one, {2, {place->x(), place->y(), 0.0}}}).size(), 2U) << u << ", " << v;
    for (int k = 0; k < 15; ++k) EXPECT_EQ(lab.step({one}).size(), 1U);
  }
  EXPECT_EQ(lab.tracker.counters().full_searches, 1);
}

TEST(TagTracker, WhatTheGateCannotSeeIsFoundPartByPart) {
  // In a shadow so deep that the other tag's light tells the gate nothing.
  TrackerOptions options{.tags = {1, 2}};
  TrackerLab lab(options, {.noise_sigma = 2.0});
  const SyntheticTag one{1, {-0.5, -0.3, 0.3}};
  const SyntheticTag two{2, {0.5, 0.3, 0.3}};
  std::size_t seen = 0;
  const int rounds = 2 * options.search_parts;  // every other one is for dim light
  for (int k = 0; k < rounds && seen < 2; ++k) {
    lab.camera.render(std::vector{one, two}, frame_time * k, lab.frame);
    const auto width = static_cast<std::size_t>(lab.frame.width), height = static_cast<std::size_t>(lab.frame.height);
    for (std::size_t v = 0; v < height; ++v)
      for (std::size_t u = width / 2; u < width; ++u) {
        std::uint8_t& grey = lab.frame.grey[v * width + u];
        grey = static_cast<std::uint8_t>(grey / 6);
      }
    seen = lab.tracker.process(lab.frame).size();
    if (k == 0) {
      EXPECT_EQ(seen, 1U);
    }
  }
  EXPECT_EQ(seen, 2U);
  EXPECT_EQ(lab.tracker.counters().full_searches, 1);
}

TEST(TagTracker, OfTwoCopiesNoneIsReported) {
  TrackerLab lab({.tags = {1, 2}});
  const SyntheticTag one{1, {0.5, 0.0, 0.3}};
  const SyntheticTag two{2, {-0.5, 0.0, 0.3}};
  const SyntheticTag copy{1, {0.0, 0.5, 2.0}};
  for (int k = 0; k < 10; ++k) {
    const auto& poses = lab.step({one, copy, two});
    ASSERT_EQ(poses.size(), 1U);
    EXPECT_EQ(poses[0].tag, 2);
  }
  EXPECT_GE(lab.tracker.counters().ghosts, 2);
  // The copy is taken away: the tag is back soon.
  std::size_t seen = 0;
  for (int k = 0; k < 5; ++k) seen = lab.step({one, two}).size();
  EXPECT_EQ(seen, 2U);
  // A copy that turns up while the tag is followed in its window is found by the next audit.
  const std::int64_t before = lab.tracker.counters().ghosts;
  for (int k = 0; k < 26; ++k) seen = lab.step({one, two, copy}).size();
  EXPECT_GT(lab.tracker.counters().ghosts, before);
  EXPECT_EQ(seen, 1U);
}

TEST(TagTracker, ACopyBesideATagIsAGhostWithinAnAudit) {
  TrackerLab lab({.tags = {1}}, {}, 0.04);
  const SyntheticTag one{1, {0.5, 0.0, 0.0}, 0.04};
  EXPECT_EQ(lab.step({one}).size(), 1U);
  const auto last = [&] {
    std::size_t seen = 1;
    for (int k = 0; k < 26 && seen == 1; ++k) seen = lab.step({one, {1, {0.58, 0.0, 0.0}, 0.04}}).size();
    return seen;
  };
  EXPECT_EQ(last(), 0U);
  EXPECT_EQ(lab.tracker.counters().ghosts, 1);
  EXPECT_EQ(lab.tracker.counters().full_searches, 0) << "the gate did it";
}

TEST(TagTracker, ARollingShutterSaysWhenEachRowWasRead) {
  // 25 us a row: 24 ms over the frame, in which a robot at full speed drives 3 mm.
  const double row_time = 25e-6;
  Calibration calibration = TrackerLab::make(0.06);
  calibration.row_time = row_time;
  SyntheticCamera camera(calibration, {}, 3);
  TagTracker tracker(calibration, {.tags = {1, 2}});
  const auto at = [](int tag, double t) {
    const double y = tag == 1 ? 0.6 : -0.6;
    return core::Pose{-0.5 + 0.13 * t, y, 0.0};
  };
  Frame frame;
  for (int k = 0; k < 10; ++k) {
    const double t = k * frame_time;
    std::vector<SyntheticTag> tags;
    for (const int tag : {1, 2}) {
      const core::Pose start = at(tag, t);
      const auto pixel = pixel_from_world(calibration, {start.x, start.y, calibration.tag_height});
      tags.push_back({tag, at(tag, t + row_time * pixel->y()), calibration.tag_size});
    }
    camera.render(tags, t, frame);
    const auto& poses = tracker.process(frame);
    ASSERT_EQ(poses.size(), 2U);
    for (const TagPose& pose : poses) {
      EXPECT_LT(core::distance(pose.pose, at(pose.tag, pose.captured_at)), 0.2e-3);
      EXPECT_GT(pose.captured_at, t);
    }
    EXPECT_GT(core::distance(poses[1].pose, at(2, t)), 2e-3) << "what the lower rows would be off by";
  }
}

TEST(TagTracker, TagsOfTheWrongSizeAreRejected) {
  TrackerLab lab({.tags = {1}});
  EXPECT_EQ(lab.step({{1, {0.5, 0.0, 0.3}, 0.09}}).size(), 0U) << "held up to the camera, as it were";
  EXPECT_GE(lab.tracker.counters().rejected, 1);
}

TEST(TagTracker, ATagThatIsLargerThanAllOthersIsNotReported) {
  TrackerLab lab({.tags = {1, 2, 3, 4}});
  const auto scene = [](double size_of_4) {
    return std::vector<SyntheticTag>{{1, {0.5, 0.0, 0.3}},
                                     {2, {-0.5, 0.0, 0.3}},
                                     {3, {0.0, 0.4, 2.0}},
                                     {4, {0.0, -0.4, -1.0}, size_of_4 * default_tag_size}};
  };
  EXPECT_EQ(lab.step(scene(1.0)).size(), 4U);
  TrackerLab with_a_larger_one({.tags = {1, 2, 3, 4}});
  EXPECT_EQ(with_a_larger_one.step(scene(1.04)).size(), 3U) << "somebody holds it";
  EXPECT_EQ(with_a_larger_one.tracker.counters().odd, 1);
  TrackerLab with_a_smaller_one({.tags = {1, 2, 3, 4}});
  EXPECT_EQ(with_a_smaller_one.step(scene(0.97)).size(), 4U) << "a misprint, in its place";
}

TEST(TagTracker, OtherTagsAreNotReported) {
  TrackerLab lab({.tags = {2, 2}});  // wanted twice is wanted once
  const auto& poses = lab.step({{1, {0.5, 0.0, 0.3}}, {2, {-0.5, 0.0, 0.3}}});
  ASSERT_EQ(poses.size(), 1U);
  EXPECT_EQ(poses[0].tag, 2);
  TagTracker nobody(lab.calibration, {});
  EXPECT_EQ(nobody.process(lab.frame).size(), 0U);
}

TEST(TagTracker, FramesOfAnotherSizeAreCountedAndPassedOver) {
  TrackerLab lab({.tags = {1}});
  EXPECT_EQ(lab.tracker.process(test::uniform_frame(640, 480, 100)).size(), 0U);
  EXPECT_EQ(lab.tracker.counters().wrong_frames, 1);
}

TEST(TagTracker, WantsAWorldFrame) {
  Calibration calibration = overhead_calibration(2.0, 1.5);
  calibration.world_from_camera.reset();
  EXPECT_THROW(TagTracker(calibration, {.tags = {1}}), std::invalid_argument);
}

TEST(TagTracker, DoesNotSearchForTagsThatAnotherCameraSees) {
  const std::vector<SeenElsewhere> outside{{1, {3.0, 0.0, 0.0}}, {2, {-1.9, 0.4, 1.0}}};
  std::int64_t searches[2] = {}, windows[2] = {};
  for (const bool told : {false, true}) {
    TrackerLab lab({.tags = first_ids(3)});
    const std::vector<SyntheticTag> tags{{0, {0.2, 0.1, 0.5}, lab.calibration.tag_size}};
    for (int k = 0; k < 20; ++k) lab.step(tags, told ? outside : std::vector<SeenElsewhere>{});
    const TrackerCounters before = lab.tracker.counters();
    for (int k = 0; k < 100; ++k) ASSERT_EQ(lab.step(tags, told ? outside : std::vector<SeenElsewhere>{}).size(), 1u);
    searches[told] = lab.tracker.counters().gates - before.gates;
    windows[told] = lab.tracker.counters().windows - before.windows;
  }
  EXPECT_EQ(searches[0], 100) << "the control: a missing tag is searched for in every frame";
  EXPECT_EQ(searches[1], 0);
  EXPECT_LE(windows[1], windows[0]);
}

/// By another camera's calibration a robot that both see is far outside this picture.
TEST(TagTracker, ACameraThatHasSeenNoTagLooksByItselfWhateverAnotherOneSees) {
  TrackerLab lab({.tags = {1}});
  const std::vector<SyntheticTag> tags{{1, {0.2, 0.1, 0.4}}};
  const std::vector<SeenElsewhere> outside{{1, {3.0, 0.0, 0.0}}};
  int frames = 0;
  while (frames < 60 && lab.step(tags, outside).empty()) ++frames;
  EXPECT_LE(frames, 50) << "two seconds: every other look is for dim light";
}

/// The same once it has seen another tag: the audit finds it.
TEST(TagTracker, ACameraFindsATagThatAnotherOneSeesBeyondItsPicture) {
  TrackerLab lab({.tags = {1, 2}});
  const std::vector<SyntheticTag> own{{2, {-0.4, -0.2, 1.0}}}, both{{2, {-0.4, -0.2, 1.0}}, {1, {0.2, 0.1, 0.4}}};
  const std::vector<SeenElsewhere> outside{{1, {3.0, 0.0, 0.0}}};
  for (int k = 0; k < 20; ++k) lab.step(own, outside);
  int frames = 0;
  while (frames < 100 && lab.step(both, outside).size() < 2) ++frames;
  EXPECT_LE(frames, 50);
}

TEST(TagTracker, SeldomSearchesForATagThatTheBorderCutsWhereAnotherCameraSeesIt) {
  TrackerLab lab({.tags = first_ids(2)});
  const double size = lab.calibration.tag_size;
  const auto edge = world_from_pixel(lab.calibration, {lab.calibration.width - 1.0, 480.0}, lab.calibration.tag_height);
  ASSERT_TRUE(edge);
  const auto inside_by = [&](double edges) { return core::Pose{edge->x() - edges * size, edge->y(), 0.3}; };
  const core::Pose half_out = inside_by(0.1);
  const std::vector<SyntheticTag> tags{{0, {0.2, 0.1, 0.5}, size}, {1, half_out, size}};
  for (int k = 0; k < 20; ++k) lab.step(tags, {{1, half_out}});
  const TrackerCounters before = lab.tracker.counters();
  for (int k = 0; k < 80; ++k) ASSERT_EQ(lab.step(tags, {{1, half_out}}).size(), 1u);
  EXPECT_LE(lab.tracker.counters().windows - before.windows, 15);  // one frame in eight, and what the audit looks at
  EXPECT_EQ(lab.tracker.counters().gates, before.gates);

  // The other camera's calibration is wrong, and the tag is whole in this picture.
  std::size_t seen = 0;
  int frames = 0;
  for (; seen < 2 && frames < 20; ++frames)
    seen = lab.step({tags[0], {1, inside_by(0.9), size}}, {{1, inside_by(0.3)}}).size();
  EXPECT_EQ(seen, 2u);
  EXPECT_LE(frames, 8);
}

TEST(TagTracker, SearchesForATagThatIsNotWhereAnotherCameraSeesIt) {
  // One of the cameras has been moved: 0.3 m apart, no window around the place shows it.
  TrackerLab lab({.tags = first_ids(2)});
  const double size = lab.calibration.tag_size;
  for (int k = 0; k < 20; ++k) lab.step({{0, {0.2, 0.1, 0.5}, size}}, {{1, {-0.3, 0.0, 0.0}}});
  const std::vector<SyntheticTag> both{{0, {0.2, 0.1, 0.5}, size}, {1, {-0.6, 0.0, 0.0}, size}};
  std::size_t seen = 0;
  for (int k = 0; k < 5; ++k) seen = lab.step(both, {{1, {-0.3, 0.0, 0.0}}}).size();
  EXPECT_EQ(seen, 2u);
}

TEST(TagTracker, SeesATagThatEntersInItsFirstFrameWhereAnotherCameraTellsItsPlace) {
  // 3 mm: two calibrations that differ a little; 20 mm: by too much for a fit, so that AprilTag looks around there.
  for (const double apart : {0.0, 0.003, 0.020}) {
    TrackerLab lab({.tags = first_ids(2)});
    const double size = lab.calibration.tag_size;
    for (int k = 0; k < 50; ++k) {
      const core::Pose beyond{1.4 - 0.004 * k, 0.2, 2.5};
      const auto& seen = lab.step({{0, {0.2, 0.1, 0.5}, size}}, {{1, beyond}});
      ASSERT_EQ(seen.size(), 1u) << "frame " << k;
    }
    const core::Pose entered{0.9, 0.2, 2.5};
    const auto& seen = lab.step({{0, {0.2, 0.1, 0.5}, size}, {1, entered, size}}, {{1, {0.9 + apart, 0.2, 2.5}}});
    ASSERT_EQ(seen.size(), 2u) << apart;
    EXPECT_EQ(seen[1].tag, 1);
    EXPECT_LT(core::distance(seen[1].pose, entered), 0.5e-3) << apart;
  }
}

}  // namespace
}  // namespace skein::vision
