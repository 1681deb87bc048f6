// skein doctor --fix as a whole: faults are planted in a machine in a folder, and the commands that the program starts
// are scripts that change it as the real ones would.
#include <gmock/gmock.h>

#include <algorithm>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <sstream>
#include <string>
#include <vector>

#include "app/cli/commands.h"
#include "app/run/exit_status.h"
#include "tests/app/doctor/patient.h"
#include "tests/files.h"

namespace skein::app {
namespace {

namespace fs = std::filesystem;
using testing::AllOf;
using testing::AnyOf;
using testing::HasSubstr;
using testing::Not;

/// Every command: it writes its words to `executed`, and changes the machine in $root.
constexpr const char* script = R"sh(
PATH=/usr/bin:/bin
name=${0##*/}
if [ "$name" = sudo ]; then name=$1; shift; exec "$root/bin/$name" "$@"; fi
{ printf '%s' "$name"; for word; do printf '\t%s' "$word"; done; echo; } >> "$root/executed"
if [ -e "$root/refuses-$name" ]; then exit 7; fi
case $name in
  adduser) grep -q "^$2:" "$root/etc/group" && sed -i "/^$2:/{s/\$/,$1/;s/:,/:/}" "$root/etc/group" ;;
  addgroup) grep -q ^skein: "$root/etc/group" || echo skein:x:999: >> "$root/etc/group" ;;
  sysctl) key=${1%%=*}; echo "${1#*=}" > "$root/proc/sys/$(echo "$key" | tr . /)" ;;
  rfkill) echo 0 > "$root/sys/class/rfkill/rfkill0/soft" ;;
  systemctl) touch "$root/daemon" ;;
  busctl) touch "$root/on-${3##*/}" ;;
  apt-get) touch "$root/gnuplot" ;;
  udevadm) ;;
  sh) exec /bin/sh -c "$(printf '%s' "$2" | sed "s# /\(etc\|sys\)/# $root/\1/#g")" ;;
esac
)sh";

/// The machine of a user who has just logged in. What is wrong with it is in its folder.
class DoctorFix : public testing::Test {
 protected:
  DoctorFix() {
    if (const char* const path = std::getenv("PATH")) path_ = path;
    for (const char* name :
         {"sudo", "adduser", "addgroup", "sysctl", "rfkill", "systemctl", "busctl", "apt-get", "udevadm", "sh"}) {
      patient.write(std::string("/bin/") + name, "#!/bin/sh\nroot='" + folder() + "'" + script);
      fs::permissions(patient.folder / "bin" / name, fs::perms::owner_all);
    }
    patient.write("/etc/group", "dialout:x:20:bob,anna\nvideo:x:44:anna\nskein:x:999:anna\n");
    patient.write("/etc/security/limits.d/60-skein.conf", "@skein - rtprio 25\n@skein - memlock unlimited\n");
    patient.write("/etc/udev/rules.d/60-skein-latency.rules",
                  "KERNEL==\"cpu_dma_latency\", GROUP=\"skein\", MODE=\"0660\"\n");
    for (const char* name : {"/daemon", "/on-hci0", "/on-hci1", "/gnuplot"}) patient.write(name, "");
    Machine& machine = patient.machine;
    machine.execute = this_machine().execute;
    for (const char* device : {"/dev/ttyUSB7", "/dev/video7"}) patient.write(device, "");
    machine.usable = [this](const std::string& path) {
      if (path == "/dev/ttyUSB7") return is_in("dialout");
      if (path == "/dev/video7") return is_in("video");
      return path != "/dev/cpu_dma_latency" ||
             (is_in("skein") && has("etc/udev/rules.d/60-skein-latency.rules", R"(GROUP="skein", MODE="0660")"));
    };
    machine.adapters = [this]() -> tl::expected<std::vector<BluetoothAdapter>, std::string> {
      if (!exists("daemon")) return tl::unexpected(std::string("it does not run"));
      return std::vector<BluetoothAdapter>{{"hci0", "A", exists("on-hci0")}, {"hci1", "B", exists("on-hci1")}};
    };
    machine.has_program = [this](const std::string& program) { return exists(program); };
    machine.network_cameras = [](const auto&) { return std::vector<std::string>{"Basler-1"}; };
    patient.write("/lab.toml",
                  "[camera]\nsource = \"aravis:Basler-1\"\ncalibration = \"cal.toml\"\n"
                  "[[robot]]\ntag = 1\nlink = \"rfcomm:10:00:E8:AA:BB:01/1\"\n");
    log_in();
    ::setenv("PATH", (folder() + "/bin").c_str(), 1);
  }
  ~DoctorFix() override { ::setenv("PATH", path_.c_str(), 1); }

  std::string folder() const { return patient.folder.string(); }
  bool exists(const std::string& name) const { return fs::exists(patient.folder / name); }
  std::string read(const std::string& name) const { return test::read_file(patient.folder / name); }
  bool has(const std::string& name, const std::string& text) const {
    return read(name).find(text) != std::string::npos;
  }
  bool is_in(const std::string& group) const {
    const auto& groups = patient.machine.groups;
    return std::find(groups.begin(), groups.end(), group) != groups.end();
  }
  /// A session begins with what the machine's files grant.
  void log_in() {
    Machine& machine = patient.machine;
    machine.groups = {"anna"};
    std::istringstream groups(read("etc/group"));
    for (std::string line; std::getline(groups, line);)
      if (line.find("anna") != std::string::npos) machine.groups.push_back(line.substr(0, line.find(':')));
    const auto grants = [this](const char* limit) {
      return is_in("skein") && (has("etc/security/limits.d/60-skein.conf", limit) ||
                                has("etc/security/limits.d/60-skein-doctor.conf", limit));
    };
    machine.rtprio = grants("@skein - rtprio 25\n") ? 25 : 0;
    machine.memlock = grants("@skein - memlock unlimited\n") ? -1 : 8 << 20;
  }

  /// The exit status of the command; what it prints is in `out` and `said`.
  int examine(bool fix, const std::string& experiment = "lab.toml") {
    testing::internal::CaptureStdout();
    testing::internal::CaptureStderr();
    const int status =
        doctor({.experiments = {{folder() + "/" + experiment, {}}}, .seconds = 0.0, .fix = fix}, patient.machine);
    out = testing::internal::GetCapturedStdout(), said = testing::internal::GetCapturedStderr();
    return status;
  }
  /// The lines that begin so.
  std::vector<std::string> lines(const std::string& beginning) const {
    std::vector<std::string> all;
    std::istringstream text(out);
    for (std::string line; std::getline(text, line);)
      if (line.starts_with(beginning)) all.push_back(line);
    return all;
  }
  /// The words of every command so far, which are forgotten.
  std::string executed() const {
    std::string words = read("executed");
    patient.remove("/executed");
    return words;
  }

  Patient patient;
  std::string out, said;

 private:
  std::string path_;
};

struct Fixable {
  const char* name;
  int status;  // of the first examination
  void (*plant)(Patient&);
  std::vector<std::string> fixed_by;  // lines
  bool from_next_login = false;
};

void PrintTo(const Fixable& fault, std::ostream* text) {
  *text << fault.name;
}

const std::string limits = R"(sh -c 'printf '\''@skein - rtprio 25\n@skein - memlock unlimited\n'\'' > )"
                           "/etc/security/limits.d/60-skein-doctor.conf'";

const std::string latency_rule =
    R"(fix   idle states: sh -c 'echo '\''KERNEL=="cpu_dma_latency", GROUP="skein", MODE="0660"'\'' > )"
    "/etc/udev/rules.d/60-skein-latency.rules'";

const std::vector<Fixable>& fixable() {
  static const std::vector<Fixable> all{
      {"Dialout",
       expectation_failed,
       [](Patient& p) { p.write("/etc/group", "dialout:x:20:bob\nvideo:x:44:anna\nskein:x:999:anna\n"); },
       {"fix   group dialout: adduser anna dialout"},
       true},
      {"NoGroupSkein",
       expectation_failed,
       [](Patient& p) {
         p.write("/etc/group", "dialout:x:20:anna\nvideo:x:44:anna\n");
         p.remove("/etc/security/limits.d/60-skein.conf");
         p.remove("/etc/udev/rules.d/60-skein-latency.rules");
       },
       {"fix   real-time priority: addgroup --quiet --system skein", "fix   real-time priority: " + limits,
        "fix   real-time priority: adduser anna skein", latency_rule, "fix   idle states: udevadm control --reload",
        "fix   idle states: udevadm trigger --sysname-match=cpu_dma_latency"},
       true},
      {"MemoryLock",
       done,
       [](Patient& p) { p.write("/etc/security/limits.d/60-skein.conf", "@skein - rtprio 25\n"); },
       {"fix   memory lock: addgroup --quiet --system skein", "fix   memory lock: " + limits,
        "fix   memory lock: adduser anna skein"},
       true},
      {"ShareForRealTime",
       expectation_failed,
       [](Patient& p) { p.write("/proc/sys/kernel/sched_rt_runtime_us", "0\n"); },
       {"fix   real-time share: sysctl kernel.sched_rt_runtime_us=950000"}},
      {"Governor",
       expectation_failed,
       [](Patient& p) { p.write("/sys/devices/system/cpu/cpufreq/policy0/scaling_governor", "powersave\n"); },
       {"fix   CPU frequency: sh -c 'for g in /sys/devices/system/cpu/cpufreq/policy*/scaling_governor; do echo "
        "performance > $g || exit; done'"}},
      {"Switch",
       expectation_failed,
       [](Patient& p) { p.write("/sys/class/rfkill/rfkill0/soft", "1\n"); },
       {"fix   Bluetooth switch: rfkill unblock bluetooth"}},
      {"Daemon",
       expectation_failed,
       [](Patient& p) { p.remove("/daemon"); },
       {"fix   Bluetooth daemon: systemctl enable --now bluetooth"}},
      {"AdapterOff",
       expectation_failed,
       [](Patient& p) { p.remove("/on-hci1"); },
       {"fix   Bluetooth hci1: busctl set-property org.bluez /org/bluez/hci1 org.bluez.Adapter1 Powered b true"}},
      {"ReceiveBuffer",
       done,
       [](Patient& p) { p.write("/proc/sys/net/core/rmem_max", "212992\n"); },
       {"fix   receive buffer: sysctl net.core.rmem_max=33554432"}},
      {"Gnuplot", done, [](Patient& p) { p.remove("/gnuplot"); }, {"fix   gnuplot: apt-get install -y gnuplot-nox"}},
  };
  return all;
}

class DoctorFixes : public DoctorFix, public testing::WithParamInterface<Fixable> {};

TEST_F(DoctorFix, NothingOnAHealthyMachine) {
  EXPECT_EQ(examine(true), done) << out << said;
  EXPECT_THAT(out,
              AllOf(Not(HasSubstr("fix ")), Not(HasSubstr("by hand ")), Not(HasSubstr("ILL")), Not(HasSubstr("note"))));
  EXPECT_EQ(executed(), "");
}

TEST_P(DoctorFixes, WhatItNamesAndASecondExaminationFindsIt) {
  GetParam().plant(patient);
  log_in();
  EXPECT_EQ(examine(false), GetParam().status) << out << said;
  EXPECT_EQ(executed(), "") << "nothing without --fix";
  EXPECT_EQ(examine(true), GetParam().status) << out << said;
  EXPECT_EQ(lines("fix "), GetParam().fixed_by) << out;
  EXPECT_EQ(lines("by hand "), std::vector<std::string>());
  EXPECT_EQ(said, "");
  const std::string words = executed();
  EXPECT_EQ(static_cast<std::size_t>(std::count(words.begin(), words.end(), '\n')), GetParam().fixed_by.size());

  if (GetParam().from_next_login) {
    EXPECT_EQ(examine(true), GetParam().status) << out << said;
    EXPECT_EQ(lines("fix "), std::vector<std::string>()) << "it is fixed, but not for this session";
    EXPECT_THAT(out, HasSubstr(" -> log in again"));
    log_in();
  }
  EXPECT_EQ(examine(true), done) << out << said;
  EXPECT_THAT(out, AllOf(Not(HasSubstr("ILL")), Not(HasSubstr("note")), Not(HasSubstr("fix ")))) << "it is well now";
  EXPECT_EQ(executed(), "");

  // A shell that is given the printed lines executes the same words.
  for (const std::string& line : GetParam().fixed_by)
    EXPECT_EQ(std::system(line.substr(line.find(": ") + 2).c_str()), 0) << line;
  EXPECT_EQ(executed(), words);
}

INSTANTIATE_TEST_SUITE_P(Fault, DoctorFixes, testing::ValuesIn(fixable()),
                         [](const auto& fault) { return std::string(fault.param.name); });

TEST_F(DoctorFix, AllAtOnceAndEachCommandOnce) {
  std::vector<std::string> expected;
  for (const Fixable& fault : fixable()) {
    if (std::string(fault.name) == "MemoryLock" || std::string(fault.name) == "Daemon") continue;  // within others
    fault.plant(patient);
    expected.insert(expected.end(), fault.fixed_by.begin(), fault.fixed_by.end());
  }
  patient.write("/etc/group", "dialout:x:20:bob\nvideo:x:44:bob\n");
  expected.insert(expected.begin() + 1, "fix   group video: adduser anna video");
  log_in();
  EXPECT_EQ(examine(true), expectation_failed);
  EXPECT_THAT(lines("fix "), testing::UnorderedElementsAreArray(expected));
  log_in();
  EXPECT_EQ(examine(true), done) << out << said;
}

TEST_F(DoctorFix, WhatOnlyAPersonCanDoIsSaid) {
  patient.write("/proc/loadavg", "9.10 2.0 1.0 4/200 1\n");
  patient.write("/sys/class/rfkill/rfkill0/hard", "1\n");
  patient.write("/sys/devices/system/clocksource/clocksource0/current_clocksource", "hpet\n");  // a note
  patient.remove("/cal.toml");
  EXPECT_EQ(examine(true), expectation_failed);
  EXPECT_EQ(lines("by hand "), (std::vector<std::string>{
                                   "by hand  load: close other programs; top says which",
                                   "by hand  Bluetooth switch: turn the machine's own switch",
                                   "by hand  calibration: skein calibrate, see docs/calibration.md",
                               }));
  EXPECT_EQ(lines("fix "), std::vector<std::string>());
  EXPECT_EQ(executed(), "");
  EXPECT_EQ(examine(false), expectation_failed);
  EXPECT_EQ(lines("by hand "), std::vector<std::string>()) << "without --fix a line each says it all";
}

TEST_F(DoctorFix, ACommandThatFailsEndsItsFindingAndIsAFailedCheck) {
  fixable()[1].plant(patient);
  log_in();
  patient.write("/refuses-addgroup", "");
  EXPECT_EQ(examine(true), expectation_failed);
  EXPECT_EQ(said, "skein: real-time priority: addgroup ended with status 7\n");
  EXPECT_EQ(lines("fix "), (std::vector<std::string>{"fix   real-time priority: addgroup --quiet --system skein"}))
      << "neither what needs the group, nor the same again for memory lock and idle states";
  EXPECT_EQ(executed(), "addgroup\t--quiet\t--system\tskein\n");
}

TEST_F(DoctorFix, ANoteWhoseCommandFailsIsAFailedCheck) {
  patient.remove("/gnuplot");
  patient.write("/refuses-apt-get", "");
  EXPECT_EQ(examine(true), expectation_failed) << out;
  EXPECT_EQ(said, "skein: gnuplot: apt-get ended with status 7\n");
  patient.remove("/bin/apt-get");
  patient.remove("/bin/sudo");
  EXPECT_EQ(examine(true), expectation_failed) << out;
  EXPECT_THAT(said, AnyOf("skein: gnuplot: apt-get cannot be started: No such file or directory\n",
                          "skein: gnuplot: sudo cannot be started: No such file or directory\n"));
}

TEST_F(DoctorFix, AMachineIsFixedBesideAFileWithMistakes) {
  patient.remove("/gnuplot");
  EXPECT_EQ(examine(true, "nowhere.toml"), wrong_input);
  EXPECT_THAT(said, HasSubstr("nowhere.toml: cannot be read"));
  EXPECT_EQ(executed(), "apt-get\tinstall\t-y\tgnuplot-nox\n");
  EXPECT_TRUE(exists("gnuplot"));
}

}  // namespace
}  // namespace skein::app
