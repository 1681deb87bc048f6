#include "app/doctor/doctor.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <fcntl.h>
#include <unistd.h>
#include <algorithm>
#include <cctype>
#include <cerrno>
#include <cmath>
#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <map>
#include <set>
#include <sstream>

#include "app/calibration/calibration_file.h"
#include "app/run/terminal_text.h"
#include "app/runs/run_index.h"
#include "comms/link_address.h"
#include "vision/calibration/calibration.h"
#include "vision/frames/receive_buffer.h"
#include "vision/sources/open_source.h"

namespace skein::app {
namespace {

namespace fs = std::filesystem;
using State = Finding::State;
using Findings = std::vector<Finding>;

constexpr int needed_priority = 22;            // the guard's, the highest that is requested
constexpr std::size_t robots_per_adapter = 7;  // of Bluetooth
constexpr double megabyte = 1e6;
constexpr const char* device_classes = "/sys/class";

/// A small file of the kernel, without its line end; empty: there is none.
std::string read(const fs::path& path) {
  std::ifstream file(path, std::ios::binary);
  std::string text{std::istreambuf_iterator<char>(file), {}};
  while (!text.empty() && (text.back() == '\n' || text.back() == ' ')) text.pop_back();
  return text;
}

fs::path below(const Machine& machine, const std::string& path) {
  return machine.root + path;
}

/// The entries of a folder whose names begin with `beginning`, sorted.
std::vector<fs::path> entries(const fs::path& folder, const std::string& beginning) {
  std::vector<fs::path> result;
  std::error_code error;
  for (fs::directory_iterator it(folder, error), end; !error && it != end; it.increment(error))
    if (it->path().filename().string().starts_with(beginning)) result.push_back(it->path());
  std::sort(result.begin(), result.end());
  return result;
}

Finding well(std::string what, std::string found) {
  return {State::well, std::move(what), std::move(found), {}};
}

bool is_there(const Machine& machine, const std::string& path) {
  std::error_code error;
  return fs::exists(below(machine, path), error);
}

/// The kernel's files are not there, as in some containers: whether all is well cannot be seen.
Finding not_known(std::string what, const char* path, State state = State::note) {
  return {state, std::move(what), fmt::format("not known: {} is not there", path),
          "mount /proc and /sys; in a container, examine the machine outside it"};
}

// --- what a user may do ---

bool is_in(const Machine& machine, const std::string& group) {
  return std::find(machine.groups.begin(), machine.groups.end(), group) != machine.groups.end();
}

/// Whether the user is to be in a group from the next login on: the machine's file has it, this process does not.
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

Finding group(const Machine& machine, const char* name, const char* what) {
  const std::string subject = fmt::format("group {}", name);
  if (machine.superuser || is_in(machine, name))
    return well(subject, machine.superuser ? "root needs none" : "you are in it");
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

constexpr const char* rights_of_the_group = "/etc/security/limits.d/60-skein.conf";
constexpr const char* rules_of_the_package = "/usr/lib/udev/rules.d/60-skein.rules";
constexpr const char* in_the_next_session = "log in again: a session that begins now has it";

/// Whether that file grants the group a limit of this name. A session that began before, or that does not read such
/// files, is without it.
bool is_granted_to_the_group(const Machine& machine, const std::string& item) {
  std::ifstream file(below(machine, rights_of_the_group));
  for (std::string line; std::getline(file, line);) {
    std::istringstream words(line);
    std::string who, kind, limit;
    if (words >> who >> kind >> limit && who == "@skein" && limit == item) return true;
  }
  return false;
}

/// What the package skein-permissions allows the group skein is not granted.
Finding not_granted(State state, const char* subject, const char* item, std::string found, const Machine& machine) {
  if (machine.superuser)  // a group grants root nothing: it lacks a capability
    return {state, subject, std::move(found),
            "a container withholds it: start it as root, with --cap-add=SYS_NICE --cap-add=IPC_LOCK"};
  if (is_granted_to_the_group(machine, item) && (is_in(machine, "skein") || is_in_after_login(machine, "skein")))
    return {state, subject, std::move(found),
            fmt::format("{}, if its pam_limits reads {}", in_the_next_session, rights_of_the_group)};
  return {state,
          subject,
          std::move(found),
          fmt::format("install skein-permissions, then as root: adduser {} skein; then log in again", machine.user),
          {{"addgroup", "--quiet", "--system", "skein"},
           {"sh", "-c",
            fmt::format("printf '@skein - rtprio 25\\n@skein - memlock unlimited\\n' > {}", rights_of_the_group)},
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

/// A number that the kernel has in a file below /proc/sys.
double kernel_setting(const Machine& machine, const char* file, double otherwise) {
  std::istringstream text(read(below(machine, file)));
  double value = 0.0;
  return text >> value ? value : otherwise;
}

Finding throttling(const Machine& machine) {
  const char* const subject = "real-time share";
  if (const char* const settings = "/proc/sys/kernel"; !is_there(machine, settings))
    return not_known(subject, settings);
  // Below zero: no limit.
  const double runtime = kernel_setting(machine, "/proc/sys/kernel/sched_rt_runtime_us", -1.0);
  const double period = kernel_setting(machine, "/proc/sys/kernel/sched_rt_period_us", 1e6);
  constexpr double least = 0.5;
  if (runtime < 0.0 || runtime >= least * period) return well(subject, "threads with real-time priority may run");
  return {State::ill,
          subject,
          runtime == 0.0
              ? std::string("kernel.sched_rt_runtime_us is 0: no thread with real-time priority may run")
              : fmt::format("kernel.sched_rt_runtime_us is {:g} of {:g}: threads with real-time priority stand "
                            "for the rest of the time",
                            runtime, period),
          "as root: sysctl kernel.sched_rt_runtime_us=950000",
          {{"sysctl", "kernel.sched_rt_runtime_us=950000"}}};
}

// --- how well it computes ---

Finding governor(const Machine& machine) {
  const char* const subject = "CPU frequency";
  const char* const processors = "/sys/devices/system/cpu";
  if (!is_there(machine, processors)) return not_known(subject, processors);
  std::set<std::string> slow;
  for (const fs::path& policy : entries(below(machine, "/sys/devices/system/cpu/cpufreq"), "policy")) {
    const std::string governor = read(policy / "scaling_governor"), driver = read(policy / "scaling_driver");
    // The drivers of newer processors choose the frequency themselves: their "powersave" is what others call automatic.
    const bool automatic = governor == "powersave" && (driver == "intel_pstate" || driver == "amd-pstate-epp");
    if (!governor.empty() && governor != "performance" && !automatic) slow.insert(governor);
  }
  if (slow.empty()) return well(subject, "no governor slows the processor down");
  return {
      slow.contains("powersave") ? State::ill : State::note,
      subject,
      fmt::format("governor {}: the processor wakes slowly", fmt::join(slow, ", ")),
      "as root: for g in /sys/devices/system/cpu/cpufreq/policy*/scaling_governor; do echo performance > $g; done",
      {{"sh", "-c",
        "for g in /sys/devices/system/cpu/cpufreq/policy*/scaling_governor; do echo performance > $g || exit; done"}}};
}

Finding idle_states(const Machine& machine) {
  const char* const subject = "idle states";
  const char* const device = "/dev/cpu_dma_latency";
  const char* const rules = "/etc/udev/rules.d/60-skein-latency.rules";
  if (machine.usable(device)) return well(subject, "a run may keep the processors from deep ones");
  std::string found = fmt::format("{} cannot be written: an idle processor may wake 0.05 to 0.5 ms late", device);
  if ((is_there(machine, rules) || is_there(machine, rules_of_the_package)) && is_in_after_login(machine, "skein"))
    return {State::note, subject, std::move(found), in_the_next_session};
  return {State::note,
          subject,
          std::move(found),
          fmt::format("install skein-permissions, then as root: adduser {} skein; then log in again", machine.user),
          {{"addgroup", "--quiet", "--system", "skein"},
           {"sh", "-c", fmt::format("echo 'KERNEL==\"cpu_dma_latency\", GROUP=\"skein\", MODE=\"0660\"' > {}", rules)},
           {"udevadm", "control", "--reload"},
           {"udevadm", "trigger", "--sysname-match=cpu_dma_latency"},
           {"adduser", machine.user, "skein"}}};
}

Finding load(const Machine& machine) {
  const char* const subject = "load";
  const char* const file = "/proc/loadavg";
  std::istringstream text(read(below(machine, file)));
  double last_minute = 0.0;
  if (!(text >> last_minute)) return not_known(subject, file);
  const auto folders = entries(below(machine, "/sys/devices/system/cpu"), "cpu");
  const auto cores = std::max<std::ptrdiff_t>(
      1, std::count_if(folders.begin(), folders.end(), [](const fs::path& folder) {
        return std::isdigit(static_cast<unsigned char>(folder.filename().string().back())) != 0 &&
               read(folder / "online") != "0";  // the first has no such file
      }));
  const std::string found =
      fmt::format("{:.1f} threads at work on {} core{}", last_minute, cores, cores == 1 ? "" : "s");
  if (last_minute <= 0.75 * static_cast<double>(cores)) return well(subject, found);
  return {State::ill, subject, found, "close other programs; top says which"};
}

Finding memory(const Machine& machine) {
  const char* const subject = "memory";
  const char* const file = "/proc/meminfo";
  std::istringstream text(read(below(machine, file)));
  double available = -1.0;  // [kB]
  for (std::string line; std::getline(text, line);)
    if (line.starts_with("MemAvailable:")) available = std::stod(line.substr(13));
  if (available < 0.0) return not_known(subject, file);
  const std::string found = fmt::format("{:.0f} MB available", available / 1024.0);
  if (available >= 300.0 * 1024.0) return well(subject, found);
  return {State::ill, subject, found + ": swapped-out memory is slow to return", "close other programs"};
}

Finding clock_source(const Machine& machine) {
  const char* const subject = "clock";
  const char* const file = "/sys/devices/system/clocksource/clocksource0/current_clocksource";
  const std::string source = read(below(machine, file));
  if (source.empty()) return not_known(subject, file);
  const bool slow = source == "hpet" || source == "acpi_pm" || source == "jiffies" || source.starts_with("refined");
  if (!slow) return well(subject, source);
  return {State::note, subject, fmt::format("{}: reading the time is slow", source),
          "boot with tsc=reliable if the processor's counter can be relied on"};
}

std::string milliseconds(double seconds) {
  return fmt::format("{:.2f}", 1e3 * seconds);
}

Finding timing(const Machine& machine, double seconds) {
  const char* const subject = "keeping time";
  const Timing timing = machine.keep_time(seconds);
  constexpr double most = 2e-3;  // a twentieth of a period of 40 ms [s]
  const auto words = [](const Histogram& late) {
    return fmt::format("{} / {} / {} / {} ms", milliseconds(late.quantile(0.5)), milliseconds(late.quantile(0.99)),
                       milliseconds(late.quantile(0.999)), milliseconds(late.largest()));
  };
  std::string found =
      fmt::format("latency of bare threads (p50 / p99 / p99.9 / largest): ordinary {}", words(timing.bare));
  if (timing.priority > 0) found += fmt::format(", at real-time priority {}", words(timing.tick));
  const Histogram& best = timing.priority > 0 ? timing.tick : timing.bare;
  if (best.quantile(0.99) <= most && best.largest() <= 10.0 * most) return well(subject, found);
  return {State::ill, subject, found,
          "a tick has 40 ms: fix the problems above; a virtual machine or power-saving firmware may be the cause"};
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
    result.push_back({State::ill, "disk", speed.error(), "start in a folder that you may write to"});
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
  while (!fs::exists(place, error) && place.has_relative_path()) place = place.parent_path();
  if (!fs::is_directory(place, error))
    return {State::ill, subject, fmt::format("{}: {} is no folder", *directory, place.string()), elsewhere};
  std::string probe = (place / ".skein-doctor-XXXXXX").string();
  const int file = ::mkostemp(probe.data(), O_CLOEXEC);
  if (file < 0)
    return {State::ill, subject,
            fmt::format("{}: nothing can be written in {}: {}", *directory, place.string(), std::strerror(errno)),
            elsewhere};
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

// --- robots ---

Findings bluetooth(const Machine& machine, const Examination& examination) {
  Findings result;
  std::map<std::string, std::size_t> wanted;  // robots by adapter
  std::size_t robots = 0;
  for (const auto& [file, experiment] : examination.experiments) {
    std::map<std::string, std::size_t> here;
    std::size_t all = 0;
    for (const RobotSpec& robot : experiment.robots)
      if (const auto link = comms::parse_link_address(robot.address);
          robot.is_real() && link && link->kind == comms::LinkKind::rfcomm)
        ++here[robot.adapter], ++all;
    for (const auto& [adapter, count] : here) wanted[adapter] = std::max(wanted[adapter], count);
    robots = std::max(robots, all);
  }
  const State missing = robots > 0 ? State::ill : State::note;
  if (!is_there(machine, device_classes)) return {not_known("Bluetooth", device_classes, missing)};

  for (const fs::path& kill : entries(below(machine, "/sys/class/rfkill"), "rfkill"))
    if (read(kill / "type") == "bluetooth") {
      const std::string name = read(kill / "name");
      if (read(kill / "hard") == "1")  // no program releases it
        result.push_back({missing, "Bluetooth switch", fmt::format("{} is blocked by a switch of the machine", name),
                          "turn the machine's own switch"});
      if (read(kill / "soft") == "1")
        result.push_back({missing,
                          "Bluetooth switch",
                          fmt::format("{} is blocked by software", name),
                          "as root: rfkill unblock bluetooth",
                          {{"rfkill", "unblock", "bluetooth"}}});
    }
  if (entries(below(machine, "/sys/class/bluetooth"), "hci").empty()) {
    result.push_back(
        {missing, "Bluetooth", "no adapter: robots by WiFi and cable only", "plug one in; each takes 7 robots"});
    return result;
  }
  const auto adapters = machine.adapters();
  if (!adapters) {
    result.push_back({missing,
                      "Bluetooth daemon",
                      adapters.error(),
                      "as root: systemctl enable --now bluetooth",
                      {{"systemctl", "enable", "--now", "bluetooth"}}});
    return result;
  }
  std::size_t on = 0;
  for (const BluetoothAdapter& adapter : *adapters) {
    if (adapter.powered) {
      ++on;
      continue;
    }
    // bluetoothctl would switch on the default adapter, whichever that is.
    const std::vector<std::string> power_on{
        "busctl", "set-property", "org.bluez", "/org/bluez/" + adapter.name, "org.bluez.Adapter1", "Powered",
        "b",      "true"};
    result.push_back({missing,
                      fmt::format("Bluetooth {}", adapter.name),
                      "is switched off",
                      "as root: " + fmt::format("{}", fmt::join(power_on, " ")),
                      {power_on}});
  }
  const std::size_t room = on * robots_per_adapter;
  const std::string found = fmt::format("{} adapter{} on: {} robots at most{}", on, on == 1 ? "" : "s", room,
                                        robots > 0 ? fmt::format(", {} wanted", robots) : "");
  if (robots > room)
    result.push_back({State::ill, "Bluetooth", found, "plug in another adapter and name it with each robot"});
  else if (on > 0)
    result.push_back(well("Bluetooth", found));
  for (const auto& [adapter, count] : wanted) {
    const bool known = adapter.empty() || std::any_of(adapters->begin(), adapters->end(), [&](const auto& a) {
                         return a.name == adapter || a.address == adapter;
                       });
    if (!known)
      result.push_back({State::ill, fmt::format("Bluetooth {}", adapter), "an experiment names it, but it is not there",
                        "plug it in, or name another"});
    else if (count > robots_per_adapter && robots <= room)
      result.push_back({State::ill, fmt::format("Bluetooth {}", adapter.empty() ? "adapter" : adapter),
                        fmt::format("{} robots on it, 7 fit", count), "spread them: adapter = \"hci1\""});
  }
  return result;
}

Findings serial(const Machine& machine, const Examination& examination) {
  Findings result;
  for (const fs::path& process : entries(below(machine, "/proc"), ""))
    if (read(process / "comm") == "ModemManager" && !is_there(machine, rules_of_the_package)) {
      result.push_back({State::note, "ModemManager", "writes to new serial lines, robots on USB among them",
                        "install skein-permissions, which keeps it away from e-pucks"});
      break;
    }
  for (const auto& [file, experiment] : examination.experiments)
    for (const RobotSpec& robot : experiment.robots) {
      if (!robot.is_real()) continue;
      const auto address = comms::parse_link_address(robot.address);
      if (!address || address->kind != comms::LinkKind::serial) continue;
      std::error_code error;
      if (!fs::exists(below(machine, address->device), error))
        result.push_back({State::ill, address->device, fmt::format("is not there; {} has a robot on it", file),
                          "plug it in, or correct its link in the file"});
      else if (!machine.usable(address->device))
        result.push_back(
            {State::ill, address->device, "you have no permission to open it", "see the group dialout above"});
    }
  return result;
}

// --- what robots are seen with ---

/// Every camera of every experiment, with its file.
std::vector<std::pair<std::string, CameraSpec>> all_cameras(const Examination& examination) {
  std::vector<std::pair<std::string, CameraSpec>> all;
  for (const auto& [file, experiment] : examination.experiments)
    for (std::size_t k = 0; k < experiment.cameras(); ++k) all.emplace_back(file, experiment.camera_at(k));
  return all;
}

/// What the kernel holds of a GigE camera's frame while its receiver waits for a processor.
void check_receive_buffer(const Machine& machine, Findings& result) {
  constexpr double large_frame = 4 << 20;  // [bytes]
  const double limit = kernel_setting(machine, vision::receive_buffer_setting, 0.0);
  if (limit >= large_frame) return;
  const std::string setting = fmt::format("net.core.rmem_max={}", vision::good_receive_buffer_limit);
  result.push_back(
      {State::note,
       "receive buffer",
       fmt::format("{:.0f} bytes; a frame of a GigE camera may be larger, and is not whole when this machine "
                   "is busy",
                   limit),
       fmt::format("install skein-permissions, or as root: sysctl {}", setting),
       {{"sysctl", setting}}});
}

Findings cameras(const Machine& machine, const Examination& examination) {
  Findings result;
  const auto devices = entries(below(machine, "/sys/class/video4linux"), "video");
  std::vector<std::string> names;
  for (const fs::path& device : devices) {
    const std::string path = "/dev/" + device.filename().string();
    names.push_back(fmt::format("{} ({})", path, read(device / "name")));
    if (!machine.usable(path))
      result.push_back({State::ill, path, "you have no permission to open it", "see the group video above"});
  }
  bool wanted = false;
  bool receivers = false;
  std::map<const vision::SourceKind*, std::vector<std::string>> answered;  // asked once: an answer takes a second
  for (const auto& [file, camera] : all_cameras(examination)) {
    const auto address = vision::parse_source(camera.source);
    if (!address) continue;  // "none", "synthetic"
    const std::string& name = address->where;
    switch (address->kind->connection) {
      case vision::Connection::file:
        break;
      case vision::Connection::network: {
        const auto [of_kind, first] = answered.try_emplace(address->kind);
        std::vector<std::string>& there = of_kind->second;
        if (first) there = machine.network_cameras(*address->kind);
        if (std::find(there.begin(), there.end(), name) != there.end()) {
          names.push_back(name);
          receivers = true;
        } else {
          result.push_back({State::ill, name, fmt::format("does not answer; {} sees its robots with it", file),
                            "plug it in, or name another: skein camera list"});
        }
        break;
      }
      case vision::Connection::device: {
        wanted = true;
        std::error_code error;
        if (!devices.empty() && !fs::exists(below(machine, name), error))
          result.push_back({State::ill, name, fmt::format("is not there; {} uses it", file),
                            "plug it in, or name another: skein camera list"});
        break;
      }
    }
  }
  if (devices.empty() && !is_there(machine, device_classes))
    result.push_back(not_known("camera", device_classes, wanted ? State::ill : State::note));
  else if (devices.empty() && (wanted || (names.empty() && result.empty())))
    result.push_back({wanted ? State::ill : State::note, "camera", "none", "plug one in; skein camera list shows it"});
  else if (result.empty())
    result.push_back(well("camera", fmt::format("{}; examined by: skein camera doctor", fmt::join(names, ", "))));
  if (receivers) check_receive_buffer(machine, result);
  return result;
}

/// The calibrations of the experiments, and whether they agree about the tags that robots carry.
Findings calibrations(const Examination& examination) {
  Findings result;
  std::map<std::string, double> sizes;  // [m]
  for (const auto& [file, camera] : all_cameras(examination)) {
    if (camera.calibration.empty()) {
      if (camera.kind() == CameraKind::live)
        result.push_back({State::ill, "calibration", fmt::format("{} names none", file),
                          "skein calibrate, see docs/calibration.md"});
      continue;
    }
    const fs::path path = fs::path(file).parent_path() / camera.calibration;
    const auto calibration = load_calibration(path);
    if (!calibration) {
      result.push_back({State::ill, "calibration", calibration.error(), "skein calibrate, see docs/calibration.md"});
      continue;
    }
    if (!calibration->world_from_camera)
      result.push_back({State::ill, "calibration", fmt::format("{} has no pose of the camera", path.string()),
                        "skein calibrate floor"});
    sizes[path.string()] = calibration->tag_size;
  }
  if (sizes.empty()) return result;
  std::vector<std::string> words;
  double smallest = sizes.begin()->second, largest = smallest;
  for (const auto& [path, size] : sizes) {
    words.push_back(fmt::format("{:g} mm in {}", 1e3 * size, path));
    smallest = std::min(smallest, size), largest = std::max(largest, size);
  }
  constexpr double rounding = 1e-6;  // of a number that was computed [m]
  if (largest - smallest > rounding)
    result.push_back({State::ill, "tag size", fmt::format("{}", fmt::join(words, ", ")),
                      "measure the black edge of a robot's tag; skein calibrate floor --tag-size"});
  else
    result.push_back(
        well("tag size", fmt::format("{}: measure the black edge of a robot's tag", fmt::join(words, ", "))));
  return result;
}

/// The experiments' own controllers.
Findings controllers(const Machine& machine, const Examination& examination) {
  Findings result;
  for (const auto& [file, experiment] : examination.experiments) {
    if (!experiment.controller.law.own()) continue;
    if (const auto started = machine.start_controller(experiment); started)
      result.push_back(well("controller", fmt::format("that of {} can be started", file)));
    else
      result.push_back({State::ill, "controller", fmt::format("{}: {}", file, started.error()),
                        fmt::format("skein check --controller {} shows all that it prints", file)});
  }
  return result;
}

// --- the program's own parts ---

Findings parts(const Machine& machine) {
  Findings result;
  if (const auto guard = machine.guard(); guard)
    result.push_back(well("guard", "can be started"));
  else
    result.push_back({State::ill, "guard", guard.error(),
                      "mend this: without a guard nothing stops the robots when the program is killed"});
  for (const std::string& run : machine.bad_ends())
    result.push_back({State::ill, "an earlier run", fmt::format("{} ended badly, its robots may still drive", run),
                      "skein robots stop"});
  if (const auto modules = machine.modules(); modules)
    result.push_back(well("modules", "films, calibration boards, GigE and USB3 Vision"));
  else
    result.push_back({State::ill, "modules", modules.error(), "reinstall skein"});
  if (machine.has_program("gnuplot"))
    result.push_back(well("gnuplot", "draws the figures of reports"));
  else
    result.push_back({State::note,
                      "gnuplot",
                      "is missing: no figures with --report",
                      "as root: apt-get install gnuplot-nox",
                      {{"apt-get", "install", "-y", "gnuplot-nox"}}});
  return result;
}

Finding display(const Machine& machine) {
  const char* const subject = "display";
  if (!machine.window) return {State::note, subject, "this program was built without a window", "skein run works"};
  if (machine.display.empty())
    return {State::note, subject, "none: no window here", "skein run works without; or ssh -X"};
  std::error_code error;
  if (machine.display.starts_with(":")) {
    const std::string number = machine.display.substr(1, machine.display.find('.') - 1);
    if (!fs::exists(below(machine, "/tmp/.X11-unix/X" + number), error))
      return {State::ill, subject, fmt::format("DISPLAY is {}, but there is no display server", machine.display),
              "log in at the machine, or unset DISPLAY"};
  }
  // Names of X's displays have a colon. Wayland alone does not let a program place its dialogs.
  if (machine.display.find(':') == std::string::npos)
    return {State::note,
            subject,
            fmt::format("Wayland ({}) without XWayland: a dialog can open over the STOP button", machine.display),
            "as root: apt-get install xwayland, and log in again",
            {{"apt-get", "install", "-y", "xwayland"}}};
  return well(subject, machine.display);
}

}  // namespace

std::vector<Finding> examine(const Machine& machine, const Examination& examination) {
  Findings all;
  const auto add = [&](Findings more) { std::move(more.begin(), more.end(), std::back_inserter(all)); };
  all.push_back(group(machine, "dialout", "robots on serial lines"));
  all.push_back(group(machine, "video", "cameras"));
  all.push_back(priority(machine));
  all.push_back(memory_lock(machine));
  all.push_back(throttling(machine));
  all.push_back(governor(machine));
  all.push_back(idle_states(machine));
  all.push_back(clock_source(machine));
  all.push_back(load(machine));
  all.push_back(memory(machine));
  add(disk(machine));
  all.push_back(kept_runs(machine));
  add(bluetooth(machine, examination));
  add(serial(machine, examination));
  add(cameras(machine, examination));
  add(calibrations(examination));
  add(controllers(machine, examination));
  add(parts(machine));
  all.push_back(display(machine));
  if (examination.seconds > 0.0) all.push_back(timing(machine, examination.seconds));
  return all;
}

std::string as_line(const Finding& finding) {
  const char* word = "well";
  switch (finding.state) {
    case State::well:
      break;
    case State::note:
      word = "note";
      break;
    case State::ill:
      word = "ILL ";
      break;
  }
  return fmt::format("{}  {}: {}{}{}\n", word, shown(finding.what), shown(finding.found),
                     finding.remedy.empty() ? "" : " -> ", shown(finding.remedy));
}

}  // namespace skein::app
