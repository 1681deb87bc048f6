#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

namespace skein::app {

/// Writes MATLAB's level 5 MAT-file format, which MATLAB, Octave and SciPy load. A file holds one variable, a struct of
/// values, each of which is built as bytes of the file (one matrix element). The file is its head and the values one
/// after the other, so that they need not be in memory twice:
///
///     fields = {{"t", mat_column(t)}, {"mode", mat_cells(modes)}}
///     mat_file_head("run", fields), then each field's value
///
/// Text is UTF-8. No element may be larger than 2 GB: MATLAB's limit.
inline constexpr std::uint64_t largest_mat_element = (std::uint64_t{1} << 31) - 1;

std::string mat_column(std::span<const double> values);     ///< n x 1
std::string mat_cells(std::span<const std::string> texts);  ///< n x 1 cells of texts
std::string mat_text(std::string_view text);                ///< 1 x n characters

/// What a file has before the values of the variable's fields. Throws std::length_error if they are too large.
std::string mat_file_head(std::string_view variable, const std::vector<std::pair<std::string, std::string>>& fields);

}  // namespace skein::app
