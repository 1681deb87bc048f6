#pragma once

#include <istream>
#include <map>
#include <string>
#include <vector>

#include <tl/expected.hpp>

namespace skein::app {

/// What a page says of a run beside what its CSV says.
struct PageOrigin {
  std::string sentence;               ///< when, where and by which program it was made; empty: the program alone
  std::vector<std::string> problems;  ///< a sentence each
};

struct Page {
  std::string html;
  std::vector<std::string> warnings;  ///< a sentence each: rows that are torn, figures that could not be drawn
};

/// A run as one page that needs nothing else: an animation of the floor, the report's figures, events and summary.
/// `file` stands for the stream in messages. The figures are drawn by gnuplot in a folder of their own; without it the
/// page has none, and says so. The error names file, line and column of what cannot be read.
tl::expected<Page, std::string> report_page(std::istream& csv, const std::string& file, const PageOrigin& origin);

}  // namespace skein::app
