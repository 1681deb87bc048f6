#include "app/guard/kept_awake.h"

namespace skein::app {

std::optional<std::string> KeptAwake::alarm() {
  const std::string problem = sleep_.problem();
  if (problem.empty() || std::exchange(told_, true)) return {};
  return "this machine may suspend while robots drive: " + problem;
}

}  // namespace skein::app
