// What marks on the floor tell of their camera, one frame after the other.
#include "vision/diagnosis/mark_watch.h"

#include <functional>

#include "tests/vision/support.h"
#include "vision/synthetic/synthetic_camera.h"

namespace skein::vision {
namespace {

using MarkState = MarkSight::State;

/// Five tags on the floor, as the calibration has them and as they lie now.
struct MarkedFloor {
  Calibration calibration = overhead_calibration(2.0, 1.5);
  std::vector<SyntheticTag> tags;
  std::vector<SyntheticDisc> discs;
  double tilt = 0.0;  // of the camera since [deg]
  Frame frame;

  MarkedFloor() {
    for (const auto& [x, y] : {std::pair{-0.8, 0.6}, {0.8, 0.6}, {0.8, -0.6}, {-0.8, -0.6}, {0.1, 0.1}}) {
      const int id = 20 + static_cast<int>(tags.size());
      calibration.marks.push_back({.name = "tag " + std::to_string(id), .tag = id, .x = x, .y = y, .size = 0.08});
      tags.push_back({.tag = id, .pose = {x, y, 0.7}, .size = 0.08, .lifted = -calibration.tag_height, .bare = true});
    }
  }
  const Frame& seen() {
    SyntheticCamera(tilted(calibration, tilt), {}, 5).render(tags, discs, 0.0, frame);
    return frame;
  }
  void hide(std::size_t mark) {
    discs.push_back({.x = tags[mark].pose.x, .y = tags[mark].pose.y, .radius = 0.05, .height = 0.06});
  }
};

TEST(MarkWatch, KnowsAtOnceThatNothingHasMoved) {
  MarkedFloor floor;
  MarkWatch watch(floor.calibration, {});
  EXPECT_EQ(watch.marks(), 5U);
  EXPECT_FALSE(watch.known());
  EXPECT_TRUE(watch.update(floor.seen()));
  ASSERT_TRUE(watch.known());
  EXPECT_EQ(watch.known()->state, MarkState::in_place) << sentence(*watch.known());
  EXPECT_EQ(watch.known()->seen, 5U);
  EXPECT_LT(watch.known()->by, 0.5e-3);
  EXPECT_FALSE(watch.doubts());
  EXPECT_FALSE(watch.update(floor.seen())) << "that is no news";
}

TEST(MarkWatch, ACameraThatMovedIsBelievedAtTheSecondSight) {
  MarkedFloor floor;
  MarkWatch watch(floor.calibration, {});
  watch.update(floor.seen());
  floor.tilt = 0.5;
  EXPECT_FALSE(watch.update(floor.seen()));
  EXPECT_EQ(watch.known()->state, MarkState::in_place);
  EXPECT_TRUE(watch.doubts());
  EXPECT_TRUE(watch.update(floor.seen()));
  EXPECT_EQ(watch.known()->state, MarkState::camera_moved);
  EXPECT_NEAR(watch.known()->by, 0.021, 0.003);
  EXPECT_FALSE(watch.doubts());
  floor.tilt = 0.0;
  EXPECT_FALSE(watch.update(floor.seen()));
  EXPECT_TRUE(watch.update(floor.seen())) << "it was put back";
  EXPECT_EQ(watch.known()->state, MarkState::in_place);
}

TEST(MarkWatch, AFrameThatIsTornOnceIsNoCameraThatMoved) {
  MarkedFloor floor;
  MarkWatch watch(floor.calibration, {});
  watch.update(floor.seen());
  floor.tilt = 0.5;
  EXPECT_FALSE(watch.update(floor.seen()));
  floor.tilt = 0.0;
  EXPECT_FALSE(watch.update(floor.seen()));
  EXPECT_FALSE(watch.update(floor.seen()));
  EXPECT_EQ(watch.known()->state, MarkState::in_place);
  EXPECT_FALSE(watch.doubts());
}

TEST(MarkWatch, NamesTheMarkThatSomebodyMoved) {
  MarkedFloor floor;
  MarkWatch watch(floor.calibration, {});
  floor.tags[2].pose.x -= 0.03;
  EXPECT_FALSE(watch.update(floor.seen()));
  EXPECT_TRUE(watch.update(floor.seen()));
  EXPECT_EQ(watch.known()->state, MarkState::some_moved);
  EXPECT_EQ(watch.known()->moved, std::vector{22});
  EXPECT_EQ(sentence(*watch.known()),
            "mark 22 was moved by 30 mm, or put back wrongly; the other 4 that are seen lie where they were");
  // And the camera is known to move all the same.
  floor.tilt = 0.5;
  watch.update(floor.seen());
  watch.update(floor.seen());
  EXPECT_EQ(watch.known()->state, MarkState::camera_moved);
}

TEST(MarkWatch, ByFewerThanThreeNobodyKnows) {
  MarkedFloor floor;
  MarkWatch watch(floor.calibration, {});
  watch.update(floor.seen());
  for (const std::size_t mark : {0U, 1U, 2U}) floor.hide(mark);
  floor.tilt = 0.5;
  for (int k = 0; k < 3; ++k) EXPECT_FALSE(watch.update(floor.seen()));
  EXPECT_EQ(watch.known()->state, MarkState::in_place) << "what was known is still the best that is";
  MarkWatch late(floor.calibration, {});
  late.update(floor.seen());
  late.update(floor.seen());
  ASSERT_TRUE(late.known());
  EXPECT_EQ(late.known()->state, MarkState::too_few);
  EXPECT_EQ(sentence(*late.known()),
            "2 of 5 marks on the floor are seen, 3 are needed to tell whether the camera has moved");
}

TEST(MarkWatch, TellsThatMarksAreHiddenOnlyIfThatLasts) {
  MarkedFloor floor;
  MarkWatch watch(floor.calibration, {});
  double t = 0.0;
  const auto look = [&] {
    floor.seen();
    floor.frame.captured_at = t;
    t += 2.0;
    EXPECT_FALSE(watch.update(floor.frame) && t > 2.0) << "the camera has not moved";
    return watch.blind();
  };
  EXPECT_EQ(look(), nullptr);
  for (const double hidden_for : {MarkWatch::patience - 2.0, MarkWatch::patience + 4.0}) {  // from first to last look
    for (const std::size_t mark : {0U, 1U, 2U}) floor.hide(mark);
    for (const double began = t; t <= began + hidden_for;) {
      const bool lasts = t - began >= MarkWatch::patience;
      const MarkSight* blind = look();
      ASSERT_EQ(blind != nullptr, lasts) << t - began;
      if (blind) {
        EXPECT_EQ(blind->seen, 2U);
        EXPECT_EQ(watch.known()->state, MarkState::in_place) << "what was known still holds";
      }
    }
    floor.discs.clear();
    EXPECT_EQ(look(), nullptr);
  }
}

/// The control: one robot after the other that stands still, for ever, on a mark of its own.
TEST(MarkWatch, IsNotBlindWhileThreeMarksAreSeen) {
  MarkedFloor floor;
  MarkWatch watch(floor.calibration, {});
  double t = 0.0;
  for (const std::size_t hidden : {0U, 1U, 2U}) {
    for (const double until = t + MarkWatch::patience + 4.0; t < until; t += 2.0) {
      floor.seen();
      floor.frame.captured_at = t;
      watch.update(floor.frame);
      ASSERT_EQ(watch.blind(), nullptr) << hidden << " are hidden";
    }
    if (hidden < 2) floor.hide(hidden);
  }
  ASSERT_TRUE(watch.known());
  EXPECT_EQ(watch.known()->seen, 3U);
}

/// Two of four lie elsewhere: whether the camera or the marks have moved is as little known as with too few.
TEST(MarkWatch, IsBlindWhereMarksContradictEachOther) {
  MarkedFloor floor;
  floor.tags.pop_back();
  MarkWatch watch(floor.calibration, {});
  double t = 0.0;
  for (; t < 4.0 + MarkWatch::patience; t += 2.0) {
    if (t == 2.0)
      for (const std::size_t mark : {0U, 1U}) floor.tags[mark].pose.x += 0.03;
    floor.seen();
    floor.frame.captured_at = t;
    watch.update(floor.frame);
    ASSERT_EQ(watch.blind() != nullptr, t >= 2.0 + MarkWatch::patience) << t;
  }
  EXPECT_EQ(watch.blind()->state, MarkState::unclear) << sentence(*watch.blind());
}

TEST(MarkWatch, AMarkThatIsHalfHiddenIsNotSeen) {
  // A body beside a mark, nearer step by step: at no place does it move the mark.
  MarkedFloor floor;
  MarkWatch watch(floor.calibration, {});
  watch.update(floor.seen());
  std::size_t least = 5;
  for (double at = -0.10; at <= 0.10; at += 0.01) {
    floor.discs = {{.x = 0.1 + at, .y = 0.1 + 0.5 * at, .radius = 0.035, .height = 0.06}};
    EXPECT_FALSE(watch.update(floor.seen())) << at;
    EXPECT_EQ(watch.known()->state, MarkState::in_place) << at;
    least = std::min(least, watch.known()->seen);
  }
  EXPECT_EQ(least, 4U) << "the control: it was hidden";
}

/// Each reason is that of a mark: its own place, size and height, and nothing about robots.
TEST(MarkWatch, SaysOfAMarkThatIsMissingWhyAndWhere) {
  const auto why = [](const std::function<void(MarkedFloor&)>& change) {
    MarkedFloor floor;
    change(floor);
    MarkWatch watch(floor.calibration, {});
    watch.update(floor.seen());
    const std::vector<MissingTag> missing = watch.missing();
    EXPECT_EQ(missing.size(), 1U);
    if (missing.empty()) return std::string();
    return sentence(diagnose(floor.frame, floor.calibration, missing).front(), floor.calibration);
  };
  const std::string at = " at (0.10, 0.10) m, pixel (703, 419)", mark = "mark 24 is not seen: ";
  const auto begins = [&](const std::string& said, const std::string& reason) {
    EXPECT_TRUE(said.starts_with(mark + reason + at)) << said;
    EXPECT_EQ(said.find("robot"), std::string::npos) << said;
  };
  begins(why([](MarkedFloor& floor) { floor.hide(4); }), "nothing can be read");
  begins(why([](MarkedFloor& floor) { floor.tags[4].size = 0.05; }), "its edge is 50 mm");
  begins(why([](MarkedFloor& floor) { floor.tags.push_back(floor.tags[4]), floor.tags[5].pose.x += 0.5; }),
         "it is there twice");
  // In a deep shadow, and on a box of 20 cm that the calibration knows of.
  begins(why([](MarkedFloor& floor) {
           floor.discs = {{.x = 0.1, .y = 0.1, .radius = 0.09, .height = 0.0, .grey = 0.0, .cover = 0.995}};
         }),
         "the picture is dark");
  const std::string on_a_box = why([](MarkedFloor& floor) {
    floor.tags[4].lifted += 0.2;
    floor.tags[4].size = 0.05;
    floor.calibration.marks[4].z = 0.2;
  });
  EXPECT_TRUE(on_a_box.starts_with(mark + "its edge is 50 mm at (0.10, 0.10) m")) << on_a_box;
}

TEST(MarkWatch, GoesByThePixelsOfTheCalibrationAndNotByWhatATapeMeasureSaid) {
  MarkedFloor floor;
  for (FloorMark& mark : floor.calibration.marks) {
    const auto pixel = pixel_from_world(floor.calibration, {mark.x, mark.y, 0.0});
    mark.u = pixel->x(), mark.v = pixel->y();
    mark.seen = true;
    mark.x += 0.008;  // the calibration was content with less
  }
  MarkWatch watch(floor.calibration, {});
  watch.update(floor.seen());
  ASSERT_TRUE(watch.known());
  EXPECT_EQ(watch.known()->state, MarkState::in_place);
  for (FloorMark& mark : floor.calibration.marks) mark.seen = false;
  MarkWatch control(floor.calibration, {});
  control.update(floor.seen());
  control.update(floor.seen());
  EXPECT_EQ(control.known()->state, MarkState::camera_moved);
}

TEST(MarkWatch, LooksForNoTagThatARobotCarries) {
  MarkedFloor floor;
  floor.calibration.marks.push_back({.name = "point 1", .x = 0.3, .y = 0.2});
  const std::vector robots{1, 21, 22};
  EXPECT_EQ(MarkWatch(floor.calibration, robots).marks(), 3U);
  floor.calibration.world_from_camera.reset();
  EXPECT_EQ(MarkWatch(floor.calibration, robots).marks(), 0U);
}

}  // namespace
}  // namespace skein::vision
