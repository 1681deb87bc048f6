#include "comms/bluez.h"

#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <map>
#include <tuple>
#include <utility>

#include "comms/bluez_bus.h"

namespace skein::comms {
namespace {

constexpr std::string_view epuck1 = "e-puck_", epuck2 = "e-puck2_";

bool number_after(std::string_view begin, std::string_view name) noexcept {
  const std::string_view digits = name.substr(std::min(begin.size(), name.size()));
  return name.starts_with(begin) && !digits.empty() && digits.size() <= 6 &&
         std::all_of(digits.begin(), digits.end(), [](unsigned char c) { return std::isdigit(c); });
}

std::string adapter_name(const BluezDevice& device) {
  return device.adapter_path.substr(device.adapter_path.rfind('/') + 1);
}

BluetoothRobot as_robot(const BluezDevice& device) {
  return {device.name, device.address, adapter_name(device), device.paired};
}

bool on_one_of(const std::vector<BluezAdapter>& adapters, const BluezDevice& device) {
  return std::any_of(adapters.begin(), adapters.end(),
                     [&](const BluezAdapter& adapter) { return adapter.path == device.adapter_path; });
}

/// One entry a robot, from one a robot and adapter.
std::vector<BluetoothRobot> spread(std::vector<BluezDevice> devices) {
  std::sort(devices.begin(), devices.end(), [](const BluezDevice& a, const BluezDevice& b) {
    return std::tie(a.name, a.address, a.adapter_path) < std::tie(b.name, b.address, b.adapter_path);
  });
  std::vector<BluetoothRobot> robots;
  std::map<std::string, int> load;  // robots an adapter
  for (auto first = devices.begin(); first != devices.end();) {
    const auto last =
        std::find_if(first, devices.end(), [&](const BluezDevice& d) { return d.address != first->address; });
    const auto best = std::min_element(first, last, [&](const BluezDevice& a, const BluezDevice& b) {
      return a.paired != b.paired ? a.paired : load[a.adapter_path] < load[b.adapter_path];
    });
    ++load[best->adapter_path];
    robots.push_back(as_robot(*best));
    first = last;
  }
  return robots;
}

bool is_called(const BluezDevice& device, std::string_view robot) {
  return device.name == robot || std::equal(device.address.begin(), device.address.end(), robot.begin(), robot.end(),
                                            [](unsigned char a, unsigned char b) { return a == std::toupper(b); });
}

/// The device to pair with; none if it is not known (yet).
std::optional<BluezDevice> find(BluezBus& bus, const std::vector<BluezAdapter>& adapters, std::string_view robot) {
  const auto known = bus.objects();
  if (!known) return {};
  for (const BluezDevice& device : known->devices)
    // A name may come after the address; without it the PIN is not known.
    if (on_one_of(adapters, device) && is_called(device, robot) && !device.name.empty()) return device;
  return {};
}

}  // namespace

core::MotorModel BluetoothRobot::model() const noexcept {
  return name.starts_with(epuck2) ? core::MotorModel::epuck2 : core::MotorModel::epuck1;
}

LinkAddress BluetoothRobot::link() const {
  const int channel = name.starts_with(epuck2) ? 2 : 1;
  return {LinkKind::rfcomm, address, channel, adapter, name};
}

bool is_epuck_name(std::string_view name) noexcept {
  return number_after(epuck1, name) || number_after(epuck2, name);
}

std::string pairing_pin(std::string_view name) {
  return name.starts_with(epuck2) ? "0000" : std::string(name.substr(name.find('_') + 1));
}

tl::expected<std::vector<BluetoothRobot>, std::string> scan_robots(const ScanOptions& options) {
  auto bus = BluezBus::open();
  if (!bus) return tl::unexpected(bus.error());
  const auto adapters = bus->adapters(options.adapter);
  if (!adapters) return tl::unexpected(adapters.error());
  for (const BluezAdapter& adapter : *adapters)
    if (const auto started = bus->start_discovery(adapter); !started) return tl::unexpected(started.error());
  bus->serve(options.seconds, options.keep_on, [] { return false; });
  const auto known = bus->objects();  // before the discovery ends: with it ends what was heard
  for (const BluezAdapter& adapter : *adapters) bus->stop_discovery(adapter);
  if (!known) return tl::unexpected(known.error());
  std::vector<BluezDevice> robots;
  for (const BluezDevice& device : known->devices)
    if (is_epuck_name(device.name) && (device.heard || device.paired) && on_one_of(*adapters, device))
      robots.push_back(device);
  return spread(std::move(robots));
}

tl::expected<BluetoothRobot, std::string> pair_robot(const PairOptions& options) {
  auto bus = BluezBus::open();
  if (!bus) return tl::unexpected(bus.error());
  const auto adapters = bus->adapters(options.adapter);
  if (!adapters) return tl::unexpected(adapters.error());
  auto device = find(*bus, *adapters, options.robot);
  if (!device) {
    for (const BluezAdapter& adapter : *adapters)
      if (const auto started = bus->start_discovery(adapter); !started) return tl::unexpected(started.error());
    bus->serve(options.timeout, options.keep_on,
               [&] { return (device = find(*bus, *adapters, options.robot)).has_value(); });
    for (const BluezAdapter& adapter : *adapters) bus->stop_discovery(adapter);
  }
  if (!device)
    return tl::unexpected(
        fmt::format("no robot {} was found within {:g} s: is it switched on and in range? An e-puck2 is discoverable "
                    "only when its button is held while it is switched on",
                    options.robot, options.timeout));
  if (!is_epuck_name(device->name))
    return tl::unexpected(
        fmt::format("{} has the name \"{}\", which is not that of an e-puck", options.robot, device->name));
  BluetoothRobot robot = as_robot(*device);
  if (robot.paired) return robot;
  const bool can_type = robot.model() == core::MotorModel::epuck1;
  if (const auto paired = bus->pair(*device, pairing_pin(device->name), can_type, options.timeout, options.keep_on);
      !paired)
    return tl::unexpected(paired.error());
  robot.paired = true;
  return robot;
}

}  // namespace skein::comms
