// Calibration from real photographs and a real film, within what others found for them (see real_data_test).
#include <algorithm>
#include <cmath>
#include <cstdlib>

#include "tests/vision/support.h"
#include "vision/calibrate/intrinsics.h"
#include "vision/sources/open_source.h"

namespace skein::vision {
namespace {

class RealCalibration : public ::testing::Test {
 protected:
  void SetUp() override {
    root_ = test::real_data();
    if (!std::filesystem::is_directory(root_))
      GTEST_SKIP() << "no real pictures at " << root_ << ": set SKEIN_REAL_DATA to their folder";
  }

  /// The board in every `stride`-th frame.
  std::vector<BoardView> views(const std::string& source, const Board& board, int stride = 1) {
    auto opened = open_source(source);
    EXPECT_TRUE(opened) << opened.error();
    std::vector<BoardView> found;
    Frame frame;
    for (int k = 0; (*opened)->read(frame).value(); ++k) {
      if (k % stride != 0) continue;
      width_ = frame.width;
      height_ = frame.height;
      auto corners = find_board(frame, board);
      EXPECT_TRUE(corners) << corners.error();
      if (!corners->empty()) found.push_back({frame.source, std::move(*corners)});
    }
    return found;
  }

  std::string root_;
  int width_ = 0;
  int height_ = 0;
};

TEST_F(RealCalibration, ThirteenPhotosOfAChessboard) {
  const Board board{.kind = Board::Kind::chessboard, .columns = 10, .rows = 7, .square = 0.025};
  const auto seen = views("images:" + root_ + "/opencv_left", board);
  const auto result = solve_intrinsics(seen, width_, height_);
  ASSERT_TRUE(result) << result.error();
  EXPECT_EQ(result->views.size(), 13U);
  const Calibration& c = result->calibration;
  for (const double focal : {c.fx, c.fy}) {
    EXPECT_GT(focal, 530.0);
    EXPECT_LT(focal, 539.0);
  }
  EXPECT_GT(c.cx, 340.0);
  EXPECT_LT(c.cx, 345.0);
  EXPECT_GT(c.cy, 231.0);
  EXPECT_LT(c.cy, 238.0);
  EXPECT_LT(result->rms, 0.25);
}

TEST_F(RealCalibration, SeventeenPhotosOfAPhone) {
  const Board board{.kind = Board::Kind::chessboard, .columns = 8, .rows = 6, .square = 0.025};
  const auto seen = views("images:" + root_ + "/swatbotics/chessboard", board);
  const auto result = solve_intrinsics(seen, width_, height_);
  ASSERT_TRUE(result) << result.error();
  EXPECT_EQ(result->views.size(), 17U);
  EXPECT_NEAR(result->calibration.fx, 769.1, 4.0);
  EXPECT_NEAR(result->calibration.fy, 768.9, 4.0);
  EXPECT_NEAR(result->calibration.cx, 394.5, 4.0);
  EXPECT_NEAR(result->calibration.cy, 312.9, 4.0);
  EXPECT_LT(result->rms, 0.33);
}

TEST_F(RealCalibration, AFilmOfACharucoBoard) {
  const Board board{.columns = 12, .rows = 8, .square = 0.709 * 0.0254, .marker = 0.551 * 0.0254};
  const int stride = test::sanitized ? 40 : 8;
  const auto seen = views("video:" + root_ + "/wpical/testcalibration.mp4", board, stride);
  EXPECT_EQ(seen.size(), test::sanitized ? 5U : 21U);
  for (const BoardView& view : seen) EXPECT_EQ(view.corners.size(), 77U) << view.source;
  const auto result = solve_intrinsics(seen, width_, height_);
  ASSERT_TRUE(result) << result.error();
  EXPECT_LT(result->rms, 0.6);
  // The views are too much alike to determine the focal length: what matters here is that every corner is found.
}

}  // namespace
}  // namespace skein::vision
