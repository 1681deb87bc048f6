#pragma once

#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <string>
#include <vector>

#include "app/calibration/calibration_file.h"
#include "app/doctor/doctor.h"
#include "app/experiment/experiment_file.h"
#include "tests/app/folder.h"
#include "vision/calibration/calibration.h"

namespace skein::app {

/// A machine on which every run goes well, with a /proc, /sys and /dev in a folder of its own.
class Patient {
 public:
  Patient() {
    machine.root = folder.string();
    write("/proc/loadavg", "0.31 0.20 0.10 1/200 4711\n");
    write("/proc/meminfo", "MemTotal: 8000000 kB\nMemAvailable:    4000000 kB\n");
    write("/proc/sys/kernel/sched_rt_runtime_us", "950000\n");
    write("/proc/sys/net/core/rmem_max", "33554432\n");
    write("/proc/4711/comm", "bash\n");
    for (const char* cpu : {"cpu0", "cpu1"}) write(std::string("/sys/devices/system/cpu/") + cpu + "/online", "1\n");
    write("/sys/devices/system/cpu/cpufreq/policy0/scaling_governor", "performance\n");
    write("/sys/devices/system/clocksource/clocksource0/current_clocksource", "tsc\n");
    write("/sys/class/bluetooth/hci0/address", "\n");
    write("/sys/class/rfkill/rfkill0/type", "bluetooth\n");
    write("/sys/class/rfkill/rfkill0/name", "hci0\n");
    write("/sys/class/rfkill/rfkill0/soft", "0\n");
    write("/sys/class/rfkill/rfkill0/hard", "0\n");
    write("/sys/class/video4linux/video0/name", "HD Camera\n");
    write("/dev/video0", "");
    write("/dev/ttyACM0", "");
    write("/tmp/.X11-unix/X0", "");
    machine.user = "anna";
    machine.groups = {"anna", "dialout", "video"};
    machine.rtprio = 25;
    machine.memlock = -1;
    machine.display = ":0";
    machine.usable = [](const std::string&) { return true; };
    machine.adapters = [] { return std::vector<BluetoothAdapter>{{"hci0", "00:1A:7D:DA:71:13", true}}; };
    machine.keep_time = [](double) { return late(60e-6); };
    machine.disk_speed = [] { return 120e6; };
    machine.disk_free = [] { return 50e9; };
    machine.runs_directory = [this]() -> tl::expected<std::string, std::string> { return (folder / "runs").string(); };
    machine.free_in = [](const std::string&) { return 50e9; };
    machine.guard = [] { return tl::expected<std::string, std::string>(); };
    machine.start_controller = [](const Experiment&) { return tl::expected<void, std::string>(); };
    machine.bad_ends = [] { return std::vector<std::string>(); };
    machine.modules = [] { return tl::expected<void, std::string>(); };
    machine.has_program = [](const std::string&) { return true; };

    vision::Calibration calibration = vision::overhead_calibration(3.0, 2.0);
    EXPECT_TRUE(save_calibration(calibration, folder / "cal.toml"));
    Experiment lab = paper_experiment();
    lab.camera.source = "v4l2:/dev/video0";
    lab.camera.calibration = "cal.toml";
    for (std::size_t i = 0; i < lab.robots.size(); ++i) {
      lab.robots[i].link = RobotSpec::Link::device;
      lab.robots[i].address = "rfcomm:10:00:E8:AA:BB:0" + std::to_string(i) + "/1";
    }
    lab.robots[0].address = "serial:/dev/ttyACM0";
    examination.experiments.emplace_back((folder / "lab.toml").string(), lab);
  }
  Patient(const Patient&) = delete;
  Patient& operator=(const Patient&) = delete;

  /// A device that only members of its group may open.
  void close(const std::string& path) {
    write(path, "");
    machine.usable = [path](const std::string& device) { return device != path; };
  }
  void write(const std::string& path, const std::string& text) const {
    const std::filesystem::path file = folder / path.substr(1);
    std::filesystem::create_directories(file.parent_path());
    std::ofstream(file) << text;
  }
  void remove(const std::string& path) const { std::filesystem::remove_all(folder / path.substr(1)); }
  Experiment& lab() { return examination.experiments[0].second; }

  static Timing late(double seconds) {
    Timing timing;
    timing.priority = 20;
    for (int k = 0; k < 250; ++k) timing.tick.add(seconds), timing.bare.add(seconds);
    return timing;
  }
  /// The lines that are not well.
  std::vector<std::string> complaints() const {
    std::vector<std::string> lines;
    for (const Finding& finding : examine(machine, examination))
      if (finding.state != Finding::State::well) lines.push_back(as_line(finding));
    return lines;
  }

  const test::Folder own_folder;
  const std::filesystem::path folder = own_folder.path;
  Machine machine;
  Examination examination;
};

}  // namespace skein::app
