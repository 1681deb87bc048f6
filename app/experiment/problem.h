#pragma once

#include <string>
#include <vector>

namespace skein::app {

/// One thing wrong with an experiment file or a --set: where, what, and what is allowed.
struct Problem {
  std::string file;          ///< as given; "--set key=value" for what came from there
  int line = 0, column = 0;  ///< from 1; 0: no place in a file
  std::string text;          ///< "controller.v_max: found -1, allowed: a number above 0 m/s"

  std::string message() const;  ///< "file:line:column: text", in one line as a terminal may show it
};

/// All of them, a line each.
std::string messages(const std::vector<Problem>& problems);

}  // namespace skein::app
