// Cameras that look at one floor and disagree: drawn poses of robots in the overlap tell by how much.
#include "vision/calibrate/joint_calibration.h"

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <cmath>
#include <functional>
#include <iostream>
#include <random>

namespace skein::vision {
namespace {

using ::testing::HasSubstr;

/// Of two cameras over 2.4 x 1.2 m, beside each other, with 30 cm in both.
std::vector<Calibration> side_by_side(std::size_t n = 2) {
  std::vector<Calibration> cameras;
  for (std::size_t k = 0; k < n; ++k)
    cameras.push_back(overhead_calibration(1.5, 1.2, {1.2 * static_cast<double>(k) - 0.6, 0.0}));
  return cameras;
}

/// A calibration as if all had been measured in a frame that is turned and shifted.
Calibration off(Calibration calibration, double degrees, const Eigen::Vector2d& shift) {
  const double turn = degrees / 180.0 * core::pi;
  const Eigen::Matrix3d about_z = Eigen::AngleAxisd(turn, Eigen::Vector3d::UnitZ()).toRotationMatrix();
  CameraPose& pose = *calibration.world_from_camera;
  pose.rotation = about_z * pose.rotation;
  pose.position = about_z * pose.position + Eigen::Vector3d(shift.x(), shift.y(), 0.0);
  return calibration;
}

/// What a calibration that is believed makes of a pose that a camera sees; none: outside its picture.
std::optional<core::Pose> by(const Calibration& truth, const Calibration& believed, const core::Pose& pose) {
  const auto place = [&](double ahead) -> std::optional<Eigen::Vector2d> {
    const auto pixel = pixel_from_world(
        truth, {pose.x + ahead * std::cos(pose.theta), pose.y + ahead * std::sin(pose.theta), truth.tag_height});
    if (!pixel || pixel->x() < 20.0 || pixel->y() < 20.0 || pixel->x() > truth.width - 20.0 ||
        pixel->y() > truth.height - 20.0)
      return {};
    return world_from_pixel(believed, *pixel, believed.tag_height);
  };
  const auto at = place(0.0), ahead = place(0.01);
  if (!at || !ahead) return {};
  return core::Pose{at->x(), at->y(), std::atan2(ahead->y() - at->y(), ahead->x() - at->x())};
}

using Way = std::function<core::Pose(double t, int robot)>;

/// Three robots at 0.13 m/s on circles through the seams.
core::Pose circles(double t, int robot) {
  const double radius = 0.25, angle = 0.13 / radius * t + robot;
  const Eigen::Vector2d centre(robot % 2 == 0 ? 0.0 : 1.2, 0.3 * (robot - 1));
  return {centre.x() + radius * std::cos(angle), centre.y() + radius * std::sin(angle),
          core::wrap_angle(angle + 0.5 * core::pi)};
}

struct Scene {
  std::vector<Calibration> truth = side_by_side(), believed = truth;
  Way way = circles;
  double late = 0.0;    // of every camera but the first [s]
  double noise = 1e-4;  // [m]
  double wrong = 0.0;   // so many of the poses are of another robot
  std::vector<std::vector<TagPose>> sights() const {
    std::mt19937_64 random(1);
    std::normal_distribution<double> normal;
    std::vector<std::vector<TagPose>> all(truth.size());
    for (std::size_t camera = 0; camera < truth.size(); ++camera)
      for (int k = 0; k < 500; ++k) {
        const double t = 0.04 * k + 0.013 * static_cast<double>(camera);
        for (int robot = 0; robot < 3; ++robot) {
          core::Pose at = way(t - (camera > 0 ? late : 0.0), robot);
          if (wrong > 0.0 && std::uniform_real_distribution<double>()(random) < wrong) at.x += 0.03, at.theta += 0.2;
          auto pose = by(truth[camera], believed[camera], at);
          if (!pose) continue;
          pose->x += noise * normal(random), pose->y += noise * normal(random), pose->theta += 5e-4 * normal(random);
          all[camera].push_back({.tag = robot + 1, .pose = *pose, .captured_at = t});
        }
      }
    return all;
  }
};

/// How far the poses of a camera are off, rms over all that it sees. [m]
double error_of(const Calibration& truth, const Calibration& believed) {
  double squares = 0.0;
  int n = 0;
  for (double u = 40.0; u < truth.width; u += 50.0)
    for (double v = 40.0; v < truth.height; v += 50.0) {
      const auto is = world_from_pixel(truth, {u, v}, truth.tag_height);
      const auto said = world_from_pixel(believed, {u, v}, believed.tag_height);
      if (is && said) squares += (*is - *said).squaredNorm(), ++n;
    }
  return std::sqrt(squares / n);
}

TEST(JointCalibration, FindsADegreeAndFifteenMillimetres) {
  Scene scene;
  scene.believed[1] = off(scene.truth[1], 1.0, {0.012, -0.009});
  const auto joint = solve_joint(scene.believed, scene.sights());
  ASSERT_TRUE(joint) << joint.error();
  const double before = error_of(scene.truth[1], scene.believed[1]);
  const double after = error_of(scene.truth[1], joint->cameras[1].calibration);
  std::cout << "before_mm: " << 1e3 * before << ", after_mm: " << 1e3 * after << "\n";
  EXPECT_GT(before, 15e-3) << "the control";
  EXPECT_LT(after, 0.5e-3);
  ASSERT_EQ(joint->pairs.size(), 1U);
  EXPECT_GT(joint->pairs[0].before.rms, 10e-3);
  EXPECT_LT(joint->pairs[0].after.rms, 0.4e-3);
  EXPECT_NEAR(joint->pairs[0].before.heading, core::pi / 180.0, 1e-3);
  EXPECT_LT(joint->pairs[0].after.heading, 2e-3);
  EXPECT_EQ(joint->cameras[0].calibration, scene.believed[0]) << "the reference stays";
  EXPECT_LT(joint->cameras[1].known, 10e-3);

  const auto by_second = solve_joint(scene.believed, scene.sights(), 1);
  ASSERT_TRUE(by_second) << by_second.error();
  EXPECT_EQ(by_second->cameras[1].calibration, scene.believed[1]);
  EXPECT_LT(by_second->pairs[0].after.rms, 0.4e-3);
}

/// Where nothing is wrong, nothing is made worse; a tilt is found where cameras overlap, and moves nothing elsewhere
/// by more than it was off.
TEST(JointCalibration, LeavesWhatIsRightAndMendsATilt) {
  const Scene right;
  const auto same = solve_joint(right.believed, right.sights());
  ASSERT_TRUE(same) << same.error();
  EXPECT_LT(error_of(right.truth[1], same->cameras[1].calibration), 0.5e-3);

  Scene scene;
  scene.believed[1] = tilted(scene.truth[1], 1.0);
  const auto joint = solve_joint(scene.believed, scene.sights());
  ASSERT_TRUE(joint) << joint.error();
  const double before = error_of(scene.truth[1], scene.believed[1]);
  const double after = error_of(scene.truth[1], joint->cameras[1].calibration);
  std::cout << "tilt: before_mm: " << 1e3 * before << ", after_mm: " << 1e3 * after
            << ", known_mm: " << 1e3 * joint->cameras[1].known << "\n";
  EXPECT_LT(after, 0.25 * before);
  EXPECT_LT(joint->pairs[0].after.rms, 2e-3);
}

/// A frame that was turned round, stamps that are late, and poses of other robots.
TEST(JointCalibration, StandsGrossErrors) {
  Scene scene;
  scene.believed[1] = off(scene.truth[1], 178.0, {0.4, -0.3});
  scene.late = 0.008;
  scene.wrong = 0.05;
  const auto joint = solve_joint(scene.believed, scene.sights());
  ASSERT_TRUE(joint) << joint.error();
  const double after = error_of(scene.truth[1], joint->cameras[1].calibration);
  std::cout << "gross: after_mm: " << 1e3 * after << ", late_ms: " << 1e3 * joint->cameras[1].late << "\n";
  EXPECT_LT(after, 1.5e-3);
  EXPECT_NEAR(joint->cameras[1].late, 0.008, 3e-3);
}

TEST(JointCalibration, TiesACameraToTheReferenceThroughAnother) {
  Scene scene;
  scene.truth = scene.believed = side_by_side(3);
  scene.believed[1] = off(scene.truth[1], -1.0, {0.01, 0.0});
  scene.believed[2] = off(scene.truth[2], 1.0, {0.0, 0.015});
  const auto joint = solve_joint(scene.believed, scene.sights());
  ASSERT_TRUE(joint) << joint.error();
  EXPECT_EQ(joint->pairs.size(), 2U);
  EXPECT_LT(error_of(scene.truth[1], joint->cameras[1].calibration), 1e-3);
  EXPECT_LT(error_of(scene.truth[2], joint->cameras[2].calibration), 2e-3);
}

TEST(JointCalibration, MovesTheMarksAlong) {
  Scene scene;
  scene.believed[1] = off(scene.truth[1], 1.0, {0.012, -0.009});
  FloorMark mark;
  mark.tag = 20, mark.name = "tag 20", mark.seen = true;
  const auto pixel = pixel_from_world(scene.truth[1], {0.8, 0.2, 0.0});
  mark.u = pixel->x(), mark.v = pixel->y();
  const auto thought = world_from_pixel(scene.believed[1], *pixel, 0.0);
  mark.x = thought->x(), mark.y = thought->y();
  scene.believed[1].marks = {mark};
  const auto joint = solve_joint(scene.believed, scene.sights());
  ASSERT_TRUE(joint) << joint.error();
  const FloorMark& moved = joint->cameras[1].calibration.marks[0];
  EXPECT_NEAR(moved.x, 0.8, 1e-3);
  EXPECT_NEAR(moved.y, 0.2, 1e-3);
  EXPECT_EQ(moved.u, mark.u);
}

TEST(JointCalibration, RefusesWhatDoesNotDetermineIt) {
  const auto error = [](const Scene& scene, std::size_t reference = 0) {
    const auto joint = solve_joint(scene.believed, scene.sights(), reference);
    return joint ? std::string("solved") : joint.error();
  };
  Scene apart;
  apart.way = [](double t, int robot) { return core::Pose{-0.6 + 0.01 * t, 0.2 * robot, 0.0}; };
  EXPECT_EQ(error(apart),
            "cameras 1 and 2 saw a robot at one time at 0 places; needed: 20 or more: let robots drive where both see "
            "them");
  Scene standing;
  standing.way = [](double, int robot) { return core::Pose{0.0, 0.3 * (robot - 1), 0.0}; };
  EXPECT_THAT(error(standing), HasSubstr("at 3 places"));
  Scene line;
  line.way = [](double t, int) { return core::Pose{0.03 * (t - 10.0), 0.1, 0.0}; };
  EXPECT_THAT(error(line), HasSubstr("drove on one line (off it by 0 mm, rms); needed: 20 mm or more"));
  Scene lens;
  lens.believed[1].fx *= 1.2;
  EXPECT_THAT(error(lens), HasSubstr("still differ by"));
  Scene heights;
  heights.believed[1].tag_height = 0.08;
  EXPECT_THAT(error(heights), HasSubstr("of camera 2: height 80.0 mm"));
  Scene lost;
  lost.believed[1].world_from_camera.reset();
  EXPECT_EQ(solve_joint(lost.believed, Scene().sights()).error(),
            "camera 2 has no world frame yet: skein calibrate floor");
  EXPECT_EQ(error(Scene(), 2), "reference 3; allowed: 1 to 2");
  EXPECT_THAT(solve_joint({lost.truth[0]}, {{}}).error(), HasSubstr("needed: two or more"));
}

}  // namespace
}  // namespace skein::vision
