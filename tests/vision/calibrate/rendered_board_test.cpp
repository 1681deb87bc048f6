// A picture that POV-Ray has drawn, a program that knows nothing of Skein: rendered_board.pov beside this file.
#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <numbers>

#include "tests/files.h"
#include "tests/vision/support.h"
#include "vision/calibrate/intrinsics.h"
#include "vision/sheets/sheet.h"
#include "vision/sources/open_source.h"

namespace skein::vision {
namespace {

/// As in rendered_board.pov.
Calibration pov_camera() {
  Calibration c;
  c.width = 640;
  c.height = 480;
  c.fx = c.fy = 575.0;
  c.cx = 319.5;
  c.cy = 239.5;
  c.world_from_camera = CameraPose{Eigen::Vector3d(1.0, -1.0, -1.0).asDiagonal(), Eigen::Vector3d::Zero()};
  return c;
}

Eigen::Vector3d held(const Eigen::Vector3d& on_paper) {
  const auto turn = [](double degrees, const Eigen::Vector3d& axis) {
    return Eigen::AngleAxisd(degrees * std::numbers::pi / 180.0, axis);
  };
  return turn(-25.0, Eigen::Vector3d::UnitY()) * turn(20.0, Eigen::Vector3d::UnitX()) *
             turn(12.0, Eigen::Vector3d::UnitZ()) * on_paper +
         Eigen::Vector3d(0.01, -0.005, -0.36);
}

TEST(RenderedBoard, ItsCornersAreFoundWhereTheyAre) {
  const Board board;
  const auto pages = board_sheet(board, "A4");
  ASSERT_TRUE(pages) << pages.error();
  const Page& page = pages->front();
  const auto first = std::find_if(page.rectangles.begin(), page.rectangles.end(),
                                  [&](const Page::Rectangle& one) { return one.width == 1e3 * board.square; });
  ASSERT_NE(first, page.rectangles.end());

  const auto source = open_source("images:" + test::in_source("tests/vision/calibrate"));
  ASSERT_TRUE(source) << source.error();
  Frame frame;
  ASSERT_TRUE((*source)->read(frame).value());
  const auto corners = find_board(frame, board);
  ASSERT_TRUE(corners) << corners.error();
  ASSERT_GE(static_cast<int>(corners->size()), board.inner_corners() - 7);  // a marker is missed now and then
  Eigen::Vector2d mean = Eigen::Vector2d::Zero();
  double squares = 0.0;
  for (const BoardCorner& corner : *corners) {
    const double x = 1e-3 * (first->x - 0.5 * page.width) + corner.x;
    const double y = 1e-3 * (0.5 * page.height - first->y) - corner.y;
    const auto expected = pixel_from_world(pov_camera(), held({x, y, 0.0}));
    ASSERT_TRUE(expected);
    const Eigen::Vector2d off = Eigen::Vector2d(corner.u, corner.v) - *expected;
    mean += off / static_cast<double>(corners->size());
    squares += off.squaredNorm();
  }
  EXPECT_LT(std::abs(mean.x()), 0.06);
  EXPECT_LT(std::abs(mean.y()), 0.06);
  EXPECT_LT(std::sqrt(squares / static_cast<double>(corners->size())), 0.15);
}

}  // namespace
}  // namespace skein::vision
