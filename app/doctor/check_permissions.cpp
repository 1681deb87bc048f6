#include "app/doctor/checks.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <filesystem>
#include <fstream>
#include <sstream>
#include <string>
#include <utility>
#include <vector>

namespace skein::app::detail {
namespace {

using State = Finding::State;

constexpr int needed_priority = 22;  // the guard's, the highest that is requested

/// What only members of a group may open, unless the system opens it to whoever sits at the machine (udev's uaccess).
struct Guarded {
  const char* group;
  const char* what;
  std::vector<const char*> devices;  // below /dev: how their names begin
};

/// Those that are there.
std::vector<std::string> devices(const Machine& machine, const Guarded& guarded) {
  std::vector<std::string> paths;
  for (const char* const beginning : guarded.devices)
    for (const std::filesystem::path& device : entries(below(machine, "/dev"), beginning))
      paths.push_back("/dev/" + device.filename().string());
  return paths;
}

Finding group(const Machine& machine, const Guarded& guarded) {
  const char* const name = guarded.group;
  const std::string subject = fmt::format("group {}", name);
  if (machine.superuser || is_in(machine, name))
    return well(subject, machine.superuser ? "root needs none" : "you are in it");
  std::vector<std::string> closed = devices(machine, guarded);
  const bool any = !closed.empty();
  std::erase_if(closed, machine.usable);
  if (any && closed.empty())
    return well(subject, fmt::format("{} is not in it and need not be: {} that are there can be opened", machine.user,
                                     guarded.what));
  const std::string what =
      closed.empty() ? guarded.what : fmt::format("{} ({})", guarded.what, fmt::join(closed, ", "));
  if (is_in_after_login(machine, name))
    return {State::ill, subject,
            fmt::format("{} is in it from the next login on: until then {} cannot be opened", machine.user, what),
            "log in again"};
  return {State::ill,
          subject,
          fmt::format("{} is not in it: {} cannot be opened", machine.user, what),
          fmt::format("as root: adduser {} {}; then log in again", machine.user, name),
          {{"adduser", machine.user, name}}};
}

constexpr const char* rights_of_the_package = "/etc/security/limits.d/60-skein.conf";
// A file of its own: dpkg asks before it replaces one of the package's that somebody else has written, and where nobody
// answers, the package is not installed.
constexpr const char* rights_of_a_fix = "/etc/security/limits.d/60-skein-doctor.conf";

/// The file that grants the group a limit of this name; empty: none does. A session that began before, or that does not
/// read such files, is without it.
std::string granted_to_the_group_by(const Machine& machine, const std::string& item) {
  for (const char* const rights : {rights_of_the_package, rights_of_a_fix}) {
    std::ifstream file(below(machine, rights));
    for (std::string line; std::getline(file, line);) {
      std::istringstream words(line);
      std::string who, kind, limit;
      if (words >> who >> kind >> limit && who == "@skein" && limit == item) return rights;
    }
  }
  return {};
}

/// What the package skein-permissions allows the group skein is not granted.
Finding not_granted(State state, const char* subject, const char* item, std::string found, const Machine& machine) {
  if (machine.superuser)  // a group grants root nothing: it lacks a capability
    return {state, subject, std::move(found),
            "a container withholds it: start it as root, with --cap-add=SYS_NICE --cap-add=IPC_LOCK"};
  if (const std::string by = granted_to_the_group_by(machine, item);
      !by.empty() && (is_in(machine, "skein") || is_in_after_login(machine, "skein")))
    return {state, subject, std::move(found), fmt::format("{}, if its pam_limits reads {}", in_the_next_session, by)};
  return {
      state,
      subject,
      std::move(found),
      fmt::format("install skein-permissions, then as root: adduser {} skein; then log in again", machine.user),
      {{"addgroup", "--quiet", "--system", "skein"},
       {"sh", "-c", fmt::format("printf '@skein - rtprio 25\\n@skein - memlock unlimited\\n' > {}", rights_of_a_fix)},
       {"adduser", machine.user, "skein"}}};
}

Finding priority(const Machine& machine) {
  const char* const subject = "real-time priority";
  if (machine.rtprio < 0) return well(subject, "granted without limit");
  if (machine.rtprio >= needed_priority) return well(subject, fmt::format("granted up to {}", machine.rtprio));
  return not_granted(State::ill, subject, "rtprio",
                     fmt::format("not granted (limit {}, requested {}): on a busy machine ticks and stops are late",
                                 machine.rtprio, needed_priority),
                     machine);
}

Finding memory_lock(const Machine& machine) {
  const char* const subject = "memory lock";
  if (machine.memlock < 0) return well(subject, "granted without limit");
  return not_granted(
      State::note, subject, "memlock",
      fmt::format("not granted (limit {} kB): on a machine that swaps, ticks and stops may wait for the disk",
                  machine.memlock / 1024),
      machine);
}

}  // namespace

Findings check_permissions(const Machine& machine) {
  return {group(machine, {"dialout", "robots on serial lines", {"rfcomm", "ttyACM", "ttyUSB"}}),
          group(machine, {"video", "cameras", {"video"}}), priority(machine), memory_lock(machine)};
}

}  // namespace skein::app::detail
