#include "app/runs/run_removal.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/file.h>
#include <unistd.h>

#include <cerrno>
#include <filesystem>
#include <vector>

#include "app/runs/run_folder.h"

namespace skein::app {
namespace {

namespace fs = std::filesystem;

/// Records are locked while they are written (DiskWriter).
bool is_being_written(const fs::path& file) {
  const int descriptor = ::open(file.c_str(), O_RDONLY | O_NONBLOCK | O_CLOEXEC);
  if (descriptor < 0) return false;
  const bool locked = ::flock(descriptor, LOCK_SH | LOCK_NB) != 0 && errno == EWOULDBLOCK;
  ::close(descriptor);
  return locked;
}

}  // namespace

tl::expected<void, std::string> remove_run(const std::string& folder) {
  const fs::path run(folder), story = run / run_files::story;
  std::error_code error;
  if (fs::is_symlink(run, error)) {  // the run that it leads to may be elsewhere, and be listed there
    fs::remove(run, error);
    if (error) return tl::unexpected(fmt::format("{}: cannot be removed: {}", folder, error.message()));
    return {};
  }
  if (!fs::is_regular_file(story, error))
    return tl::unexpected(folder + ": is not removed: it has no run.json, allowed: the folder of a kept run");
  for (const std::string& name : files_of_run(folder))
    if (is_being_written(run / name))
      return tl::unexpected(fmt::format("{}: is not removed: a program is writing {}", folder, name));
  std::vector<fs::path> others;
  for (const fs::directory_entry& entry : fs::directory_iterator(run, error))
    if (entry.path() != story) others.push_back(entry.path());
  for (const fs::path& other : others) {
    if (!error) fs::remove_all(other, error);
    if (error) return tl::unexpected(fmt::format("{}: cannot be removed: {}", other.string(), error.message()));
  }
  if (!error) fs::remove_all(run, error);
  if (error) return tl::unexpected(fmt::format("{}: cannot be removed: {}", folder, error.message()));
  return {};
}

}  // namespace skein::app
