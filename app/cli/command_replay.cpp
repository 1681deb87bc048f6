#include <fmt/format.h>

#include <cerrno>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <numbers>

#include "app/cli/commands.h"
#include "app/experiment/text_file.h"
#include "app/replay/replay.h"
#include "app/run/exit_status.h"
#include "app/run/output.h"
#include "app/run/terminal_text.h"
#include "app/runs/kept_run.h"

namespace skein::app {

int replay(const std::string& csv, const std::string& film, bool repaired, bool controller) {
  if (const auto is_file = check_is_file(csv); !is_file) {
    complain(is_file.error());
    return wrong_input;
  }
  if (repaired) {
    // Its run.json has the hash of the record as it is, and readers stop at the tear by themselves.
    if (const auto folder = std::filesystem::path(csv).parent_path().string();
        is_of_run(folder.empty() ? "." : folder, csv)) {
      complain(
          fmt::format("{}: is the record of a kept run, which `skein runs verify` would not accept any more; it "
                      "is read up to the tear as it is, allowed: a copy",
                      csv));
      return wrong_input;
    }
    if (const auto done = repair(csv); !done) {
      complain(done.error());
      return wrong_input;
    }
    complain(csv + ": repaired; the original is " + csv + ".torn");
  }
  std::ifstream file(csv, std::ios::binary);
  if (!file) {
    complain(fmt::format("{}: cannot be read: {}", csv, std::strerror(errno)));
    return wrong_input;
  }
  const auto result = replay(file, csv, film, controller);
  if (!result) {
    complain(result.error());
    return wrong_input;
  }
  for (const std::string& warning : result->warnings) complain(fmt::format("{}: {}", csv, warning));
  fmt::print("experiment: {}\nticks: {}\ncommands: {}\ndifferent: {}\n", shown(result->experiment), result->ticks,
             result->commands, result->different);
  if (result->filmed)
    fmt::print("frames: {}\nmissing_frames: {}\nposes: {}\nposes_different: {}\n", result->frames,
               result->missing_frames, result->poses, result->poses_different);
  if (!result->lossless || result->poses_approximate > 0)
    fmt::print(
        "poses_approximate: {}\nposes_missing: {}\npose_error_rms_mm: {:.4f}\npose_error_max_mm: {:.4f}\n"
        "heading_error_rms_deg: {:.4f}\n",
        result->poses_approximate, result->poses_missing, 1000.0 * result->pose_error_rms,
        1000.0 * result->pose_error_max, result->heading_error_rms * 180.0 / std::numbers::pi);
  if (result->asked) {
    fmt::print("answers: {}\nanswers_different: {}\nanswers_late: {}\n", result->answers, result->answers_different,
               result->answers_late);
    if (result->answers_different > 0)
      complain(fmt::format("{}: the controller's answers differ now; first at {}", csv, result->first_answer));
  }
  const bool other_film = result->other_film();
  if (other_film)
    complain(fmt::format("{}: {} shows none of the run's poses, or others: it is the film of another run", csv, film));
  if (!other_film && result->answers_different == 0 && result->different == 0 && result->poses_different == 0)
    return done;
  if (!result->first.empty()) complain(fmt::format("{}: the replay differs; first at {}", csv, result->first));
  return expectation_failed;
}

}  // namespace skein::app
