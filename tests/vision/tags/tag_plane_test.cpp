#include "vision/tags/tag_plane.h"

#include <cmath>

#include "tests/property.h"
#include "vision/synthetic/random.h"

namespace skein::vision {
namespace {

Corners corners_of(const Calibration& camera, const core::Pose& pose, double size) {
  constexpr double along[4] = {-0.5, 0.5, 0.5, -0.5};
  constexpr double across[4] = {-0.5, -0.5, 0.5, 0.5};
  const double c = std::cos(pose.theta) * size;
  const double s = std::sin(pose.theta) * size;
  Corners corners;
  for (std::size_t i = 0; i < 4; ++i) {
    const auto pixel = pixel_from_world(
        camera, {pose.x + c * along[i] - s * across[i], pose.y + s * along[i] + c * across[i], camera.tag_height});
    corners[i] = {pixel->x(), pixel->y()};
  }
  return corners;
}

TEST(TagPlane, ExactCornersGiveTheExactPose) {
  const Calibration camera = overhead_calibration(2.0, 1.5);
  test::holds("pose -> corners -> pose", [&] {
    const auto part = [] { return *rc::gen::inRange(-100000, 100001) * 1e-5; };
    const core::Pose pose{part(), 0.75 * part(), core::wrap_angle(core::pi * part())};
    const auto place = place_on_plane(camera, corners_of(camera, pose, camera.tag_size));
    RC_ASSERT(place.has_value());
    RC_ASSERT(core::distance(place->pose, pose) < 1e-9);
    RC_ASSERT(std::abs(core::wrap_angle(place->pose.theta - pose.theta)) < 1e-7);
    RC_ASSERT(std::abs(place->edge - camera.tag_size) < 1e-9);
    RC_ASSERT(place->misfit < 1e-9);
  });
}

TEST(TagPlane, SigmasMatchTheScatterOfNoisyCorners) {
  const Calibration camera = overhead_calibration(2.0, 1.5);
  const core::Pose pose{0.4, -0.3, 0.8};
  const Corners exact = corners_of(camera, pose, camera.tag_size);
  detail::Random random(1);
  const auto normal = [&] {  // the sum of twelve uniforms: near enough
    double sum = -6.0;
    for (int i = 0; i < 12; ++i) sum += random.unit();
    return sum;
  };
  constexpr double noise = 0.2;
  constexpr int count = 4000;
  double x2 = 0.0;
  double theta2 = 0.0;
  for (int k = 0; k < count; ++k) {
    Corners corners = exact;
    for (auto& corner : corners) corner = {corner[0] + noise * normal(), corner[1] + noise * normal()};
    const auto place = place_on_plane(camera, corners);
    ASSERT_TRUE(place);
    x2 += std::pow(place->pose.x - pose.x, 2);
    theta2 += std::pow(core::wrap_angle(place->pose.theta - pose.theta), 2);
  }
  const PoseSigma sigma = pose_sigma(*place_on_plane(camera, exact), noise);
  EXPECT_NEAR(std::sqrt(x2 / count) / sigma.xy, 1.0, 0.05);
  EXPECT_NEAR(std::sqrt(theta2 / count) / sigma.theta, 1.0, 0.05);
}

TEST(TagPlane, CrookedCornersAreTrustedLess) {
  const Calibration camera = overhead_calibration(2.0, 1.5);
  Corners corners = corners_of(camera, {}, camera.tag_size);
  const PoseSigma straight = pose_sigma(*place_on_plane(camera, corners), corner_sigma_px);
  corners[2][0] += 3.0;
  const PoseSigma crooked = pose_sigma(*place_on_plane(camera, corners), corner_sigma_px);
  EXPECT_GT(crooked.xy, 5.0 * straight.xy);
  EXPECT_GT(crooked.theta, 5.0 * straight.theta);
}

TEST(TagPlane, CornersThatCannotBePlacedHaveNoPose) {
  Calibration camera = overhead_calibration(2.0, 1.5);
  const Corners corners = corners_of(camera, {}, camera.tag_size);
  EXPECT_FALSE(place_on_plane(camera, Corners{})) << "all in one point";
  camera.tag_height = 10.0;
  EXPECT_FALSE(place_on_plane(camera, corners));
  camera.world_from_camera.reset();
  EXPECT_FALSE(place_on_plane(camera, corners));
  EXPECT_EQ(tag_edge_px(camera), 0.0);
}

}  // namespace
}  // namespace skein::vision
