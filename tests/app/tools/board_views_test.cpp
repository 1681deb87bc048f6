#include "app/tools/board_views.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <fstream>
#include <string>

#include "tests/app/folder.h"
#include "vision/sheets/sheet.h"
#include "vision/sources/open_source.h"

namespace skein::app {
namespace {

/// Forty pictures, ten of each place, gave the deviations of forty views.
TEST(BoardViews, CopiesOfAPictureAreOneView) {
  const vision::Board board;
  const auto pages = vision::board_sheet(board, "A4");
  ASSERT_TRUE(pages) << pages.error();
  vision::Frame sheet;
  ASSERT_TRUE(vision::rasterise(pages->front(), 4.0, sheet));
  const test::Folder folder;
  std::ofstream(folder / "0.pgm", std::ios::binary) << "P5\n1 1\n255\n0";
  const auto pictures = vision::open_source("images:" + folder.path);
  ASSERT_TRUE(pictures) << pictures.error();

  BoardViews views(board, **pictures, false);
  using Kind = BoardViews::FrameKind;
  EXPECT_EQ(*views.add(sheet), Kind::view);
  EXPECT_EQ(*views.add(sheet), Kind::known) << "a copy";
  vision::Frame noisy = sheet;
  for (std::size_t i = 0; i < noisy.grey.size(); ++i)
    noisy.grey[i] = static_cast<std::uint8_t>(std::clamp(noisy.grey[i] + static_cast<int>(i * 7919 % 9) - 4, 0, 255));
  EXPECT_EQ(*views.add(noisy), Kind::known) << "another picture of the board in the same place";
  vision::Frame moved = sheet;  // by two pixels, which no hand avoids
  for (int v = 0; v < moved.height; ++v) std::rotate(moved.row(v), moved.row(v) + 2, moved.row(v) + moved.width);
  EXPECT_EQ(*views.add(moved), Kind::view) << "the control";
  EXPECT_EQ(views.views().size(), 2U);
}

}  // namespace
}  // namespace skein::app
