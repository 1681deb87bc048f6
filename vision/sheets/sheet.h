#pragma once

#include <string>
#include <tl/expected.hpp>
#include <vector>

#include "vision/calibration/board.h"
#include "vision/calibration/calibration.h"
#include "vision/frames/frame.h"
#include "vision/modules/page.h"

namespace skein::vision {

/// The width and height of "A4", "A3", "A2", "A1", "A0" or "letter" in mm, upright.
tl::expected<std::pair<double, double>, std::string> paper_size(const std::string& name);

struct TagSheetOptions {
  std::vector<int> tags{};         // ids of the family 36h11
  double size = default_tag_size;  // edge of the black square [m]
  std::string paper = "A4";
  int copies = 1;  // of every tag
};

/// Tags side by side, each with the white border that detectors need, cut lines around it, its id, and a mark at the
/// edge that points along the robot's heading. The error says what does not fit or is not allowed.
tl::expected<std::vector<Page>, std::string> tag_sheet(const TagSheetOptions& options);

/// A calibration board in the middle of one page.
tl::expected<std::vector<Page>, std::string> board_sheet(const Board& board, const std::string& paper);

struct SheetFile {
  std::string name{};
  std::string contents{};
};

/// Pages as a PDF, or as SVGs (one page each; further ones are NAME-2.svg, ...), by the ending of the name; lengths are
/// exact. Writes nothing.
tl::expected<std::vector<SheetFile>, std::string> sheet_files(const std::vector<Page>& pages, const std::string& path);

/// A page as an image, as seen by a camera directly above it.
tl::expected<void, std::string> rasterise(const Page& page, double px_per_mm, Frame& frame);

}  // namespace skein::vision
