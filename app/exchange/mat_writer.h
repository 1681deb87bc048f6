#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

namespace skein::app {

/// Writes MATLAB's level 5 MAT-file format, which MATLAB, Octave and SciPy load. Values are built as bytes of the file
/// (one matrix element each), then put into a variable:
///
///     mat_file("run", mat_struct({{"t", mat_column(t)}, {"mode", mat_cells(modes)}}))
///
/// Text is UTF-8. No element may be larger than 2 GB: MATLAB's limit.
inline constexpr std::uint64_t largest_mat_element = (std::uint64_t{1} << 31) - 1;

std::string mat_column(std::span<const double> values);     ///< n x 1
std::string mat_cells(std::span<const std::string> texts);  ///< n x 1 cells of texts
std::string mat_text(std::string_view text);                ///< 1 x n characters
std::string mat_struct(const std::vector<std::pair<std::string, std::string>>& fields);

/// A complete file with one variable. Throws std::length_error if it is too large.
std::string mat_file(std::string_view variable, const std::string& value);

}  // namespace skein::app
