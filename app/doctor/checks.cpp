#include "app/doctor/checks.h"

#include <fmt/format.h>

#include <algorithm>
#include <fstream>
#include <iterator>
#include <sstream>
#include <utility>

namespace skein::app::detail {

namespace fs = std::filesystem;
using State = Finding::State;

void append(Findings& all, Findings more) {
  std::move(more.begin(), more.end(), std::back_inserter(all));
}

std::string read(const fs::path& path) {
  std::ifstream file(path, std::ios::binary);
  std::string text{std::istreambuf_iterator<char>(file), {}};
  while (!text.empty() && (text.back() == '\n' || text.back() == ' ')) text.pop_back();
  return text;
}

fs::path below(const Machine& machine, const std::string& path) {
  return machine.root + path;
}

std::vector<fs::path> entries(const fs::path& folder, const std::string& beginning) {
  std::vector<fs::path> result;
  std::error_code error;
  for (fs::directory_iterator it(folder, error), end; !error && it != end; it.increment(error))
    if (it->path().filename().string().starts_with(beginning)) result.push_back(it->path());
  std::sort(result.begin(), result.end());
  return result;
}

Finding no_permission(const Machine& machine, const std::string& path, const char* group) {
  return {Finding::State::ill, path, "you have no permission to open it",
          machine.superuser || is_in(machine, group)
              ? fmt::format("as root: chgrp {0} {1} && chmod g+rw {1}", group, path)
              : fmt::format("see the group {} above", group)};
}

Finding well(std::string what, std::string found) {
  return {State::well, std::move(what), std::move(found), {}};
}

bool is_there(const Machine& machine, const std::string& path) {
  std::error_code error;
  return fs::exists(below(machine, path), error);
}

Finding not_known(std::string what, const char* path, State state) {
  return {state, std::move(what), fmt::format("not known: {} is not there", path),
          "mount /proc and /sys; in a container, examine the machine outside it"};
}

double kernel_setting(const Machine& machine, const char* file, double otherwise) {
  std::istringstream text(read(below(machine, file)));
  double value = 0.0;
  return text >> value ? value : otherwise;
}

bool is_in(const Machine& machine, const std::string& group) {
  return std::find(machine.groups.begin(), machine.groups.end(), group) != machine.groups.end();
}

bool is_in_after_login(const Machine& machine, const std::string& group) {
  if (is_in(machine, group)) return false;
  std::ifstream file(below(machine, "/etc/group"));
  for (std::string line; std::getline(file, line);) {
    if (!line.starts_with(group + ":")) continue;
    std::istringstream members(line.substr(line.rfind(':') + 1));
    for (std::string member; std::getline(members, member, ',');)
      if (member == machine.user) return true;
  }
  return false;
}

}  // namespace skein::app::detail
