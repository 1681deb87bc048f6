#pragma once

#include <string_view>

namespace skein::test {

/// A machine that stands still for half a second stops the robots that it drives, as it should, and what the test is
/// about has not been tried: it is tried again, up to ten times. `said` gives an attempt's words.
template <typename Attempt, typename Said>
auto unless_stalled(Attempt&& attempt, Said&& said) {
  auto result = attempt();
  for (int k = 1; k < 10 && std::string_view(said(result)).find("the program stalled for") != std::string_view::npos;
       ++k)
    result = attempt();
  return result;
}

}  // namespace skein::test
