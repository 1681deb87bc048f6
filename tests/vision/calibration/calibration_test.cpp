#include "vision/calibration/calibration.h"

#include <cmath>

#include "tests/property.h"
#include "tests/vision/support.h"

namespace skein::vision {
namespace {

/// Uniform over [-1, 1], in millionths: RapidCheck's own doubles are mostly huge.
rc::Gen<double> unit() {
  return rc::gen::map(rc::gen::inRange(-1000000, 1000001), [](int millionths) { return millionths * 1e-6; });
}

TEST(Calibration, PixelsAndPlaneGoBackAndForth) {
  test::holds("world -> pixel -> world", [] {
    const double width = 2.0 + *unit();
    const double height = 1.5 + 0.8 * *unit();
    static Calibration camera;
    camera = overhead_calibration(width, height);
    const double z = 0.05 + 0.05 * *unit();
    const Eigen::Vector3d point(0.5 * width * *unit(), 0.5 * height * *unit(), z);
    const auto pixel = pixel_from_world(camera, point);
    RC_ASSERT(pixel.has_value());
    const auto back = world_from_pixel(camera, *pixel, z);
    RC_ASSERT(back.has_value());
    RC_ASSERT((*back - point.head<2>()).norm() < 1e-9);
  });
}

TEST(Calibration, StrongDistortionIsUndoneToo) {
  // The lens of OpenCV's own sample pictures (left01.jpg ...), as published.
  Calibration camera;
  camera.width = 640;
  camera.height = 480;
  camera.fx = camera.fy = 535.916;
  camera.cx = 342.283;
  camera.cy = 235.571;
  camera.distortion = {-0.2664, -0.0386, 0.00178, -0.00028, 0.2384};
  camera.world_from_camera = CameraPose{};
  camera.world_from_camera->position = {0.0, 0.0, -1.0};  // looking up, so that p = (x / z, y / z) on the plane z = 0
  test::holds("pixel -> ray -> pixel", [&] {
    const Eigen::Vector2d pixel(319.5 + 319.5 * *unit(), 239.5 + 239.5 * *unit());
    const auto ray = ray_from_pixel(camera, pixel);
    RC_ASSERT(ray.has_value());
    const auto back = pixel_from_world(camera, {ray->x(), ray->y(), 0.0});
    RC_ASSERT(back.has_value());
    RC_ASSERT((*back - pixel).norm() < 1e-8);
  });
}

TEST(Calibration, ProjectionFollowsOpenCvsModel) {
  Calibration camera;
  camera.width = 640;
  camera.height = 480;
  camera.fx = 500.0;
  camera.fy = 510.0;
  camera.cx = 320.0;
  camera.cy = 240.0;
  camera.distortion = {0.1, -0.02, 0.003, -0.004, 0.005};
  camera.world_from_camera = CameraPose{};
  // By hand, cv::projectPoints: x = 0.3, y = -0.2, r2 = 0.13, radial = 1 + 0.1 r2 - 0.02 r2^2 + 0.005 r2^3
  // = 1.012672985, x" = x radial + 2 p1 x y + p2 (r2 + 2 x^2), y" = y radial + p1 (r2 + 2 y^2) + 2 p2 x y.
  const auto pixel = pixel_from_world(camera, {0.6, -0.4, 2.0});
  ASSERT_TRUE(pixel);
  const double radial = 1.012672985;
  EXPECT_NEAR(pixel->x(), 320.0 + 500.0 * (0.3 * radial - 0.00036 - 0.004 * 0.31), 1e-9);
  EXPECT_NEAR(pixel->y(), 240.0 + 510.0 * (-0.2 * radial + 0.003 * 0.21 + 0.00048), 1e-9);
}

TEST(Calibration, WorldIsUprightInThePicture) {
  const Calibration camera = overhead_calibration(2.0, 1.5);
  const auto middle = *pixel_from_world(camera, {0.0, 0.0, 0.0});
  EXPECT_GT(pixel_from_world(camera, {0.5, 0.0, 0.0})->x(), middle.x() + 250.0);  // x to the right
  EXPECT_LT(pixel_from_world(camera, {0.0, 0.5, 0.0})->y(), middle.y() - 250.0);  // y up
  // Things that rise towards the camera move away from the point below it.
  const auto foot = *pixel_from_world(camera, {0.9, 0.6, 0.0});
  const auto top = *pixel_from_world(camera, {0.9, 0.6, 0.06});
  EXPECT_GT(top.x(), foot.x() + 5.0);
  EXPECT_LT(top.y(), foot.y() - 3.0);
}

TEST(Calibration, WhatCannotBeSeenHasNoAnswer) {
  Calibration camera = overhead_calibration(2.0, 1.5);
  EXPECT_FALSE(pixel_from_world(camera, {0.0, 0.0, 10.0})) << "behind the camera";
  EXPECT_FALSE(world_from_pixel(camera, {600.0, 400.0}, 10.0)) << "a plane behind the camera";
  camera.distortion = {-0.3, 0.0, 0.0, 0.0, 0.0};
  EXPECT_FALSE(pixel_from_world(camera, {10.0, 0.0, 0.0})) << "where the polynomial has turned back";
  EXPECT_FALSE(ray_from_pixel(camera, {1e5, 0.0})) << "a pixel that no direction is distorted to";
  camera.world_from_camera.reset();
  EXPECT_FALSE(pixel_from_world(camera, {0.0, 0.0, 0.0}));
  EXPECT_FALSE(world_from_pixel(camera, {600.0, 400.0}, 0.0));
  EXPECT_TRUE(ray_from_pixel(camera, {600.0, 400.0})) << "needs no world frame";
}

TEST(OverheadCalibration, ArenaJustFits) {
  for (const auto& [width, height] : {std::pair{2.0, 1.5}, std::pair{1.0, 1.0}, std::pair{3.0, 1.0}}) {
    const Calibration camera = overhead_calibration(width, height);
    double least = 1e9;
    for (const double x : {-0.5 * width, 0.0, 0.5 * width}) {
      for (const double y : {-0.5 * height, 0.0, 0.5 * height}) {
        if (x == 0.0 && y == 0.0) continue;
        const auto pixel = pixel_from_world(camera, {x, y, camera.tag_height});
        ASSERT_TRUE(pixel);
        least =
            std::min({least, pixel->x(), pixel->y(), camera.width - 1 - pixel->x(), camera.height - 1 - pixel->y()});
      }
    }
    const double pixels_per_metre = camera.fx / camera.world_from_camera->position.z();
    EXPECT_GT(least, 0.05 * pixels_per_metre) << "a tag on the edge is seen whole";
    EXPECT_LT(least, 0.09 * pixels_per_metre) << "no picture is wasted";
  }
}

}  // namespace
}  // namespace skein::vision
