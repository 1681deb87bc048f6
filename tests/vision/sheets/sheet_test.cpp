// What is printed is what is found again: sheets as pictures, through the detectors, at the right size.
#include "vision/sheets/sheet.h"
#include "tests/files.h"

#include <algorithm>
#include <cmath>

#include "tests/vision/support.h"
#include "vision/calibrate/intrinsics.h"
#include "vision/detector/detector.h"

namespace skein::vision {
namespace {

constexpr double px_per_mm = 2.0;

double edge(const Detection& d, std::size_t a, std::size_t b) {
  return std::hypot(d.corners[a][0] - d.corners[b][0], d.corners[a][1] - d.corners[b][1]);
}

TEST(Sheet, TagsAreFoundAtTheirSize) {
  const auto pages = tag_sheet({.tags = {0, 1, 7, 586}, .size = 0.06});
  ASSERT_TRUE(pages) << pages.error();
  ASSERT_EQ(pages->size(), 1U);
  Frame frame;
  ASSERT_TRUE(rasterise(pages->front(), px_per_mm, frame));
  EXPECT_EQ(frame.width, 420);
  EXPECT_EQ(frame.height, 594);
  TagDetector detector;
  std::vector<int> ids;
  for (const Detection& found : detector.detect(frame)) {
    ids.push_back(found.tag);
    for (std::size_t k = 0; k < 4; ++k) EXPECT_NEAR(edge(found, k, (k + 1) % 4), 60.0 * px_per_mm, 0.5) << found.tag;
    EXPECT_GT(found.corners[1][0], found.corners[0][0] + 100.0) << "upright: its heading points to the right";
    EXPECT_NEAR(found.corners[1][1], found.corners[0][1], 0.5);
  }
  EXPECT_EQ(ids, (std::vector{0, 1, 7, 586}));
}

TEST(Sheet, TagsGoOnToFurtherPages) {
  const auto pages = tag_sheet({.tags = {3, 4, 5}, .size = 0.04, .copies = 10});
  ASSERT_TRUE(pages) << pages.error();
  ASSERT_EQ(pages->size(), 3U);
  TagDetector detector;
  Frame frame;
  std::size_t found = 0;
  for (const Page& page : *pages) {
    ASSERT_TRUE(rasterise(page, px_per_mm, frame));
    found += detector.detect(frame).size();
    EXPECT_EQ(std::count_if(page.lines.begin(), page.lines.end(), [](const auto& l) { return l.dashed; }),
              4 * static_cast<std::ptrdiff_t>(page.triangles.size()))
        << "each tag with cut lines and a mark for its heading";
  }
  EXPECT_EQ(found, 30U);
}

TEST(Sheet, BoardsAreFoundAtTheirSize) {
  for (const auto kind : {Board::Kind::charuco, Board::Kind::chessboard})
    for (const int rows : {8, 7}) {
      const Board board{.kind = kind, .columns = 9, .rows = rows};
      const auto pages = board_sheet(board, "A4");
      ASSERT_TRUE(pages) << pages.error();
      Frame frame;
      ASSERT_TRUE(rasterise(pages->front(), 4.0, frame));
      const auto corners = find_board(frame, board);
      ASSERT_TRUE(corners) << corners.error();
      ASSERT_EQ(corners->size(), static_cast<std::size_t>(board.inner_corners())) << rows << " rows";
      for (const BoardCorner& a : *corners)
        for (const BoardCorner& b : *corners)
          EXPECT_NEAR(std::hypot(a.u - b.u, a.v - b.v), 4000.0 * std::hypot(a.x - b.x, a.y - b.y), 0.5);
    }
}

/// In a picture turned by 180 degrees a corner is found at width - 1 - u: (0, 0) is the centre of the first pixel.
TEST(Sheet, CornersOfBoardsAreFoundWhereTheyAre) {
  for (const auto kind : {Board::Kind::charuco, Board::Kind::chessboard}) {
    const Board board{.kind = kind};
    const auto pages = board_sheet(board, "A4");
    ASSERT_TRUE(pages) << pages.error();
    Frame frame;
    ASSERT_TRUE(rasterise(pages->front(), 3.0, frame));
    const auto corners = find_board(frame, board);
    std::reverse(frame.grey.begin(), frame.grey.end());
    auto turned = find_board(frame, board);
    ASSERT_TRUE(corners && turned);
    ASSERT_EQ(corners->size(), static_cast<std::size_t>(board.inner_corners()));
    ASSERT_EQ(turned->size(), corners->size());
    // The corners of a chessboard are numbered from the top left of the picture, those of a ChArUco board from its own.
    if (kind == Board::Kind::chessboard) std::reverse(turned->begin(), turned->end());
    for (std::size_t i = 0; i < corners->size(); ++i) {
      EXPECT_NEAR((*corners)[i].u, frame.width - 1 - (*turned)[i].u, 0.05) << i;
      EXPECT_NEAR((*corners)[i].v, frame.height - 1 - (*turned)[i].v, 0.05) << i;
    }
  }
}

/// OpenCV finds a chessboard among a ChArUco board's squares and markers, or searches for minutes.
TEST(Sheet, ACharucoBoardIsNoChessboard) {
  for (const int bits : {4, 5, 6, 7}) {
    const Board printed{.bits = bits};
    const auto pages = board_sheet(printed, "A4");
    ASSERT_TRUE(pages) << pages.error();
    Frame frame;
    ASSERT_TRUE(rasterise(pages->front(), 4.0, frame));
    const Board wanted{.kind = Board::Kind::chessboard};
    ASSERT_EQ(find_board(frame, printed)->size(), static_cast<std::size_t>(printed.inner_corners()));
    EXPECT_EQ(find_board(frame, wanted)->size(), 0U) << bits;
  }
}

TEST(Sheet, SaysWhatDoesNotFit) {
  EXPECT_EQ(tag_sheet({.tags = {587}}).error(), "tag 587; allowed: 0 to 586");
  EXPECT_EQ(tag_sheet({.tags = {}}).error(), "no tag is named");
  EXPECT_EQ(tag_sheet({.tags = {1}, .size = 0.3}).error(),
            "a tag of 300 mm needs 375 mm with its border, which A4 paper has no room for");
  EXPECT_EQ(tag_sheet({.tags = {1}, .paper = "A9"}).error(), "paper \"A9\"; allowed: A4, A3, A2, A1, A0, letter");
  EXPECT_EQ(board_sheet({.square = 0.03, .marker = 0.02}, "A4").error(),
            "a board of 360 x 240 mm does not fit on A4 paper with its margin of 8 mm");
}

TEST(Sheet, IsWrittenInItsSize) {
  const auto pages = tag_sheet({.tags = {0, 1, 2, 3, 4, 5, 6, 7}, .size = 0.06});
  ASSERT_TRUE(pages) << pages.error();
  ASSERT_EQ(pages->size(), 2U);
  const auto pdf = sheet_files(*pages, "there/tags.pdf").value(), svgs = sheet_files(*pages, "there/tags.svg").value();
  ASSERT_EQ(pdf.size(), 1U);
  EXPECT_EQ(pdf[0].name, "there/tags.pdf");
  EXPECT_EQ(pdf[0].contents.substr(0, 5), "%PDF-");
  ASSERT_EQ(svgs.size(), 2U);
  EXPECT_EQ(svgs[0].name, "there/tags.svg");
  EXPECT_EQ(svgs[1].name, "there/tags-2.svg");
  // A4 in points: 210 mm are 595.28.
  const std::string& svg = svgs[1].contents;
  EXPECT_NE(svg.find("width=\"595.275"), std::string::npos) << svg.substr(0, 300);
  EXPECT_NE(svg.find("height=\"841.8"), std::string::npos);
  EXPECT_EQ(sheet_files(*pages, "tags.png").error(), "tags.png: allowed: a name that ends in .pdf or .svg");
}

}  // namespace
}  // namespace skein::vision
