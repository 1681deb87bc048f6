#include "vision/sheets/sheet.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cstdint>
#include <filesystem>
#include <string_view>

#include "vision/modules/media_loader.h"
#include "vision/tags/tag_pattern.h"

namespace skein::vision {
namespace {

constexpr double margin = 8.0;    // that printers cannot print on [mm]
constexpr double hairline = 0.1;  // [mm]
constexpr double caption = 7.0;   // below a tag, for its id and size; cut off [mm]
constexpr double letters = 3.0;   // [mm]

/// The dark cells of a square pattern, those side by side in one piece: seams between cells would show as hairlines.
void add_cells(Page& page, double left, double top, double cell, int cells, const std::vector<bool>& dark) {
  for (int row = 0; row < cells; ++row)
    for (int column = 0; column < cells;) {
      int end = column;
      while (end < cells && dark[static_cast<std::size_t>(std::int64_t{row} * cells + end)]) ++end;
      if (end > column)
        page.rectangles.push_back({left + column * cell, top + row * cell, (end - column) * cell, cell});
      column = std::max(end, column + 1);
    }
}

void add_tag(Page& page, int tag, const detail::TagPattern& pattern, double size, double left, double top) {
  const double cell = size / 8.0;
  const double paper = size + 2.0 * cell;
  std::vector<bool> dark(pattern.size());
  std::transform(pattern.begin(), pattern.end(), dark.begin(), [](bool light) { return !light; });
  add_cells(page, left, top, cell, detail::pattern_cells, dark);
  const double right = left + paper;
  const double bottom = top + paper;
  page.lines.push_back({left, top, right, top, hairline, true});
  page.lines.push_back({left, bottom, right, bottom, hairline, true});
  page.lines.push_back({left, top, left, bottom, hairline, true});
  page.lines.push_back({right, top, right, bottom, hairline, true});
  // Ahead is to the right: a small arrow in the white border, narrow enough to leave the detector its edge.
  const double mark = 0.3 * cell;
  const double middle = 0.5 * (top + bottom);
  page.triangles.push_back({{right - 0.2 * cell - mark, right - 0.2 * cell - mark, right - 0.2 * cell},
                            {middle - mark, middle + mark, middle}});
  page.words.push_back({left, bottom + 0.6 * caption, letters, fmt::format("36h11  {}   {:g} mm", tag, size)});
}

/// Shows on the print whether the printer has changed the size.
void add_ruler(Page& page) {
  const double y = page.height - margin;
  page.lines.push_back({margin, y, margin + 100.0, y, 2.0 * hairline, false});
  for (int i = 0; i <= 10; ++i)
    page.lines.push_back({margin + 10.0 * i, y - 2.0, margin + 10.0 * i, y, 2.0 * hairline, false});
  page.words.push_back({margin + 103.0, y, letters, "100 mm: print at 100 %, measure this"});
}

constexpr double ruler = 6.0;  // room for it [mm]

}  // namespace

tl::expected<std::pair<double, double>, std::string> paper_size(const std::string& name) {
  struct Paper {
    std::string_view name;
    double width, height;
  };
  static constexpr std::array known{Paper{"A4", 210.0, 297.0},  Paper{"A3", 297.0, 420.0},
                                    Paper{"A2", 420.0, 594.0},  Paper{"A1", 594.0, 841.0},
                                    Paper{"A0", 841.0, 1189.0}, Paper{"letter", 215.9, 279.4}};
  for (const Paper& paper : known)
    if (paper.name == name) return std::pair(paper.width, paper.height);
  return tl::unexpected(fmt::format("paper \"{}\"; allowed: A4, A3, A2, A1, A0, letter", name));
}

tl::expected<std::vector<Page>, std::string> tag_sheet(const TagSheetOptions& options) {
  const auto paper = paper_size(options.paper);
  if (!paper) return tl::unexpected(paper.error());
  const double size = 1000.0 * options.size;
  if (!(size >= 5.0 && size <= 2000.0))
    return tl::unexpected(fmt::format("tags of {:g} mm; allowed: 5 to 2000 mm", size));
  const std::vector<detail::TagPattern> patterns = detail::tag_patterns();
  std::vector<int> tags;
  for (const int tag : options.tags) {
    if (tag < 0 || static_cast<std::size_t>(tag) >= patterns.size())
      return tl::unexpected(fmt::format("tag {}; allowed: 0 to {}", tag, patterns.size() - 1));
    tags.insert(tags.end(), static_cast<std::size_t>(std::max(1, options.copies)), tag);
  }
  if (tags.empty()) return tl::unexpected(std::string("no tag is named"));

  const double whole = 1.25 * size;  // with its white border
  const double gap = 4.0;
  const int columns = static_cast<int>((paper->first - 2.0 * margin + gap) / (whole + gap));
  const int rows = static_cast<int>((paper->second - 2.0 * margin - ruler + gap) / (whole + caption + gap));
  if (columns < 1 || rows < 1)
    return tl::unexpected(fmt::format("a tag of {:g} mm needs {:g} mm with its border, which {} paper has no room for",
                                      size, whole, options.paper));
  std::vector<Page> pages;
  const auto on_page = static_cast<std::size_t>(std::int64_t{columns} * rows);
  for (std::size_t i = 0; i < tags.size(); ++i) {
    if (i % on_page == 0) {
      Page& page = pages.emplace_back();
      page.width = paper->first;
      page.height = paper->second;
      add_ruler(page);
    }
    const int column = static_cast<int>(i % on_page) % columns;
    const int row = static_cast<int>(i % on_page) / columns;
    add_tag(pages.back(), tags[i], patterns[static_cast<std::size_t>(tags[i])], size, margin + column * (whole + gap),
            margin + row * (whole + caption + gap));
  }
  return pages;
}

tl::expected<std::vector<Page>, std::string> board_sheet(const Board& board, const std::string& paper) {
  if (std::string problem = check(board); !problem.empty()) return tl::unexpected(problem);
  const auto size = paper_size(paper);
  if (!size) return tl::unexpected(size.error());
  const double square = 1000.0 * board.square;
  const double width = square * board.columns;
  const double height = square * board.rows;
  Page page;
  page.width = size->first;
  page.height = size->second;
  const auto fits = [&] { return width <= page.width - 2.0 * margin && height <= page.height - 2.0 * margin - ruler; };
  if (!fits()) std::swap(page.width, page.height);
  if (!fits())
    return tl::unexpected(fmt::format("a board of {:g} x {:g} mm does not fit on {} paper with its margin of {:g} mm",
                                      width, height, paper, margin));
  add_ruler(page);
  const double left = 0.5 * (page.width - width);
  const double top = std::max(margin, 0.5 * (page.height - ruler - height));
  const Boards* module = nullptr;
  if (board.has_markers()) {
    const auto loaded = boards();
    if (!loaded) return tl::unexpected(loaded.error());
    module = *loaded;
  }
  const double marker = 1000.0 * board.marker;
  const int cells = board.bits + 2;
  int next = 0;
  for (int row = 0; row < board.rows; ++row)
    for (int column = 0; column < board.columns; ++column) {
      const double x = left + column * square;
      const double y = top + row * square;
      if ((row + column) % 2 == 0)
        page.rectangles.push_back({x, y, square, square});
      else if (module != nullptr)
        add_cells(page, x + 0.5 * (square - marker), y + 0.5 * (square - marker), marker / cells, cells,
                  module->marker(board.bits, next++));
    }
  const std::string kind =
      board.has_markers() ? fmt::format("ChArUco, markers {:g} mm, DICT_{}X{}_1000", marker, board.bits, board.bits)
                          : "chessboard";
  page.words.push_back({margin, page.height - margin - 3.5, letters,
                        fmt::format("{} x {} squares of {:g} mm, {}", board.columns, board.rows, square, kind)});
  return std::vector<Page>{page};
}

tl::expected<std::vector<SheetFile>, std::string> sheet_files(const std::vector<Page>& pages, const std::string& path) {
  const std::filesystem::path first(path);
  const bool pdf = first.extension() == ".pdf";
  if (!pdf && first.extension() != ".svg")
    return tl::unexpected(fmt::format("{}: allowed: a name that ends in .pdf or .svg", path));
  const auto module = boards();
  if (!module) return tl::unexpected(module.error());
  std::vector<SheetFile> files(pdf ? 1 : pages.size());
  for (std::size_t i = 0; i < files.size(); ++i) {
    std::filesystem::path name = first;
    if (i > 0) name.replace_filename(fmt::format("{}-{}.svg", first.stem().string(), i + 1));
    files[i].name = name.string();
    const std::vector<Page> here = pdf ? pages : std::vector<Page>{pages[i]};
    if (const std::string problem = (*module)->draw(here, pdf, files[i].contents); !problem.empty())
      return tl::unexpected(fmt::format("{}: cannot be drawn: {}", files[i].name, problem));
  }
  return files;
}

tl::expected<void, std::string> rasterise(const Page& page, double px_per_mm, Frame& frame) {
  const auto module = boards();
  if (!module) return tl::unexpected(module.error());
  if (std::string problem = (*module)->rasterise(page, px_per_mm, frame); !problem.empty())
    return tl::unexpected(problem);
  return {};
}

}  // namespace skein::vision
