#pragma once

#include <istream>
#include <map>
#include <string>
#include <vector>

#include <tl/expected.hpp>

namespace skein::app {

/// A tag that was not seen.
struct PageCrop {
  std::size_t robot = 0;
  std::string sentence;  ///< why
  std::string png;       ///< what the camera showed of it; empty: nothing
};

/// The contents of a page in addition to the run's CSV.
struct PageOrigin {
  std::string sentence;               ///< when, where and by which program it was made; empty: only the program
  std::vector<std::string> problems;  ///< a sentence each
  std::vector<PageCrop> crops{};
};

struct Page {
  std::string html;
  std::vector<std::string> warnings;  ///< a sentence each: torn rows, figures that could not be drawn
};

/// A run as one self-contained page: an animation of the floor, the report's figures, events and summary. `file` stands
/// for the stream in messages. gnuplot draws the figures in a temporary folder; without it the page has none, and says
/// so. The error names file, line and column of invalid input.
tl::expected<Page, std::string> report_page(std::istream& csv, const std::string& file, const PageOrigin& origin);

}  // namespace skein::app
