#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <optional>
#include <system_error>
#include <vector>

#include "app/calibration/calibration_file.h"
#include "app/cli/command_calibrate.h"
#include "app/cli/commands.h"
#include "app/run/exit_status.h"
#include "app/run/interrupted.h"
#include "app/run/number_text.h"
#include "app/run/output.h"
#include "app/tools/joint_films.h"
#include "core/geometry/pose.h"

namespace skein::app {
namespace {

namespace fs = std::filesystem;

std::string in_mm(double metres) {
  return fmt::format("{:.2f} mm", 1e3 * metres);
}

std::string in_words(const vision::JointPair::Apart& apart) {
  return fmt::format("{} (worst {}, heading {:.3f} deg)", in_mm(apart.rms), in_mm(apart.worst),
                     180.0 / core::pi * apart.heading);
}

void print(const JointFilms& found, std::size_t reference) {
  for (std::size_t k = 0; k < found.frames.size(); ++k)
    print_out(fmt::format("camera {}: {} frames, {} sights of robots\n", k + 1, found.frames[k], found.sights[k]));
  for (const vision::JointPair& pair : found.joint.pairs)
    print_out(fmt::format("cameras {} and {}: {} places{}\n  before: {}\n  after: {}\n", pair.first + 1,
                          pair.second + 1, pair.places,
                          pair.left_out > 0 ? fmt::format(", {} left out", pair.left_out) : "", in_words(pair.before),
                          in_words(pair.after)));
  for (std::size_t k = 0; k < found.joint.cameras.size(); ++k) {
    const vision::JointCamera& camera = found.joint.cameras[k];
    print_out(
        k == reference
            ? fmt::format("camera {}: the reference\n", k + 1)
            : fmt::format("camera {}: its poses move by {}; in the corners of its picture known to {}; its stamps "
                          "are {} ms late\n",
                          k + 1, in_mm(camera.moved), in_mm(camera.known), fixed(1e3 * camera.late, 1)));
  }
}

/// Where each camera's calibration goes; the reference's, and those of synthetic cameras without --out, nowhere.
std::vector<fs::path> destinations(const JointRequest& request, const Experiment& experiment) {
  std::vector<fs::path> paths(experiment.cameras());
  for (std::size_t k = 0; k < paths.size(); ++k) {
    if (k + 1 == request.reference) continue;
    const fs::path file = experiment.calibration_file(k);
    if (request.save)
      paths[k] = file;
    else if (!request.out.empty())
      paths[k] =
          fs::path(request.out) / (file.empty() ? fs::path(fmt::format("camera-{}.toml", k + 1)) : file.filename());
  }
  return paths;
}

/// Nothing is written unless all can be.
std::string in_the_way(const JointRequest& request, const std::vector<fs::path>& paths) {
  std::error_code ignored;
  for (auto path = paths.begin(); path != paths.end(); ++path) {
    const std::string camera = fmt::format("camera {}", path - paths.begin() + 1);
    if (request.save && path->empty() && path - paths.begin() + 1 != static_cast<std::ptrdiff_t>(request.reference))
      return camera + " has no calibration file to write to; allowed: --out FOLDER";
    if (path->empty()) continue;
    if (request.save) continue;
    if (std::find(paths.begin(), path, *path) != path)
      return fmt::format("{}: the calibrations of two cameras have this name; allowed: names that differ",
                         path->string());
    if (fs::exists(*path, ignored))
      return fmt::format("{}: already exists; allowed: another folder, or --save", path->string());
  }
  return {};
}

/// A folder that is there for as long as this is, and stays if it has got a file by then.
class Folder {
 public:
  /// Makes it, where it is not there; `error` says why not.
  Folder(const fs::path& path, std::error_code& error) {
    for (fs::path at = path; !at.empty() && !fs::exists(at, error) && !error; at = at.parent_path())
      made_.push_back(at);
    if (!error) fs::create_directories(path, error);
  }
  ~Folder() {
    std::error_code not_empty;
    for (const fs::path& folder : made_) fs::remove(folder, not_empty);
  }
  Folder(const Folder&) = delete;
  Folder& operator=(const Folder&) = delete;

 private:
  std::vector<fs::path> made_;  // the innermost first
};

}  // namespace

int calibrate_joint(const JointRequest& request) {
  const auto refuse = [](const std::string& why, int status) {
    complain(why);
    return status;
  };
  const auto experiment = load({request.experiment, {}, false});
  if (!experiment) return wrong_input;
  if (experiment->cameras() < 2)
    return refuse(fmt::format("{}: has one camera; needed: two or more ([[camera.also]])", request.experiment),
                  wrong_input);
  if (request.reference > experiment->cameras())
    return refuse(fmt::format("--reference {}; allowed: 1 to {}", request.reference, experiment->cameras()),
                  wrong_input);
  const std::vector<fs::path> paths = destinations(request, *experiment);
  if (const std::string why = in_the_way(request, paths); !why.empty()) return refuse(why, wrong_input);
  // Before the films are searched, which takes minutes.
  std::optional<Folder> folder;
  if (!request.out.empty()) {
    std::error_code error;
    folder.emplace(request.out, error);
    if (error) return refuse(fmt::format("{}: cannot be made: {}", request.out, error.message()), wrong_input);
  }
  for (const fs::path& path : paths)
    if (const auto possible = path.empty() ? tl::expected<void, std::string>() : check_calibration_target(path);
        !possible)
      return refuse(possible.error(), wrong_input);
  const bool show_progress = !request.quiet && isatty(STDERR_FILENO) != 0;
  const auto found =
      joint_films(*experiment, request.film, request.reference - 1, [&](std::size_t camera, std::int64_t frames) {
        if (show_progress && frames % 10 == 0)
          print_error_as_is(
              fmt::format("\r\033[Kcamera {} of {}: {} frames searched", camera + 1, experiment->cameras(), frames));
        return !interrupted();
      });
  if (show_progress) print_error_as_is("\r\033[K");
  if (!found) return refuse(found.error() + "; nothing was written", device_failed);
  for (const std::string& skipped : found->skipped) complain(fmt::format("skipped {}", skipped));
  if (!request.quiet) print(*found, request.reference - 1);
  for (std::size_t k = 0; k < paths.size(); ++k) {
    if (paths[k].empty()) continue;
    const auto old = replace_calibration(found->joint.cameras[k].calibration, paths[k]);
    if (!old) return refuse(old.error(), wrong_input);
    if (!old->empty())
      complain(fmt::format("{} was overwritten; its previous contents are in {}", paths[k].string(), old->string()));
    if (!request.quiet) print_out(fmt::format("calibration: {}\n", paths[k].string()));
  }
  return done;
}

}  // namespace skein::app
