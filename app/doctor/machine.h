#pragma once

#include <sys/types.h>

#include <functional>
#include <optional>
#include <string>
#include <vector>

#include <tl/expected.hpp>

#include "app/experiment/experiment.h"
#include "app/run/timing.h"
#include "vision/sources/open_source.h"

namespace skein::app {

/// One of the PC's Bluetooth adapters, as the Bluetooth daemon knows it.
struct BluetoothAdapter {
  std::string name;  ///< "hci0"
  std::string address;
  bool powered = false;
};

/// The properties of a machine that `skein doctor` checks, so that a test can set faulty ones.
struct Machine {
  std::string root;                 ///< prefix of every path: empty, or a folder with a /proc, /sys, /dev of its own
  std::string user;                 ///< the user who runs the program
  bool superuser = false;           ///< has root privileges
  std::vector<std::string> groups;  ///< of this process, by name
  long rtprio = 0;                  ///< soft limit of real-time priorities; -1: none
  long memlock = 0;                 ///< soft limit of memory that may be locked [bytes]; -1: none
  std::string display;              ///< value of DISPLAY or WAYLAND_DISPLAY; empty: neither is set
  bool window = true;               ///< the program was built with one

  /// Whether this process may read and write a device.
  std::function<bool(const std::string& path)> usable;
  /// Asks the Bluetooth daemon; the error is its reason.
  std::function<tl::expected<std::vector<BluetoothAdapter>, std::string>()> adapters;
  /// Runs two threads that only wait for their next tick at 25 Hz, for so many seconds: `tick` at real-time priority,
  /// `bare` at normal priority.
  std::function<Timing(double seconds)> keep_time;
  /// Writes and syncs a few megabytes in the working directory. [bytes/s]
  std::function<tl::expected<double, std::string>()> disk_speed;
  std::function<double()> disk_free;  ///< [bytes], for this user in the working directory
  /// The folder of kept runs, which need not exist; the error: there is none. And the free space there [bytes].
  std::function<tl::expected<std::string, std::string>()> runs_directory;
  std::function<double(const std::string& folder)> free_in;
  /// Why markers of runs go elsewhere than to the user's state directory; empty: they do not. The error: why none can
  /// be written, or no guard be started.
  std::function<tl::expected<std::string, std::string>()> guard;
  /// Starts an experiment's own controller as a run does, and ends it; the error, one line, says why it cannot start.
  std::function<tl::expected<void, std::string>(const Experiment&)> start_controller;
  std::function<std::vector<std::string>()> bad_ends;  ///< names of runs that ended badly, see run_marker.h
  /// Names and network addresses of the cameras of this kind that answer; takes a second.
  std::function<std::vector<std::string>(const vision::SourceKind& kind)> network_cameras;
  /// Whether the modules can be loaded: films, boards, Aravis.
  std::function<tl::expected<void, std::string>()> modules;
  std::function<bool(const std::string& program)> has_program;  ///< on the PATH
  /// For --fix: runs it as root; the error says that it did not end with status 0, or did not start.
  std::function<tl::expected<void, std::string>(const std::vector<std::string>& command)> execute;
};

/// This machine.
Machine this_machine();

}  // namespace skein::app
