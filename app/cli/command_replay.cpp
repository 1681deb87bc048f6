#include <fmt/format.h>

#include <fstream>

#include "app/cli/commands.h"
#include "app/replay/replay.h"
#include "app/run/exit_status.h"

namespace skein::app {

int replay(const std::string& csv, const std::string& film) {
  std::ifstream file(csv, std::ios::binary);
  if (!file) {
    fmt::print(stderr, "skein: {}: cannot be read\n", csv);
    return wrong_input;
  }
  const auto result = replay(file, csv, film);
  if (!result) {
    fmt::print(stderr, "skein: {}\n", result.error());
    return wrong_input;
  }
  for (const std::string& warning : result->warnings) fmt::print(stderr, "skein: {}: {}\n", csv, warning);
  fmt::print("experiment: {}\nticks: {}\ncommands: {}\ndifferent: {}\n", result->experiment, result->ticks,
             result->commands, result->different);
  if (result->filmed)
    fmt::print("frames: {}\nmissing_frames: {}\nposes: {}\nposes_different: {}\n", result->frames,
               result->missing_frames, result->poses, result->poses_different);
  if (result->different == 0 && result->poses_different == 0) return done;
  fmt::print(stderr, "skein: {}: not bit for bit; first at {}\n", csv, result->first);
  return expectation_failed;
}

}  // namespace skein::app
