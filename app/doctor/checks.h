#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "app/doctor/finding.h"
#include "app/doctor/machine.h"

// The parts of `examine`, and what they share. Below /proc, /sys and /etc they look in the machine's own root.
namespace skein::app::detail {

using Findings = std::vector<Finding>;
void append(Findings& all, Findings more);

// In the order in which problems should be fixed.
Findings check_permissions(const Machine& machine);
Findings check_computer(const Machine& machine);  // all but how well it keeps time
Findings check_storage(const Machine& machine);
Findings check_links(const Machine& machine, const Examination& examination);
Findings check_cameras(const Machine& machine, const Examination& examination);
Findings check_program(const Machine& machine, const Examination& examination);
/// Measures for so long [s].
Finding check_timing(const Machine& machine, double seconds);

constexpr const char* device_classes = "/sys/class";
constexpr const char* rules_of_the_package = "/usr/lib/udev/rules.d/60-skein.rules";
constexpr const char* in_the_next_session = "log in again: a session that begins now has it";

/// A small file of the kernel, without its line end; empty: there is none.
std::string read(const std::filesystem::path& path);
std::filesystem::path below(const Machine& machine, const std::string& path);
/// The entries of a folder whose names begin with `beginning`, sorted.
std::vector<std::filesystem::path> entries(const std::filesystem::path& folder, const std::string& beginning);
bool is_there(const Machine& machine, const std::string& path);
/// A number that the kernel has in a file below /proc/sys.
double kernel_setting(const Machine& machine, const char* file, double otherwise);

bool is_in(const Machine& machine, const std::string& group);
/// Whether the user is to be in a group from the next login on: the machine's file has it, this process does not.
bool is_in_after_login(const Machine& machine, const std::string& group);

Finding well(std::string what, std::string found);
/// A device that this process may not open, though it should be `group`'s.
Finding no_permission(const Machine& machine, const std::string& path, const char* group);
/// The kernel's files are not there, as in some containers: whether all is well cannot be seen.
Finding not_known(std::string what, const char* path, Finding::State state = Finding::State::note);

}  // namespace skein::app::detail
