// Faults are planted in a machine that is well otherwise, one at a time: each is named, and nothing else.
#include "app/doctor/doctor.h"

#include <gtest/gtest.h>
#include <sys/stat.h>

#include <algorithm>
#include <cerrno>
#include <cstdlib>
#include <cstring>
#include <filesystem>

#include "app/calibration/calibration_file.h"
#include "app/experiment/experiment_file.h"
#include "tests/app/doctor/patient.h"
#include "vision/calibration/calibration.h"

namespace skein::app {
namespace {

namespace fs = std::filesystem;
using State = Finding::State;

struct Fault {
  const char* name;
  State state;
  const char* says;  // part of the line
  void (*plant)(Patient&);
};

void PrintTo(const Fault& fault, std::ostream* out) {
  *out << fault.name;
}

class Planted : public testing::TestWithParam<Fault> {};

TEST(Doctor, AHealthyMachineIsWell) {
  const Patient patient;
  EXPECT_EQ(patient.complaints(), std::vector<std::string>());
}

// As on a desktop: udev opens cameras, and with the rules of skein-permissions robots, to whoever sits at the machine.
TEST(Doctor, NobodyNeedsAGroupForDevicesThatAreOpen) {
  Patient patient;
  patient.machine.groups = {"anna"};
  EXPECT_EQ(patient.complaints(), std::vector<std::string>());
}

TEST(Doctor, StartsAnExperimentsOwnController) {
  Patient patient;
  patient.machine.start_controller = this_machine().start_controller;
  patient.lab().controller.law.command = "sh -c 'echo one; echo two: no numpy; exit 1'";
  const std::vector<std::string> lines = patient.complaints();
  ASSERT_EQ(lines.size(), 1u) << testing::PrintToString(lines);
  EXPECT_NE(lines[0].find("controller: "), std::string::npos) << lines[0];
  EXPECT_NE(lines[0].find("it exited with status 1: two: no numpy"), std::string::npos) << lines[0];
  EXPECT_EQ(std::count(lines[0].begin(), lines[0].end(), '\n'), 1) << lines[0];
}

TEST_P(Planted, IsNamedAndNothingElse) {
  Patient patient;
  GetParam().plant(patient);
  const std::vector<std::string> lines = patient.complaints();
  ASSERT_EQ(lines.size(), 1u) << testing::PrintToString(lines);
  EXPECT_NE(lines[0].find(GetParam().says), std::string::npos) << lines[0];
  EXPECT_TRUE(lines[0].starts_with(GetParam().state == State::ill ? "ILL " : "note")) << lines[0];
  EXPECT_NE(lines[0].find(" -> "), std::string::npos) << "says what to do: " << lines[0];
}

const Fault faults[] = {
    {"ControllerThatDoesNotStart", State::ill, "No module named 'numpy'",
     [](Patient& p) {
       p.lab().controller.law.command = "python3 my_law.py";
       p.machine.start_controller = [](const Experiment&) -> tl::expected<void, std::string> {
         return tl::unexpected(std::string("the controller did not become ready: No module named 'numpy'"));
       };
     }},
    {"GroupDialout", State::ill, "group dialout",
     [](Patient& p) { p.machine.groups = {"video"}, p.close("/dev/ttyUSB7"); }},
    {"GroupVideo", State::ill, "group video: anna is not in it: cameras (/dev/video7) cannot be opened",
     [](Patient& p) { p.machine.groups = {"dialout"}, p.close("/dev/video7"); }},
    {"NoPriority", State::ill, "real-time priority: not granted (limit 0", [](Patient& p) { p.machine.rtprio = 0; }},
    {"PriorityBelowTheGuards", State::ill, "limit 21, requested 22", [](Patient& p) { p.machine.rtprio = 21; }},
    {"RootOfAContainerWithoutPriority", State::ill, "start it as root, with --cap-add=SYS_NICE",
     [](Patient& p) { p.machine.superuser = true, p.machine.rtprio = 0; }},
    {"NoMemoryLock", State::note, "memory lock: not granted (limit 8192 kB)",
     [](Patient& p) { p.machine.memlock = 8 << 20; }},
    {"NoShareForRealTime", State::ill, "sched_rt_runtime_us is 0",
     [](Patient& p) { p.write("/proc/sys/kernel/sched_rt_runtime_us", "0\n"); }},
    {"HardlyAnyShareForRealTime", State::ill, "sched_rt_runtime_us is 1000 of 1e+06",
     [](Patient& p) { p.write("/proc/sys/kernel/sched_rt_runtime_us", "1000\n"); }},
    {"HardlyAnyShareOfAnotherPeriod", State::ill, "sched_rt_runtime_us is 950000 of 1e+07",
     [](Patient& p) { p.write("/proc/sys/kernel/sched_rt_period_us", "10000000\n"); }},
    {"Governor", State::ill, "CPU frequency: governor powersave",
     [](Patient& p) { p.write("/sys/devices/system/cpu/cpufreq/policy0/scaling_governor", "powersave\n"); }},
    {"GovernorOnDemand", State::note, "governor ondemand",
     [](Patient& p) { p.write("/sys/devices/system/cpu/cpufreq/policy0/scaling_governor", "ondemand\n"); }},
    {"IdleStates", State::note, "idle states: /dev/cpu_dma_latency cannot be written",
     [](Patient& p) { p.machine.usable = [](const std::string& path) { return path != "/dev/cpu_dma_latency"; }; }},
    {"ClockSource", State::note, "clock: hpet",
     [](Patient& p) { p.write("/sys/devices/system/clocksource/clocksource0/current_clocksource", "hpet\n"); }},
    {"Load", State::ill, "load: 3.1 threads at work on 2 cores",
     [](Patient& p) { p.write("/proc/loadavg", "3.10 2.0 1.0 4/200 1\n"); }},
    {"LoadOnTheOneProcessorThatIsOn", State::ill, "load: 1.2 threads at work on 1 core",
     [](Patient& p) {
       p.write("/proc/loadavg", "1.20 1.0 1.0 2/200 1\n");
       p.write("/sys/devices/system/cpu/cpu1/online", "0\n");
     }},
    {"Memory", State::ill, "memory: 98 MB available",
     [](Patient& p) { p.write("/proc/meminfo", "MemAvailable: 100000 kB\n"); }},
    {"LoadUnknown", State::note, "load: not known: /proc/loadavg", [](Patient& p) { p.remove("/proc/loadavg"); }},
    {"MemoryUnknown", State::note, "memory: not known", [](Patient& p) { p.remove("/proc/meminfo"); }},
    {"ProcessorsUnknown", State::note, "CPU frequency: not known",
     [](Patient& p) { p.remove("/sys/devices/system/cpu"); }},
    {"ClockUnknown", State::note, "clock: not known", [](Patient& p) { p.remove("/sys/devices/system/clocksource"); }},
    {"ShareUnknown", State::note, "real-time share: not known", [](Patient& p) { p.remove("/proc/sys/kernel"); }},
    {"KeepingTime", State::ill, "keeping time: latency of bare threads",
     [](Patient& p) { p.machine.keep_time = [](double) { return Patient::late(5e-3); }; }},
    {"OneLongStandstill", State::ill, "keeping time",
     [](Patient& p) {
       p.machine.keep_time = [](double) {
         Timing timing = Patient::late(60e-6);
         timing.tick.add(0.1);
         return timing;
       };
     }},
    {"DiskFull", State::ill, "disk space: 0.2 GB", [](Patient& p) { p.machine.disk_free = [] { return 0.2e9; }; }},
    {"DiskSlow", State::ill, "disk: writes 1 MB/s", [](Patient& p) { p.machine.disk_speed = [] { return 1e6; }; }},
    {"DiskReadOnly", State::ill, "disk: nothing can be written",
     [](Patient& p) {
       p.machine.disk_speed = []() -> tl::expected<double, std::string> {
         return tl::unexpected(std::string("nothing can be written here"));
       };
     }},
    {"NoHomeForRuns", State::ill, "kept runs: no folder for kept runs",
     [](Patient& p) {
       p.machine.runs_directory = []() -> tl::expected<std::string, std::string> {
         return tl::unexpected(std::string("no folder for kept runs: this user has no home"));
       };
     }},
    {"RunsAreAFile", State::ill, "/runs is no folder", [](Patient& p) { p.write("/runs", "a text\n"); }},
    {"RunsBelowAFile", State::ill, "/dev/video0 is no folder",
     [](Patient& p) {
       p.machine.runs_directory = [&p]() -> tl::expected<std::string, std::string> {
         return (p.folder / "dev/video0/runs").string();
       };
     }},
    {"RunsCannotBeWritten", State::ill, "kept runs: /proc/self/runs: nothing can be written in /proc/",
     [](Patient& p) {
       p.machine.runs_directory = []() -> tl::expected<std::string, std::string> { return "/proc/self/runs"; };
     }},
    {"LinkToRunsLeadsNowhere", State::ill, "/runs is a link to /nowhere/lab, which is not there -> mount or make",
     [](Patient& p) { fs::create_symlink("/nowhere/lab", p.folder / "runs"); }},
    {"FolderOfTheRunsFolderLeadsNowhere", State::ill,
     "/data is a link to /nowhere, which is not there -> mount or make",
     [](Patient& p) {
       fs::create_symlink("/nowhere", p.folder / "data");
       p.machine.runs_directory = [&p]() -> tl::expected<std::string, std::string> {
         return (p.folder / "data/skein/runs").string();
       };
     }},
    {"NoMoreFiles", State::ill, "No space left on device -> make room: either bytes or files are used up",
     [](Patient& p) {
       p.machine.disk_speed = []() -> tl::expected<double, std::string> {
         return tl::unexpected(std::string("nothing can be written here (/lab): ") + std::strerror(ENOSPC));
       };
     }},
    {"QuotaIsUsedUp", State::ill, "have your quota raised",
     [](Patient& p) {
       p.machine.disk_speed = []() -> tl::expected<double, std::string> {
         return tl::unexpected(std::string("nothing can be written here (/lab): ") + std::strerror(EDQUOT));
       };
     }},
    {"PriorityWithheldThoughGranted", State::ill,
     "real-time priority is granted, and yet a thread does not get it: Operation not permitted",
     [](Patient& p) {
       p.machine.keep_time = [](double) {
         Timing timing = Patient::late(60e-6);
         timing.priority = 0;
         timing.no_priority = "Operation not permitted";
         return timing;
       };
     }},
    {"NoRoomForRuns", State::ill, "/runs: 0.3 GB free",
     [](Patient& p) { p.machine.free_in = [](const std::string&) { return 0.3e9; }; }},
    {"IndexOfRunsIsNoDatabase", State::note, "/runs/.index.sqlite: is damaged: file is not a database",
     [](Patient& p) { p.write("/runs/.index.sqlite", std::string(4096, 'x')); }},
    {"IndexOfRunsIsAFifo", State::note, "/runs/.index.sqlite: cannot be read: it is a device or a FIFO",
     [](Patient& p) {
       p.write("/runs/run.json", "");
       ASSERT_EQ(::mkfifo((p.machine.root + "/runs/.index.sqlite").c_str(), 0600), 0);
     }},
    {"NoAdapter", State::ill, "Bluetooth: no adapter", [](Patient& p) { p.remove("/sys/class/bluetooth"); }},
    {"RadioSwitch", State::ill, "hci0 is blocked by software",
     [](Patient& p) { p.write("/sys/class/rfkill/rfkill0/soft", "1\n"); }},
    {"SwitchOfTheMachine", State::ill, "hci0 is blocked by a switch of the machine",
     [](Patient& p) { p.write("/sys/class/rfkill/rfkill0/hard", "1\n"); }},
    {"GroupFromTheNextLogin", State::ill, "group dialout: anna is in it from the next login on",
     [](Patient& p) {
       p.machine.groups = {"video"}, p.close("/dev/ttyUSB7"), p.write("/etc/group", "dialout:x:20:bob,anna\n");
     }},
    {"NoDaemon", State::ill, "Bluetooth daemon: it does not run",
     [](Patient& p) {
       p.machine.adapters = []() -> tl::expected<std::vector<BluetoothAdapter>, std::string> {
         return tl::unexpected(std::string("it does not run"));
       };
     }},
    {"AdapterOff", State::ill, "Bluetooth hci1: is switched off",
     [](Patient& p) {
       p.machine.adapters = [] { return std::vector<BluetoothAdapter>{{"hci0", "A", true}, {"hci1", "B", false}}; };
     }},
    {"TooManyRobots", State::ill, "1 adapter on: 7 robots at most, 8 wanted",
     [](Patient& p) { p.lab().robots.resize(9, p.lab().robots[1]); }},
    {"AdapterOfAnOpenRobotGone", State::ill, "Bluetooth: no adapter",
     [](Patient& p) {
       p.lab().robots.resize(2);
       p.lab().robots[1].address = "open+rfcomm:10:00:E8:AA:BB:01/1";
       p.remove("/sys/class/bluetooth");
     }},
    {"AdapterUnknown", State::ill, "Bluetooth hci3: an experiment names it",
     [](Patient& p) { p.lab().robots[1].adapter = "hci3"; }},
    {"ModemManager", State::note, "ModemManager", [](Patient& p) { p.write("/proc/800/comm", "ModemManager\n"); }},
    {"CableGone", State::ill, "/dev/ttyACM0: is not there", [](Patient& p) { p.remove("/dev/ttyACM0"); }},
    {"CameraForbidden", State::ill, "/dev/video0: you have no permission to open it",
     [](Patient& p) { p.machine.usable = [](const std::string& path) { return path != "/dev/video0"; }; }},
    {"NoCamera", State::ill, "camera: none", [](Patient& p) { p.remove("/sys/class/video4linux"); }},
    {"OtherCamera", State::ill, "/dev/video2: is not there",
     [](Patient& p) { p.lab().camera.source = "v4l2:/dev/video2"; }},
    {"NetworkCameraSilent", State::ill, "Basler-1: does not answer",
     [](Patient& p) {
       p.lab().camera.source = "aravis:Basler-1";
       p.machine.network_cameras = [](const auto&) { return std::vector<std::string>{"Basler-2", "192.168.3.7"}; };
     }},
    {"ReceiveBufferBelowAFrame", State::note, "receive buffer: 212992 bytes",
     [](Patient& p) {
       p.lab().camera.source = "aravis:Basler-2";
       p.machine.network_cameras = [](const auto&) { return std::vector<std::string>{"Basler-2", "192.168.3.7"}; };
       p.write("/proc/sys/net/core/rmem_max", "212992\n");
     }},
    {"NoCalibration", State::ill, "calibration: ", [](Patient& p) { p.remove("/cal.toml"); }},
    {"CalibrationTorn", State::ill, "calibration: ", [](Patient& p) { p.write("/cal.toml", "width = 1280\nhei"); }},
    {"NoFloor", State::ill, "has no pose of the camera",
     [](Patient& p) {
       vision::Calibration calibration = vision::overhead_calibration(3.0, 2.0);
       calibration.world_from_camera.reset();
       EXPECT_TRUE(save_calibration(calibration, p.folder / "cal.toml"));
     }},
    {"TagSizes", State::ill, "tag size: ",
     [](Patient& p) {
       vision::Calibration calibration = vision::overhead_calibration(3.0, 2.0);
       calibration.tag_size = 0.06;
       EXPECT_TRUE(save_calibration(calibration, p.folder / "other.toml"));
       p.examination.experiments.push_back(p.examination.experiments[0]);
       p.examination.experiments[1].second.camera.calibration = "other.toml";
     }},
    {"NoGuard", State::ill, "guard: the folder is not writable",
     [](Patient& p) {
       p.machine.guard = []() -> tl::expected<std::string, std::string> {
         return tl::unexpected(std::string("the folder is not writable"));
       };
     }},
    {"LeftBehind", State::ill, "an earlier run: yesterday ended badly",
     [](Patient& p) { p.machine.bad_ends = [] { return std::vector<std::string>{"yesterday"}; }; }},
    {"NoModules", State::ill, "modules: films",
     [](Patient& p) {
       p.machine.modules = []() -> tl::expected<void, std::string> { return tl::unexpected(std::string("films")); };
     }},
    {"NoGnuplot", State::note, "gnuplot: is missing",
     [](Patient& p) { p.machine.has_program = [](const std::string& name) { return name != "gnuplot"; }; }},
    {"NoDisplay", State::note, "display: none", [](Patient& p) { p.machine.display = ""; }},
    {"WaylandAlone", State::note, "display: Wayland (wayland-0) without XWayland",
     [](Patient& p) { p.machine.display = "wayland-0"; }},
    {"DeadDisplay", State::ill, "DISPLAY is :7.0, but there is no display server",
     [](Patient& p) { p.machine.display = ":7.0"; }},
};
static_assert(std::size(faults) >= 20);

INSTANTIATE_TEST_SUITE_P(Fault, Planted, testing::ValuesIn(faults),
                         [](const auto& fault) { return std::string(fault.param.name); });

TEST(Doctor, ASimulationNeedsNoRobotsAndNoCamera) {
  Patient patient;
  patient.examination.experiments[0].second = paper_experiment();
  patient.remove("/sys/class/bluetooth");
  patient.remove("/sys/class/video4linux");
  for (const Finding& finding : examine(patient.machine, patient.examination))
    EXPECT_NE(finding.state, State::ill) << as_line(finding);
}

TEST(Doctor, ANetworkCameraThatAnswersIsWellWithoutADevice) {
  for (const char* source : {"aravis:Basler-2", "aravis:192.168.3.7"}) {
    Patient patient;
    patient.remove("/sys/class/video4linux");
    patient.lab().camera.source = source;
    patient.machine.network_cameras = [](const auto&) { return std::vector<std::string>{"Basler-2", "192.168.3.7"}; };
    EXPECT_EQ(patient.complaints(), std::vector<std::string>()) << source;
  }
}

TEST(Doctor, AProcessorThatChoosesItsFrequencyItselfIsWell) {
  Patient patient;
  patient.write("/sys/devices/system/cpu/cpufreq/policy0/scaling_governor", "powersave\n");
  patient.write("/sys/devices/system/cpu/cpufreq/policy0/scaling_driver", "intel_pstate\n");
  EXPECT_EQ(patient.complaints(), std::vector<std::string>());
}

/// One that was computed differs from one that was written by its last digits.
TEST(Doctor, TagSizesThatPrintTheSameAgree) {
  Patient patient;
  vision::Calibration calibration = vision::overhead_calibration(3.0, 2.0);
  calibration.tag_size += 1e-12;
  EXPECT_TRUE(save_calibration(calibration, patient.folder / "other.toml"));
  patient.examination.experiments.push_back(patient.examination.experiments[0]);
  patient.examination.experiments[1].second.camera.calibration = "other.toml";
  EXPECT_EQ(patient.complaints(), std::vector<std::string>());
}

/// As in a container without /proc or /sys: nothing that they would have told is called well.
TEST(Doctor, SaysWhatCannotBeSeen) {
  for (const auto& [folder, subjects] : std::vector<std::pair<const char*, std::vector<const char*>>>{
           {"/proc", {"real-time share", "load", "memory"}},
           {"/sys", {"CPU frequency", "clock", "Bluetooth", "camera"}}}) {
    Patient patient;
    patient.remove(folder);
    for (const char* const subject : subjects) {
      const std::vector<std::string> lines = patient.complaints();
      EXPECT_TRUE(std::any_of(lines.begin(), lines.end(),
                              [&](const std::string& line) {
                                return line.find(std::string(subject) + ": not known: " + folder) != std::string::npos;
                              }))
          << subject << testing::PrintToString(lines);
    }
  }
}

TEST(Doctor, WhatCanBeFixedIsACommand) {
  Patient patient;
  patient.machine.groups = {"video"};
  patient.close("/dev/ttyUSB7");
  patient.machine.rtprio = 0;
  std::vector<std::vector<std::string>> commands;
  for (const Finding& finding : examine(patient.machine, patient.examination))
    commands.insert(commands.end(), finding.fix.begin(), finding.fix.end());
  const auto named = [&](const std::vector<std::string>& command) {
    return std::find(commands.begin(), commands.end(), command) != commands.end();
  };
  EXPECT_TRUE(named({"adduser", "anna", "dialout"}));
  EXPECT_TRUE(named({"adduser", "anna", "skein"}));
}

TEST(Doctor, SwitchesOnTheAdaptersThatAreOff) {
  Patient patient;
  patient.machine.adapters = [] {
    return std::vector<BluetoothAdapter>{{"hci0", "A", true}, {"hci1", "B", false}, {"hci2", "C", false}};
  };
  std::vector<std::string> switched;
  for (const Finding& finding : examine(patient.machine, patient.examination))
    for (const auto& command : finding.fix)
      for (const std::string& word : command)
        if (word.starts_with("/org/bluez/")) switched.push_back(word);
  EXPECT_EQ(switched, (std::vector<std::string>{"/org/bluez/hci1", "/org/bluez/hci2"}));
}

/// A run is guarded all the same: its marker goes to another place.
TEST(Doctor, AStateDirectoryThatCannotBeWrittenDoesNotTakeTheGuard) {
  const char* const before = std::getenv("XDG_STATE_HOME");
  const std::string home = before != nullptr ? before : "";
  ::setenv("XDG_STATE_HOME", "/proc/nowhere", 1);
  const Machine here = this_machine();
  Patient patient;
  patient.machine.guard = here.guard;
  const std::vector<std::string> lines = patient.complaints();
  before != nullptr ? ::setenv("XDG_STATE_HOME", home.c_str(), 1) : ::unsetenv("XDG_STATE_HOME");
  ASSERT_EQ(lines.size(), 1u) << testing::PrintToString(lines);
  EXPECT_TRUE(lines[0].starts_with("note  guard: can be started; /proc/nowhere/skein")) << lines[0];
}

TEST(Doctor, LooksAtTheMachineItRunsOn) {
  const std::vector<Finding> findings = examine(this_machine(), {0.2, {}});
  EXPECT_GE(findings.size(), 12u);
  EXPECT_EQ(findings.back().what, "keeping time");
}

}  // namespace
}  // namespace skein::app
