// Pictures that POV-Ray has drawn, a program that knows nothing of Skein: rendered_floor.pov and rendered_covers.pov
// say what they show.
#include <gmock/gmock.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>
#include <stdexcept>

#include "core/geometry/pose.h"
#include "tests/vision/support.h"
#include "vision/calibrate/floor_calibration.h"
#include "vision/diagnosis/diagnosis.h"
#include "vision/sources/open_source.h"
#include "vision/tracker/tracker.h"

namespace skein::vision {
namespace {

using ::testing::Contains;
using ::testing::HasSubstr;
using ::testing::SizeIs;

/// What a user does with the picture: the marks are looked for, the floor is solved, the robots are tracked.
struct RenderedFloor {
  Calibration calibration;
  std::vector<FloorMark> marks;
  FloorSight sight;

  RenderedFloor() {
    calibration.width = 640, calibration.height = 480;
    calibration.fx = calibration.fy = 575.0;
    calibration.cx = 319.5, calibration.cy = 239.5;
    const auto lay = [&](int tag, double x, double y) {
      FloorMark& mark = marks.emplace_back();
      mark.name = "tag " + std::to_string(tag);
      mark.tag = tag, mark.x = x, mark.y = y;
    };
    lay(20, -0.45, 0.33), lay(21, 0.47, 0.31), lay(22, -0.46, -0.33), lay(23, 0.45, -0.34), lay(24, 0.0, 0.30);
    lay(25, 0.27, 0.05), lay(26, -0.40, 0.0), lay(27, -0.18, -0.24), lay(28, 0.22, -0.17), lay(29, 0.75, 0.1);
    lay(30, 0.02, -0.33), lay(31, -0.30, 0.25);
    const auto source = open_source("images:" + test::in_source("tests/vision/diagnosis/rendered"));
    if (!source) throw std::runtime_error(source.error());
    auto seen = look_at_floor(**source, calibration, 1);
    if (!seen) throw std::runtime_error(seen.error());
    sight = std::move(*seen);
    enter(sight, marks);
    const auto solved = solve_trusted_floor(calibration, marks);
    if (!solved) throw std::runtime_error(solved.error());
    calibration = solved->calibration;
  }
};

TEST(RenderedFloor, IsSolvedByTheMarksThatCanBeRead) {
  const RenderedFloor floor;
  const Eigen::Vector3d& camera = floor.calibration.world_from_camera->position;
  EXPECT_NEAR(camera.x(), 0.02, 0.002);
  EXPECT_NEAR(camera.y(), -0.03, 0.002);
  EXPECT_NEAR(camera.z(), 1.0, 0.002);
  const auto check = check_floor(floor.calibration, floor.marks);
  ASSERT_TRUE(check) << check.error();
  EXPECT_EQ(check->residuals.size(), 5U);
  EXPECT_LT(check->worst, 0.5e-3);
}

TEST(RenderedFloor, SaysOfEachMarkWhatIsTheMatterWithIt) {
  const RenderedFloor floor;
  const auto said = why_not_seen(floor.sight, floor.marks, floor.calibration);
  EXPECT_THAT(said, SizeIs(7));
  const auto tells = [&](const std::string& sentence) { EXPECT_THAT(said, Contains(HasSubstr(sentence))); };
  tells("mark 24 is not seen: the reflection of a lamp lies on a part of it at (0.00, 0.30) m, pixel (");
  tells("mark 25 is not seen: part of it is covered or blurred at (0.27, 0.05) m, pixel (");
  tells("mark 26 is not seen: it is mirrored at (-0.40, 0.00) m, pixel (");
  tells(
      "mark 27 is not seen: the edge of a shadow, or something thin and dark, lies across it at (-0.18, -0.24) m, pix");
  tells("mark 28 is not seen: tag 28 of the family 25h9 lies at (0.22, -0.17) m, pixel (");
  tells("mark 29 is not seen: it lies outside the picture at (0.75, 0.10) m, pixel (");
  tells("mark 31 is not seen: nothing can be read at (-0.30, 0.25) m, pixel (");
}

TEST(RenderedFloor, SaysOfEachRobotWhatIsTheMatterWithItsTag) {
  const RenderedFloor floor;
  const std::vector<TagPose> poses = TagTracker(floor.calibration, {.tags = {1, 2, 3, 4}}).process(floor.sight.last);
  ASSERT_THAT(poses, SizeIs(2));
  EXPECT_LT(std::hypot(poses[0].pose.x + 0.20, poses[0].pose.y - 0.14), 1e-3);
  EXPECT_LT(std::hypot(poses[1].pose.x - 0.305, poses[1].pose.y - 0.055), 1e-3);
  const std::vector<MissingTag> missing{{.tag = 3}, {.tag = 4}};
  const auto diagnosed = diagnose(floor.sight.last, floor.calibration, missing);
  EXPECT_EQ(sentence(diagnosed[0], floor.calibration),
            "tag 3 is there, but no white border is around it: print it anew, and cut it out along the dashed lines");
  EXPECT_THAT(sentence(diagnosed[1], floor.calibration), HasSubstr("tag 4 is there, but its edge is "));
  EXPECT_NEAR(diagnosed[1].size, 0.03, 0.001);
}

/// What rendered_covers.pov shows, with and without the covers.
Frame rendered_robots(const std::string& name) {
  const auto source = open_source("images:" + test::in_source("tests/vision/diagnosis/" + name));
  if (!source) throw std::runtime_error(source.error());
  Frame frame;
  if (const auto more = (*source)->read(frame); !more || !*more) throw std::runtime_error(name + " cannot be read");
  return frame;
}

const std::vector<int> of_the_robots{1, 2, 3, 20, 21, 22};

TEST(RenderedCovers, OfEachTagItIsSaidWhatHidesIt) {
  const RenderedFloor floor;
  const std::vector<TagPose> before =
      TagTracker(floor.calibration, {.tags = of_the_robots}).process(rendered_robots("rendered_free.jpg"));
  ASSERT_THAT(before, SizeIs(of_the_robots.size())) << "the control: nothing covers them";
  const Frame frame = rendered_robots("rendered_covers.jpg");
  const std::vector<TagPose> poses = TagTracker(floor.calibration, {.tags = of_the_robots}).process(frame);
  ASSERT_THAT(poses, SizeIs(1));
  EXPECT_EQ(poses.front().tag, 20);
  for (const bool seen_before : {false, true}) {
    std::vector<MissingTag> missing;
    for (const TagPose& pose : before)
      if (pose.tag != 20 && pose.tag != 22)
        missing.push_back({.tag = pose.tag, .last = seen_before ? std::optional(pose.pose) : std::nullopt});
    for (const TagDiagnosis& d : diagnose(frame, floor.calibration, missing)) {
      const std::string said = sentence(d, floor.calibration) + (seen_before ? ", seen before" : ", never seen");
      EXPECT_EQ(d.why, d.tag == 21 ? NotSeen::too_bright : NotSeen::covered) << said;
      EXPECT_EQ(d.partly, d.tag == 21) << said;
      ASSERT_THAT(d.places, SizeIs(1)) << said;
      const auto pose =
          std::find_if(before.begin(), before.end(), [&](const TagPose& one) { return one.tag == d.tag; });
      EXPECT_LT((d.places.front() - Eigen::Vector2d(pose->pose.x, pose->pose.y)).norm(), 0.003) << said;
    }
  }
}

/// Covers that leave no half of a tag free, of robots that were seen before.
TEST(RenderedCovers, AskewAreNamedWhereARobotWasSeenLastAndOnlyOfItsOwnTag) {
  const RenderedFloor floor;
  const auto before =
      TagTracker(floor.calibration, {.tags = of_the_robots}).process(rendered_robots("rendered_free.jpg"));
  const Frame frame = rendered_robots("rendered_askew.jpg");
  for (const TagPose& pose : before) {
    if (pose.tag != 1 && pose.tag != 2 && pose.tag != 21) continue;
    const auto d = diagnose(frame, floor.calibration, std::array{MissingTag{.tag = pose.tag, .last = pose.pose}})[0];
    EXPECT_EQ(d.why, d.tag == 21 ? NotSeen::too_bright : NotSeen::covered) << sentence(d, floor.calibration);
    for (int other = 30; other < 40; ++other) {
      const auto no = diagnose(frame, floor.calibration, std::array{MissingTag{.tag = other, .last = pose.pose}})[0];
      EXPECT_EQ(no.why, NotSeen::not_found)
          << "the control, at " << pose.tag << ": " << sentence(no, floor.calibration);
    }
  }
}

/// The control: 22 is covered as a whole, and the others are not there, neither anywhere nor where a robot's tag is.
TEST(RenderedCovers, OfTagsThatNothingShowsItIsSaidThatTheyAreNotInThePicture) {
  const RenderedFloor floor;
  const Frame free = rendered_robots("rendered_free.jpg"), covers = rendered_robots("rendered_covers.jpg");
  const auto before = TagTracker(floor.calibration, {.tags = of_the_robots}).process(free);
  const auto none_is_there = [&](const Frame& frame, const std::vector<MissingTag>& missing) {
    for (const TagDiagnosis& d : diagnose(frame, floor.calibration, missing))
      EXPECT_EQ(d.why, NotSeen::not_found) << sentence(d, floor.calibration);
  };
  for (const Frame* frame : {&free, &covers}) {  // four at a time are searched for everywhere
    none_is_there(*frame, {{.tag = 23}, {.tag = 24}, {.tag = 25}, {.tag = 26}});
    none_is_there(*frame, {{.tag = 27}, {.tag = 30}, {.tag = 4}, {.tag = 5}});
  }
  none_is_there(covers, {{.tag = 22}});
  for (const TagPose& pose : before) {
    if (pose.tag == 22) none_is_there(covers, {{.tag = 22, .last = pose.pose}});
    none_is_there(covers, {{.tag = 23, .last = pose.pose}, {.tag = 24, .last = pose.pose}});
  }
}

/// The control, and a lens that is out of focus: marks that are there, but blurred for their size.
TEST(RenderedFloor, SaysThatAMarkIsBlurredForItsSize) {
  const RenderedFloor floor;
  MissingTag asked{.tag = 20, .mark = floor.marks.front()};
  asked.mark->size = 0.0;
  const auto why_after = [&](int passes) {
    Frame frame = floor.sight.last;
    for (int pass = 0; pass < passes; ++pass) {
      const Frame before = frame;
      for (int v = 1; v + 1 < frame.height; ++v)
        for (int u = 1; u + 1 < frame.width; ++u) {
          int sum = 0;
          for (int row = v - 1; row <= v + 1; ++row)
            for (int column = u - 1; column <= u + 1; ++column) sum += before.row(row)[column];
          frame.row(v)[u] = static_cast<std::uint8_t>((sum + 4) / 9);
        }
    }
    return diagnose(frame, floor.calibration, std::array{asked}).front();
  };
  EXPECT_NE(why_after(0).why, NotSeen::blurred);
  const TagDiagnosis blurred = why_after(3);
  EXPECT_EQ(blurred.why, NotSeen::blurred);
  EXPECT_THAT(sentence(blurred, floor.calibration), HasSubstr("turn the lens's focus"));
}

}  // namespace
}  // namespace skein::vision
