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
  std::string adapter;  ///< the PC's adapter to use for it: "hci0"
  bool paired = false;  ///< with that adapter

  core::MotorModel model() const noexcept;  ///< from its name
  LinkAddress link() const;                 ///< its serial port: channel 1 of an e-puck1, 2 of an e-puck2
};

/// Whether a Bluetooth name is that of an e-puck, "e-puck_" or "e-puck2_" and digits.
bool is_epuck_name(std::string_view name) noexcept;

/// The PIN for pairing: an e-puck1's number; 0000 for an e-puck2, which requests it from old systems only.
std::string pairing_pin(std::string_view name);

struct ScanOptions {
  std::string adapter = {};            ///< "hci1" or its address; empty: all
  double seconds = 10.0;               ///< duration of the scan; an inquiry takes 10.24 s
  std::function<bool()> keep_on = {};  ///< called several times per second; false ends the scan early
};

/// Lets the daemon search for robots; returns those found or already paired, in the order of their names. A robot that
/// several adapters have found gets the adapter that it is paired with, or the one with the fewest robots. Blocks for
/// `seconds`. The error names what is missing: system bus, daemon, adapter, permission.
tl::expected<std::vector<BluetoothRobot>, std::string> scan_robots(const ScanOptions& options);

struct PairOptions {
  std::string robot;                   ///< name or address
  std::string adapter = {};            ///< as above; empty: one that finds it
  double timeout = 30.0;               ///< to find it, and again to pair [s]
  std::function<bool()> keep_on = {};  ///< as above
};

/// Pairs with a robot: searches for it if the daemon does not know it, answers its PIN request. A paired robot stays
/// paired. Returns the robot, or the reason for the failure.
tl::expected<BluetoothRobot, std::string> pair_robot(const PairOptions& options);

}  // namespace skein::comms
