#include "app/doctor/checks.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <system_error>

#include "app/runs/kept_run.h"
#include "app/runs/run_index.h"

namespace skein::app::detail {
namespace {

namespace fs = std::filesystem;
using State = Finding::State;

constexpr double megabyte = 1e6;

/// What helps against an error of writing; `otherwise` where the disk is not full.
std::string remedy_for(const std::string& error, const char* otherwise) {
  if (error.ends_with(std::strerror(ENOSPC))) return "make room: either bytes or files are used up (df -h, df -i)";
  if (error.ends_with(std::strerror(EDQUOT))) return "remove files, or have your quota raised (quota -s)";
  return otherwise;
}

Findings disk(const Machine& machine) {
  Findings result;
  const double free = machine.disk_free();
  if (const std::string found = fmt::format("{:.1f} GB free here", free / 1e9); free >= 1e9)
    result.push_back(well("disk space", found));
  else
    result.push_back({State::ill, "disk space", found + ": a film takes 1 GB a minute, a CSV 3 MB", "make room"});
  const auto speed = machine.disk_speed();
  if (!speed)
    result.push_back(
        {State::ill, "disk", speed.error(), remedy_for(speed.error(), "start in a folder that you may write to")});
  else if (const std::string found = fmt::format("writes {:.0f} MB/s here", *speed / megabyte); *speed >= 20 * megabyte)
    result.push_back(well("disk", found));
  else
    result.push_back({*speed < 2 * megabyte ? State::ill : State::note, "disk", found + ": too slow for films",
                      "record on another disk; a CSV needs 0.1 MB/s"});
  return result;
}

/// Whether a run could be kept.
Finding kept_runs(const Machine& machine) {
  const char* const subject = "kept runs";
  const char* const elsewhere = "make it a folder that you may write to, or name another: SKEIN_RUNS, --runs-dir";
  const auto directory = machine.runs_directory();
  if (!directory) return {State::ill, subject, directory.error(), "name a folder: SKEIN_RUNS, --runs-dir"};
  // It need not exist: it is made with the first run.
  std::error_code error;
  fs::path place = fs::absolute(*directory, error);
  while (!fs::exists(place, error) && place.has_relative_path()) {
    if (error == std::errc::permission_denied)
      return {State::ill, subject, fmt::format("{}: {} cannot be looked into", *directory, place.string()), elsewhere};
    if (std::error_code ignored; fs::is_symlink(place, ignored))  // no folder can be made in its place
      return {State::ill, subject,
              fmt::format("{}: {} is a link to {}, which is not there", *directory, place.string(),
                          fs::read_symlink(place, ignored).string()),
              "mount or make what it leads to, or name another folder: SKEIN_RUNS, --runs-dir"};
    place = place.parent_path();
  }
  if (!fs::is_directory(place, error))
    return {State::ill, subject, fmt::format("{}: {} is no folder", *directory, place.string()), elsewhere};
  std::string probe = (place / ".skein-doctor-XXXXXX").string();
  const int file = ::mkostemp(probe.data(), O_CLOEXEC);
  if (file < 0) {
    const std::string why = std::strerror(errno);
    return {State::ill, subject, fmt::format("{}: nothing can be written in {}: {}", *directory, place.string(), why),
            remedy_for(why, elsewhere)};
  }
  ::close(file);
  ::unlink(probe.c_str());
  const double free = machine.free_in(place.string());
  if (free < 1e9)
    return {State::ill, subject,
            fmt::format("{}: {:.1f} GB free; a film takes 1 GB a minute, a CSV 3 MB", *directory, free / 1e9),
            "make room: skein runs remove"};
  if (const auto damage = damage_of_index(*directory))
    return {State::note, subject, *damage, "skein runs list makes it anew from the folders"};
  return well(subject, fmt::format("{}: {:.1f} GB free", *directory, free / 1e9));
}

}  // namespace

Findings check_storage(const Machine& machine) {
  Findings result = disk(machine);
  if (const auto wrong = wrong_clock())
    result.push_back({State::ill, "clock", *wrong, "set it (timedatectl): kept runs are named and found by it"});
  result.push_back(kept_runs(machine));
  return result;
}

}  // namespace skein::app::detail
