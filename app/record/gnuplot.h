#pragma once

#include <string>
#include <string_view>

#include <tl/expected.hpp>

namespace skein::app {

/// Runs gnuplot in a directory, with a script's name or an option, and waits for its end. The error is its output on
/// stderr, or the package that contains it.
tl::expected<void, std::string> gnuplot(const std::string& directory, const char* argument);

/// Draws NAME.pdf, NAME.svg and NAME.png in a directory by the script NAME.gp there, as all of Skein's scripts do. The
/// error also tells what gnuplot does not: that it could not write all of them.
tl::expected<void, std::string> draw_figure(const std::string& directory, const std::string& name);

/// Removes the figure of this name and its script that an earlier report left in a directory: the present one has none,
/// and would seem to have that.
void remove_figure(const std::string& directory, const std::string& name);

}  // namespace skein::app
