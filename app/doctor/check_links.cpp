#include "app/doctor/checks.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <map>
#include <utility>

#include "comms/link_address.h"

namespace skein::app::detail {
namespace {

namespace fs = std::filesystem;
using State = Finding::State;

constexpr std::size_t robots_per_adapter = 7;  // of Bluetooth

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
        result.push_back(no_permission(machine, address->device, "dialout"));
    }
  return result;
}

}  // namespace

Findings check_links(const Machine& machine, const Examination& examination) {
  Findings result = bluetooth(machine, examination);
  append(result, serial(machine, examination));
  return result;
}

}  // namespace skein::app::detail
