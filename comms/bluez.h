#pragma once

#include <functional>
#include <optional>
#include <string>
#include <string_view>
#include <tl/expected.hpp>
#include <vector>

#include "comms/link_address.h"
#include "core/kinematics/step_rate.h"

namespace skein::comms {

/// A robot as the Bluetooth daemon (org.bluez on D-Bus's system bus) knows it.
struct BluetoothRobot {
  std::string name;     ///< "e-puck_1234" (an e-puck1), "e-puck2_01234"
  std::string address;  ///< "10:00:E8:AA:BB:CC"
  std::string adapter;  ///< of the PC, that is to talk to it: "hci0"
  bool paired = false;  ///< with that adapter

  core::MotorModel model() const noexcept;  ///< as its name says
  LinkAddress link() const;                 ///< its serial port: channel 1 of an e-puck1, 2 of an e-puck2
};

/// Whether a Bluetooth name is that of an e-puck, "e-puck_" or "e-puck2_" and digits.
bool is_epuck_name(std::string_view name) noexcept;

/// What a robot wants to hear when it is paired: an e-puck1 its number, an e-puck2 (which asks old systems only) 0000.
std::string pairing_pin(std::string_view name);

struct ScanOptions {
  std::string adapter = {};            ///< "hci1" or its address; empty: all there are
  double seconds = 10.0;               ///< how long to listen; an inquiry takes 10.24 s
  std::function<bool()> keep_on = {};  ///< asked several times a second; false ends the scan early
};

/// Has the daemon look for robots, and says which it has found, or knows as paired, in the order of their names. Where
/// several adapters have heard a robot it gets the one that it is paired with, or that has the fewest robots. Blocks
/// that long. The error says what is missing: system bus, daemon, adapter, permission.
tl::expected<std::vector<BluetoothRobot>, std::string> scan_robots(const ScanOptions& options);

struct PairOptions {
  std::string robot;                   ///< name or address
  std::string adapter = {};            ///< as above; empty: one that hears it
  double timeout = 30.0;               ///< to find it, and again to pair [s]
  std::function<bool()> keep_on = {};  ///< as above
};

/// Pairs with a robot: looks for it if the daemon does not know it, answers its question for a PIN. One that is paired
/// already stays so. The robot as it is then, or why not.
tl::expected<BluetoothRobot, std::string> pair_robot(const PairOptions& options);

}  // namespace skein::comms
