// The program as a user's script sees it: exit statuses, what goes to stdout and stderr, files that appear, signals.
#include <fcntl.h>
#include <gtest/gtest.h>
#include <poll.h>
#include <pty.h>
#include <signal.h>
#include <spawn.h>
#include <sys/ioctl.h>
#include <sys/stat.h>
#include <sys/wait.h>
#include <termios.h>
#include <unistd.h>

#include <cctype>
#include <chrono>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <functional>
#include <regex>
#include <sstream>
#include <string>
#include <thread>
#include <vector>

#include "tests/app/folder.h"
#include "tests/eventually.h"
#include "tests/files.h"
#include "tests/places.h"
#include "tests/stall.h"

extern char** environ;

namespace {

const std::string experiments = skein::test::in_source("resources/experiments/");

using skein::test::Folder;
using skein::test::read_file;

/// The program with these words, its output in files.
class Program {
 public:
  explicit Program(const std::vector<std::string>& words, const char* out = nullptr,
                   const std::string& program = skein::test::program()) {
    std::vector<std::string> all{program};
    all.insert(all.end(), words.begin(), words.end());
    std::vector<char*> arguments;
    arguments.reserve(all.size() + 1);
    for (std::string& word : all) arguments.push_back(word.data());
    arguments.push_back(nullptr);
    posix_spawn_file_actions_t actions;
    posix_spawn_file_actions_init(&actions);
    posix_spawn_file_actions_addopen(&actions, 1, out ? out : (folder_ / "out").c_str(), O_CREAT | O_WRONLY, 0600);
    posix_spawn_file_actions_addopen(&actions, 2, (folder_ / "err").c_str(), O_CREAT | O_WRONLY, 0600);
    EXPECT_EQ(posix_spawn(&pid_, all[0].c_str(), &actions, nullptr, arguments.data(), environ), 0);
    posix_spawn_file_actions_destroy(&actions);
  }
  void send(int signal) const { ::kill(pid_, signal); }
  int wait() {
    int status = 0;
    ::waitpid(pid_, &status, 0);
    return WIFEXITED(status) ? WEXITSTATUS(status) : 128 + WTERMSIG(status);
  }
  std::string out() const { return read_file(folder_ / "out"); }
  std::string err() const { return read_file(folder_ / "err"); }

 private:
  Folder folder_;
  pid_t pid_ = 0;
};

struct Result {
  int status;
  std::string out, err;
};

Result skein(const std::vector<std::string>& words) {
  Program program(words);
  const int status = program.wait();
  return {status, program.out(), program.err()};
}

bool has(const std::string& text, const std::string& part) {
  return text.find(part) != std::string::npos;
}

TEST(CommandLine, ThePapersClaimHolds) {
  Folder folder;
  const Result r = skein({"run", experiments + "platoon.toml", "--csv", folder / "run.csv"});
  EXPECT_EQ(r.status, 0) << r.err;
  EXPECT_TRUE(has(r.out, "perturbation_1_formation_first: true")) << r.out;
  EXPECT_TRUE(has(r.out, "perturbation_2_formation_first: true"));
  EXPECT_TRUE(has(r.out, "perturbation_3_formation_first: true"));
  EXPECT_TRUE(has(r.out, "collisions: 0"));
  EXPECT_TRUE(r.err.empty()) << "quiet in a pipe: " << r.err;
  EXPECT_TRUE(has(read_file(folder / "run.csv"),
                  "\nt,tick,k_xx,k_tt,k_yy,V,V_dot,delta_1_2,delta_2_3,delta_3_4,min_distance,"
                  "period,compute_time,event,r1_x,r1_y,r1_theta,r1_x_true,"));
}

TEST(CommandLine, TwoRunsGiveTheSameFile) {
  Folder folder;
  for (const char* name : {"a.csv", "b.csv"})
    ASSERT_EQ(skein({"run", experiments + "platoon.toml", "--set", "simulation.pose_noise=0.001", "--set",
                     "expect.final_error=0.01", "--quiet", "--csv", folder / name})
                  .status,
              0);
  EXPECT_EQ(read_file(folder / "a.csv"), read_file(folder / "b.csv"));
}

// Kept runs are verified on other machines. With its own functions the C library computes differently on a processor
// without fused multiply-add: four of these six records then differed in their last digits.
TEST(CommandLine, AProcessorWithOtherInstructionsGivesTheSameFile) {
  Folder folder;
  for (const char* experiment : {"platoon", "crowd", "kidnap", "lemniscate", "obstacles", "parking"}) {
    const std::vector<std::string> words{"run", experiments + experiment + ".toml", "--duration", "20", "--quiet"};
    const auto run = [&](const std::string& name) {
      std::vector<std::string> all = words;
      all.insert(all.end(), {"--csv", folder / name, "--force"});
      (void)skein(all);
      return read_file(folder / name);
    };
    const std::string here = run("here.csv");
    ::setenv("GLIBC_TUNABLES", "glibc.cpu.hwcaps=-FMA,-FMA4,-AVX2,-FMA_Usable,-AVX2_Usable", 1);
    const std::string there = run("there.csv");
    ::unsetenv("GLIBC_TUNABLES");
    EXPECT_GT(here.size(), 10'000U) << experiment;
    EXPECT_TRUE(here == there) << experiment;
  }
}

TEST(CommandLine, AnExpectationThatFailsSaysByHowMuch) {
  const Result r = skein({"run", experiments + "platoon.toml", "--set", "expect.final_error=1e-9", "--quiet"});
  EXPECT_EQ(r.status, 1);
  EXPECT_TRUE(has(r.err, "final_error")) << r.err;
  EXPECT_TRUE(r.out.empty());
}

/// The number behind "key: " of a summary.
double value(const std::string& summary, const std::string& key) {
  const std::size_t at = summary.find("\n" + key + ": ");
  EXPECT_NE(at, std::string::npos) << key;
  return at == std::string::npos ? -1.0 : std::stod(summary.substr(at + key.size() + 3));
}

TEST(CommandLine, CouplingsTradeTrackingForFormation) {
  // The comparison that makes the claim worth something: the same kicks with all couplings zero. With couplings the
  // others leave their references to restore the formation, the farther the more the kick was along the path, and
  // tracking settles later. After a kick across the path the distances are back earlier.
  const Result coupled = skein({"run", experiments + "platoon.toml"});
  const Result uncoupled = skein({"run", experiments + "uncoupled.toml"});
  EXPECT_EQ(coupled.status, 0) << coupled.err;
  EXPECT_EQ(uncoupled.status, 0) << uncoupled.err;
  EXPECT_LT(value(coupled.out, "perturbation_1_formation_1cm"), value(uncoupled.out, "perturbation_1_formation_1cm"));
  double before = 0.004;  // [m]
  for (const std::string perturbation : {"perturbation_1", "perturbation_2", "perturbation_3"}) {
    EXPECT_GT(value(coupled.out, perturbation + "_tracking_1cm"), value(uncoupled.out, perturbation + "_tracking_1cm"));
    const double away = value(coupled.out, perturbation + "_others_away");
    EXPECT_GT(away, before) << "three different kicks";
    EXPECT_LT(value(uncoupled.out, perturbation + "_others_away"), 5e-4);
    before = away + 0.004;
  }
}

TEST(CommandLine, TheExamplesDoWhatTheyExpect) {
  for (const char* name : {"lemniscate", "diamond-to-line", "corner-blends", "unequal-speeds"}) {
    const Result r = skein({"run", experiments + name + ".toml"});
    EXPECT_EQ(r.status, 0) << name << ": " << r.err;
    EXPECT_EQ(value(r.out, "collisions"), 0.0) << name;
    const Result certificate = skein({"check", experiments + name + ".toml"});
    EXPECT_EQ(certificate.status, 0) << name << ": " << certificate.err;
    EXPECT_TRUE(has(certificate.out, "conditions_18: hold")) << name << certificate.out;
    EXPECT_TRUE(has(certificate.out, "theorem_1: case 1, v_ref is nonzero")) << name << certificate.out;
  }
}

TEST(CommandLine, RobotsOfThreeMakersDriveTogetherEachInItsOwnProtocol) {
  Folder folder;
  const std::vector<std::string> words{"run", experiments + "mixed.toml", "--set", "duration=30"};
  const Result direct = skein(words);
  EXPECT_EQ(direct.status, 0) << direct.err;
  EXPECT_TRUE(has(direct.out, "\ncollisions: 0\n")) << direct.out;
  // The same behind emulated robots: a Khepera's lines, an e-puck's bytes, frames of the open protocol.
  std::vector<std::string> linked = words;
  linked.insert(linked.end(), {"--set", "robot_defaults.link=loopback", "--csv", folder / "run.csv"});
  const Result behind = skein(linked);
  EXPECT_EQ(behind.status, 0) << behind.err;
  EXPECT_TRUE(has(behind.out, "\ncollisions: 0\n")) << behind.out;
  EXPECT_TRUE(has(behind.out, "\nperturbation_1_formation_first: true\n")) << behind.out;
}

TEST(CommandLine, AnExperimentIsRehearsedWithoutItsHardware) {
  const Folder folder;
  std::filesystem::copy_file(skein::test::in_source("resources/cameras/overhead.toml"), folder / "cal.toml");
  std::ofstream(folder / "lab.toml")
      << "name = \"lab\"\nduration = 2\n[[robot]]\ntag = 4\nlink = \"serial:/dev/nowhere\"\n"
         "[camera]\nsource = \"v4l2:/dev/nowhere\"\ncalibration = \"cal.toml\"\n"
         "[failure]\nlink_bridge = 10.0\n";
  EXPECT_EQ(skein({"run", folder / "lab.toml"}).status, 3) << "the control: there is no such hardware";
  const auto rehearsed = skein({"run", folder / "lab.toml", "--rehearse", "--csv", folder / "run.csv"});
  EXPECT_EQ(rehearsed.status, 0) << rehearsed.err;
  EXPECT_NE(read_file(folder / "run.csv").find("lab (rehearsal)"), std::string::npos);
  EXPECT_EQ(skein({"replay", folder / "run.csv"}).status, 0);
}

TEST(CommandLine, ParkedRobotsAreCase2OfTheTheorem) {
  const Result r = skein({"run", experiments + "parking.toml"});
  EXPECT_EQ(r.status, 0) << r.err;
  EXPECT_GT(value(r.out, "delay_margin"), value(r.out, "loop_delay")) << r.out;
  const Result certificate = skein({"check", experiments + "parking.toml"});
  EXPECT_EQ(certificate.status, 0) << certificate.err;
  EXPECT_TRUE(has(certificate.out, "theorem_1: case 2 from t = ")) << certificate.out;
  EXPECT_TRUE(has(certificate.out, "delay_margin: 0.")) << certificate.out;
}

TEST(CommandLine, BadInputIsRefusedWithItsPlace) {
  Folder folder;
  std::ofstream(folder / "bad.toml") << "name = \"bad\"\n[controller]\nv_max = -1\nwhatever = 3\n";
  for (const char* command : {"run", "check"}) {
    const Result r = skein({command, folder / "bad.toml"});
    EXPECT_EQ(r.status, 2);
    EXPECT_TRUE(has(r.err, "bad.toml:3:")) << r.err;
    EXPECT_TRUE(has(r.err, "bad.toml:4:")) << r.err;
    EXPECT_TRUE(has(r.err, "v_max"));
  }
  EXPECT_EQ(skein({"run", folder / "missing.toml"}).status, 2);
  EXPECT_EQ(skein({"run"}).status, 2);
  EXPECT_EQ(skein({"run", experiments + "platoon.toml", "--speed", "warp"}).status, 2);
  EXPECT_EQ(skein({"fly"}).status, 2);
  EXPECT_EQ(skein({"run", experiments + "platoon.toml", "--csv", "/nowhere/run.csv"}).status, 2);
  EXPECT_EQ(skein({"track", "images:/nowhere"}).status, 3);
}

TEST(CommandLine, ACameraIsExaminedAndItsTableCanBePasted) {
  Folder folder;
  const Result well = skein({"camera", "doctor", "synthetic", "--seconds", "1"});
  EXPECT_EQ(well.status, 0) << well.out << well.err;
  EXPECT_TRUE(has(well.out, "\nwell  frame rate: 25.00 frames/s of 25 frames, 25 wanted\n")) << well.out;
  EXPECT_FALSE(has(well.out, "ILL")) << well.out;
  const std::size_t table = well.out.find("\n[camera]\n");
  ASSERT_NE(table, std::string::npos) << well.out;
  std::ofstream(folder / "pasted.toml") << well.out.substr(table) << "\n[[robot]]\ntag = 1\n";
  const Result checked = skein({"check", folder / "pasted.toml"});
  EXPECT_FALSE(has(checked.err, "camera")) << checked.err;

  // A film of 10 frames/s is too slow for a run of 25.
  ASSERT_EQ(skein({"run", experiments + "platoon-loopback.toml", "--set", "duration=1", "--set", "perturb=[]", "--set",
                   "expect={}", "--set", "rate=10", "--quiet", "--video", folder / "run.mkv"})
                .status,
            0);
  const Result slow = skein({"camera", "doctor", "video:" + (folder / "run.mkv")});
  EXPECT_EQ(slow.status, 1) << slow.out << slow.err;
  EXPECT_TRUE(has(slow.out, "ILL   frame rate: 10.00 frames/s")) << slow.out;
  EXPECT_EQ(skein({"camera", "doctor", "film.mkv"}).status, 2);
}

TEST(CommandLine, ADoctorFixesWhatItCanAndSaysTheRest) {
  // Instead of every command that it might start on this machine there is one that makes gnuplot.
  Folder folder;
  for (const char* name :
       {"sudo", "adduser", "addgroup", "sysctl", "rfkill", "systemctl", "busctl", "udevadm", "sh", "apt-get"}) {
    std::ofstream(folder / name) << "#!/bin/sh\necho \"${0##*/} $*\"\ncase \"$*\" in\n*gnuplot-nox) : > '"
                                 << folder / "gnuplot"
                                 << "'; /bin/chmod +x '" << folder / "gnuplot"
                                 << "' ;;\nesac\n";
    ::chmod((folder / name).c_str(), 0700);
  }
  std::ofstream(folder / "lab.toml") << "[camera]\nsource = \"v4l2:/dev/nowhere\"\ncalibration = "
                                        "\"cal.toml\"\n[[robot]]\ntag = 1\nlink = \"serial:/dev/nowhere\"\n";
  const char* const inherited = std::getenv("PATH");
  ASSERT_NE(inherited, nullptr);
  const std::string path = inherited;
  ::setenv("PATH", folder.path.c_str(), 1);
  const std::vector<std::string> words{"doctor", folder / "lab.toml", "--seconds", "0", "--fix"};
  const Result first = skein(words), second = skein(words);
  ::setenv("PATH", path.c_str(), 1);
  EXPECT_EQ(first.status, 1) << first.out << first.err;
  EXPECT_TRUE(has(first.out, "\nnote  gnuplot: is missing")) << first.out;
  EXPECT_TRUE(std::regex_search(
      first.out,
      std::regex("\nfix   gnuplot: apt-get install -y gnuplot-nox\n(sudo )?apt-get install -y gnuplot-nox\n")))
      << "said before it is done: " << first.out;
  EXPECT_EQ(first.err, "");
  EXPECT_EQ(second.status, 1) << second.out << second.err;
  EXPECT_TRUE(has(second.out, "\nwell  gnuplot: ")) << second.out;
  EXPECT_FALSE(has(second.out, "\nfix   gnuplot")) << second.out;
  for (const Result& r : {first, second})
    EXPECT_TRUE(has(r.out, "\nby hand  /dev/nowhere: plug it in, or correct its link in the file\n")) << r.out;
}

TEST(CommandLine, TheTrackerOfARunFollowsItsFilm) {
  Folder folder;
  ASSERT_EQ(skein({"run", experiments + "platoon-loopback.toml", "--set", "duration=1", "--set", "perturb=[]", "--set",
                   "expect={}", "--quiet", "--video", folder / "run.mkv"})
                .status,
            0);
  const Result r = skein({"track", "video:" + (folder / "run.mkv"), "--tracker", "--csv", folder / "tags.csv"});
  EXPECT_EQ(r.status, 0) << r.err;
  EXPECT_TRUE(has(r.out, "\nfollowed: 1 2 3 4\n")) << r.out;
  EXPECT_EQ(value(r.out, "poses"), 4 * 26) << r.out;
  EXPECT_EQ(value(r.out, "rejected"), 0) << r.out;
  EXPECT_TRUE(has(r.out, "\n  grey to poses ")) << r.out;
  EXPECT_EQ(r.err, "");
  const Result other =
      skein({"track", "video:" + (folder / "run.mkv"), "--tracker", "--tags", "1,9", "--csv", folder / "tags.csv"});
  EXPECT_EQ(other.err, "skein: no tag 9 is in the picture\n");
  EXPECT_EQ(value(other.out, "poses"), 26) << other.out;
}

TEST(CommandLine, WhatIsAskedOfACameraIsAskedOfACamera) {
  const auto refusal = [](const std::vector<std::string>& words) {
    const Result r = skein(words);
    EXPECT_EQ(r.status, 2) << r.err;
    return r.err;
  };
  EXPECT_EQ(refusal({"track", "film.mkv"}),
            "skein: source \"film.mkv\"; allowed: images:DIR, video:FILE, v4l2:DEVICE, aravis:CAMERA (such as "
            "v4l2:/dev/video0)\n");
  EXPECT_EQ(refusal({"track", "v4l2:/dev/nowhere", "--tracker"}),
            "skein: --tracker places tags on the floor: give the camera's calibration with --camera CAL.TOML\n");
  EXPECT_EQ(refusal({"track", "v4l2:/dev/nowhere", "--tracker", "--tags", "4-587"}),
            "skein: --tags 4-587; allowed: tags of the family 36h11, 0 to 586, such as 1-4,7\n");
  EXPECT_EQ(refusal({"track", "images:.", "--set", "gain=3"}),
            "skein: --set: images:. is not a camera; allowed with --set: v4l2:DEVICE, aravis:CAMERA\n");
  EXPECT_EQ(refusal({"calibrate", "intrinsics", "images:.", "--out", "c.toml", "--size", "640x480"}),
            "skein: --size: images:. is not a camera; allowed with --size: v4l2:DEVICE, aravis:CAMERA\n");
  EXPECT_EQ(refusal({"calibrate", "intrinsics", "v4l2:/dev/nowhere", "--out", "c.toml", "--size", "640"}),
            "skein: --size 640; allowed: WIDTHxHEIGHT, such as 1280x960\n");
  EXPECT_EQ(refusal({"track", "v4l2:/dev/nowhere", "--set", "exposure"}),
            "skein: --set \"exposure\"; allowed: name=number, such as exposure=0.005\n");
  EXPECT_EQ(refusal({"camera", "list", "images:."}),
            "skein: images:. is not a camera; allowed: v4l2:DEVICE, aravis:CAMERA\n");
  EXPECT_EQ(refusal({"camera", "list", "webcam:0"}),
            "skein: webcam:0 is not a camera; allowed: v4l2:DEVICE, aravis:CAMERA\n");
  for (const char* address : {"/dev/nowhere", "v4l2:/dev/nowhere"}) {
    const Result gone = skein({"camera", "list", address});
    EXPECT_EQ(gone.status, 3);
    EXPECT_EQ(gone.err, "skein: /dev/nowhere: cannot be opened (No such file or directory)\n");
  }
  const Result missing = skein(
      {"calibrate", "intrinsics", "v4l2:/dev/nowhere", "--out", "c.toml", "--size", "640x480", "--set", "focus=3"});
  EXPECT_EQ(missing.status, 3) << missing.err;
  EXPECT_TRUE(has(missing.err, "/dev/nowhere: cannot be opened")) << missing.err;
}

TEST(CommandLine, ARobotThatIsNotThereIsStatusThree) {
  const Result r = skein({"run", experiments + "platoon.toml", "--set", "robot.4.link=serial:/dev/nowhere", "--set",
                          "camera.source=images:/nowhere", "--set", "camera.calibration=../cameras/overhead.toml",
                          "--set", "robot.4.model=epuck2"});
  EXPECT_EQ(r.status, 3) << r.err;
  EXPECT_TRUE(has(r.err, "robot 4")) << r.err;
}

TEST(CommandLine, CheckCertifiesTheGains) {
  const Result r = skein({"check", experiments + "platoon.toml"});
  EXPECT_EQ(r.status, 0) << r.err;
  EXPECT_TRUE(has(r.out, "conditions_18: hold"));
  EXPECT_TRUE(has(r.out, "robot_1_smallest_k_x: 0.026 m/s")) << "v_max - v_ref - 3 k_xx of (36a)";
}

TEST(CommandLine, CheckSaysWhatTheorem1AsksInVain) {
  const Result r = skein({"check", experiments + "lemniscate.toml", "--set", "reference.speed=0"});
  EXPECT_TRUE(has(r.out,
                  "theorem_1: does not apply: v_ref vanishes (0 m/s, robot 1 at t = 0 s), which violates case 1, and "
                  "omega_ref vanishes (0 rad/s, robot 1 at t = 0 s), which violates case 2"))
      << r.out << r.err;
  // The inner robot is the slowest.
  const Result door = skein({"check", experiments + "unequal-speeds.toml"});
  EXPECT_TRUE(has(door.out, "theorem_1: case 1, v_ref is nonzero (smallest: 0.0205 m/s, robot 1 at t = ")) << door.out;
}

TEST(CommandLine, TuneSavesAnExperimentAndWritesOverNone) {
  Folder folder;
  const std::string study = folder / "study.toml";
  std::ofstream(study) << "experiment = \"" << experiments << "platoon.toml\"\nruns = 2\n"
                       << "set = [\"duration=16\", \"perturb=[]\"]\n[hand]\ndistance = [0.05, 0.1]\n[tune]\n"
                       << "objectives = 2\neffort = 100\nlimited_share = 1\ndelay_margin = 0.01\nheld_out = 2\n"
                       << "[tune.search]\n\"controller.c_x\" = [15, 40]\n\"controller.k_y\" = [4, 12]\n";
  const Result r =
      skein({"tune", study, "--candidates", "8", "--csv", folder / "front.csv", "--save", folder / "tuned.toml"});
  EXPECT_EQ(r.status, 0) << r.err;
  EXPECT_TRUE(has(r.out, "candidates: 16\n") && has(r.out, "\n1 ") && has(r.out, "\nverdict: ")) << r.out;
  EXPECT_TRUE(has(read_file(folder / "front.csv"), "\n1,")) << read_file(folder / "front.csv");
  const std::string tuned = read_file(folder / "tuned.toml");
  EXPECT_TRUE(has(tuned, "# The case study of the paper")) << "its comments are kept";
  EXPECT_FALSE(has(tuned, "c_x = 20.0"));
  EXPECT_EQ(skein({"check", folder / "tuned.toml"}).status, 0);

  const Result again = skein({"tune", study, "--save", folder / "tuned.toml"});
  EXPECT_EQ(again.status, 2);
  EXPECT_TRUE(has(again.err, "name a new one")) << again.err;
  EXPECT_EQ(read_file(folder / "tuned.toml"), tuned);
  const Result none =
      skein({"tune", skein::test::in_source("resources/studies/kicks.toml"), "--save", folder / "n.toml"});
  EXPECT_EQ(none.status, 2);
  EXPECT_TRUE(has(none.err, "no table [tune]")) << none.err;
  EXPECT_EQ(read_file(folder / "n.toml"), "") << "nothing is left behind";
}

TEST(CommandLine, ARecordedRunReplaysBitForBit) {
  Folder folder;
  ASSERT_EQ(skein({"run", experiments + "platoon.toml", "--csv", folder / "run.csv", "--quiet", "--set",
                   "simulation.pose_noise=0.002", "--set", "simulation.latency=0.1", "--set", "simulation.dropout=0.1",
                   "--set", "expect.final_error=0.02", "--set", "expect.formation_first=true", "--set",
                   "robot_defaults.model=epuck1"})
                .status,
            0);
  const Result r = skein({"replay", folder / "run.csv"});
  EXPECT_EQ(r.status, 0) << r.err;
  EXPECT_TRUE(has(r.out, "different: 0"));

  // One measured digit changed, and it says where.
  std::string text = read_file(folder / "run.csv");
  const std::size_t row = text.find("\n40,1000,");
  ASSERT_NE(row, std::string::npos);
  const std::size_t end = text.find('\n', row + 1);
  const std::string header = text.substr(text.find("\nt,tick,") + 1);
  std::istringstream names(header.substr(0, header.find('\n')));
  std::size_t column = 0;
  for (std::string name; std::getline(names, name, ',') && name != "r2_y_meas";) ++column;
  std::size_t cell = row + 1;
  for (std::size_t k = 0; k < column; ++k) cell = text.find(',', cell) + 1;
  ASSERT_LT(cell, end);
  text.replace(cell, text.find(',', cell) - cell, "0.3");
  std::ofstream(folder / "changed.csv") << text;
  const Result changed = skein({"replay", folder / "changed.csv"});
  EXPECT_EQ(changed.status, 1);
  EXPECT_TRUE(has(changed.err, "tick 1000")) << changed.err;
}

TEST(CommandLine, ATornRecordIsReadToItsTearAndRepaired) {
  Folder folder;
  const std::string file = folder / "run.csv";
  ASSERT_EQ(skein({"run", experiments + "platoon.toml", "--csv", file, "--quiet", "--set", "duration=2"}).status, 0);
  std::filesystem::resize_file(file, std::filesystem::file_size(file) - 100);
  const Result torn = skein({"replay", file});
  EXPECT_EQ(torn.status, 0) << torn.err;
  EXPECT_TRUE(has(torn.err, "torn")) << torn.err;
  EXPECT_EQ(skein({"replay", "--repair", file}).status, 0);
  const Result whole = skein({"replay", file});
  EXPECT_EQ(whole.status, 0);
  EXPECT_FALSE(has(whole.err, "torn")) << whole.err;
  EXPECT_TRUE(std::filesystem::exists(file + ".torn"));
  EXPECT_EQ(skein({"replay", "--repair", file}).status, 2) << "there is nothing to repair";
}

TEST(CommandLine, ARepairThatWasKilledIsRepeated) {
  Folder folder;
  const std::string file = folder / "run.csv", original = folder / "original.csv";
  ASSERT_EQ(skein({"run", experiments + "platoon.toml", "--csv", file, "--quiet", "--set", "duration=2"}).status, 0);
  std::filesystem::resize_file(file, std::filesystem::file_size(file) - 100);
  std::filesystem::copy_file(file, original);
  const auto put_back = [&] {
    std::filesystem::remove(file);
    std::filesystem::remove(file + ".torn");
    std::filesystem::copy_file(original, file);
  };
  // Killed behind its hard link, or in its copy where the disk knows no links.
  const std::vector<std::function<void()>> kills{
      [&] { std::filesystem::create_hard_link(file, file + ".torn"); },
      [&] {
        std::filesystem::copy_file(file, file + ".torn");
        std::filesystem::resize_file(file + ".torn", 5000);
      },
  };
  for (const auto& kill : kills) {
    put_back();
    kill();
    const Result repaired = skein({"replay", "--repair", file});
    EXPECT_EQ(repaired.status, 0) << repaired.err;
    EXPECT_EQ(read_file(file + ".torn"), read_file(original));
    EXPECT_LT(read_file(file).size(), read_file(original).size());
    EXPECT_FALSE(has(skein({"replay", file}).err, "torn"));
  }
  put_back();
  std::ofstream(file + ".torn") << "of another run";
  const Result refused = skein({"replay", "--repair", file});
  EXPECT_EQ(refused.status, 2);
  EXPECT_TRUE(has(refused.err, "move it away")) << refused.err;
  EXPECT_EQ(read_file(file + ".torn"), "of another run");
  EXPECT_EQ(read_file(file), read_file(original));
}

TEST(CommandLine, TheTornRecordOfAKeptRunIsReadButNotRepaired) {
  Folder folder;
  ASSERT_EQ(skein({"run", experiments + "platoon.toml", "--keep", "--runs-dir", folder / "runs", "--quiet", "--set",
                   "duration=2"})
                .status,
            0);
  const std::filesystem::path run = *std::filesystem::directory_iterator(folder / "runs");
  const std::string file = run / "run.csv";
  std::filesystem::resize_file(file, std::filesystem::file_size(file) - 100);
  const std::string torn = read_file(file);
  const Result refused = skein({"replay", "--repair", file});
  EXPECT_EQ(refused.status, 2);
  EXPECT_TRUE(has(refused.err, "is the record of a kept run")) << refused.err;
  EXPECT_EQ(read_file(file), torn) << "run.json may have its hash";
  EXPECT_EQ(skein({"replay", file}).status, 0);
  std::filesystem::remove(run / "run.json");
  EXPECT_EQ(skein({"replay", "--repair", file}).status, 0) << "the control";
}

TEST(CommandLine, NoRunIsOverwritten) {
  Folder folder;
  const std::vector<std::string> words{
      "run", experiments + "platoon.toml", "--csv", folder / "run.csv", "--quiet", "--set", "duration=1"};
  ASSERT_EQ(skein(words).status, 0);
  const Result refused = skein(words);
  EXPECT_EQ(refused.status, 2);
  EXPECT_TRUE(has(refused.err, "run-2.csv")) << refused.err;
  std::vector<std::string> forced = words;
  forced.push_back("--force");
  EXPECT_EQ(skein(forced).status, 0);
  const std::string copy = folder / "copy.toml";
  std::filesystem::copy_file(experiments + "platoon.toml", copy);
  EXPECT_EQ(skein({"run", copy, "--csv", copy, "--force", "--set", "duration=1"}).status, 2) << "the experiment itself";
  EXPECT_EQ(read_file(copy), read_file(experiments + "platoon.toml"));
}

// A device may never end, and a FIFO without a writer is waited for while it is opened.
TEST(CommandLine, ADeviceIsNoFileAndAFifoIsNone) {
  Folder folder;
  const std::string fifo = folder / "fifo.csv";
  ASSERT_EQ(::mkfifo(fifo.c_str(), 0600), 0);
  const std::string trajectory = folder / "trajectory.toml";
  std::ofstream(trajectory) << "duration = 1\n[reference]\nkind = 'independent'\n[[robot]]\ntrajectory = { csv = "
                               "'fifo.csv' }\n";
  std::vector<std::vector<std::string>> uses{{"check", trajectory}, {fifo}, {"identify", fifo}, {"report", fifo}};
  for (const std::string& file : {fifo, std::string("/dev/zero")})
    for (const char* command : {"run", "check", "replay", "sweep"}) uses.push_back({command, file});
  for (const std::vector<std::string>& words : uses) {
    const Result r = skein(words);
    EXPECT_EQ(r.status, 2) << words[0];
    EXPECT_TRUE(has(r.err, "a device or a FIFO, allowed: a file")) << words[0] << ": " << r.err;
  }
}

// A script that keeps the summary of a run must learn that there is none.
TEST(CommandLine, ResultsThatStdoutDoesNotTakeAreAnError) {
  for (const std::vector<std::string>& words :
       {std::vector<std::string>{"check", experiments + "platoon.toml"},
        {"check", "--schema"},
        {"--help"},
        {"--version"},
        {"run", experiments + "platoon.toml", "--set", "duration=1", "--json"}}) {
    Program full(words, "/dev/full"), nowhere(words, "/dev/null");
    EXPECT_EQ(full.wait(), 3) << words[0];
    EXPECT_EQ(full.err(), "skein: stdout: cannot be written: No space left on device\n");
    EXPECT_EQ(nowhere.wait(), 0) << words[0];
  }
  const auto beside = std::filesystem::path(skein::test::program()).replace_filename("skein-bench").string();
  Program benchmarks({"--version"}, "/dev/full", beside);
  EXPECT_EQ(benchmarks.wait(), 3);
}

// A run may not be written to a file named "--set" where the name was forgotten.
TEST(CommandLine, AnOptionWithoutItsValueIsNamed) {
  const Result r = skein({"run", experiments + "platoon.toml", "--csv", "--set", "duration=1"});
  EXPECT_EQ(r.status, 2);
  EXPECT_TRUE(has(r.err, "--csv: FILE is missing before --set")) << r.err;
  EXPECT_FALSE(std::filesystem::exists("--set"));
}

TEST(CommandLine, ATextFileHasALargestSize) {
  Folder folder;
  const std::string file = folder / "large.toml";
  std::ofstream(file) << "name = \"large\"\n";
  EXPECT_EQ(skein({"check", file}).status, 0);
  std::filesystem::resize_file(file, (std::uintmax_t{64} << 20) + 1);  // of holes
  const Result r = skein({"check", file});
  EXPECT_EQ(r.status, 2);
  EXPECT_TRUE(has(r.err, "allowed: at most 67108864")) << r.err;
}

TEST(CommandLine, ASheetThatTheDiskDoesNotTakeIsAnError) {
  Folder folder;
  for (const char* name : {"tags.pdf", "tags.svg"}) {
    const std::string device = folder / ("device-" + std::string(name)), file = folder / name;
    std::filesystem::create_symlink("/dev/full", device);
    const Result refused = skein({"tags", "--out", device, "--force"});
    EXPECT_EQ(refused.status, 2) << name;
    EXPECT_TRUE(has(refused.err, "is a folder, a device or a FIFO, allowed: the name of a file")) << refused.err;
    const Result control = skein({"tags", "--out", file});
    EXPECT_EQ(control.status, 0) << control.err;
    const std::string before = skein::test::read_file(file);
    EXPECT_GT(before.size(), 1000u);
    // The file is on the disk whole, or as it was.
    const std::string command = "ulimit -f 1; exec '" + skein::test::program() + "' tags 1-30 --force --out '" + file +
                                "' > '" + (folder / "said") + "' 2>&1";
    EXPECT_NE(std::system(command.c_str()), 0) << name;
    const std::string said = skein::test::read_file(folder / "said");
    EXPECT_TRUE(has(said, "cannot be written: ")) << said;
    EXPECT_EQ(skein::test::read_file(file), before);
    EXPECT_FALSE(std::filesystem::exists(file + ".new"));
  }
}

TEST(CommandLine, ABoardHasTheSquaresThatWereTyped) {
  Folder folder;
  for (const char* squares : {"4294967308x4294967304", "+12x8", " 12x8", "12x8 ", "12x", "x8", "12"}) {
    const Result r = skein({"tags", "board", "--squares", squares, "--out", folder / "board.svg"});
    EXPECT_EQ(r.status, 2) << squares;
    EXPECT_TRUE(has(r.err, "allowed: columns x rows, such as 12x8")) << r.err;
  }
  EXPECT_EQ(skein({"tags", "board", "--squares", "12x8", "--out", folder / "board.svg"}).status, 0) << "the control";
}

TEST(CommandLine, ARunThatIsKilledLeavesItsRowsOnTheDisk) {
  Folder folder;
  const std::string csv = folder / "run.csv";
  Program program({"run", experiments + "platoon.toml", "--speed", "realtime", "--csv", csv, "--quiet"});
  // A row after 3 s of the run is in the file: those before it were not kept for later.
  const auto rows = [&csv] {
    std::ifstream file(csv);
    int count = 0;
    for (std::string line; std::getline(file, line) && !file.eof();)
      count += !line.empty() && std::isdigit(static_cast<unsigned char>(line[0])) ? 1 : 0;
    return count;
  };
  constexpr int three_seconds = 75;
  EXPECT_TRUE(skein::test::eventually([&] { return rows() >= three_seconds; }, std::chrono::seconds(60)));
  program.send(SIGKILL);
  EXPECT_EQ(program.wait(), 128 + SIGKILL);
  EXPECT_GE(rows(), three_seconds);
  const Result read = skein({"replay", csv});
  EXPECT_EQ(read.status, 0) << read.err;
}

TEST(CommandLine, JsonIsOneObject) {
  const Result r = skein({"run", experiments + "platoon.toml", "--json"});
  EXPECT_EQ(r.status, 0);
  EXPECT_EQ(r.out.front(), '{');
  EXPECT_TRUE(has(r.out, "\"perturbations\""));
}

/// A radio that answers after 0.1 s: with less patience the robot is stopped again and again.
TEST(CommandLine, RobotsAreTestedWithThePatienceThatTheirRadioNeeds) {
  const Folder folder;
  std::ofstream(folder / "slow.toml") << "[[fault]]\nkind = \"latency\"\nmedian = 0.1\n";
  Program emulator({"emulate", "--directory", folder.path, "--faults", folder / "slow.toml"});
  const std::string robot = folder / "robot1";
  ASSERT_TRUE(skein::test::eventually([&] { return std::filesystem::exists(robot); }, std::chrono::seconds(60)));
  const auto tested = [](const std::vector<std::string>& arguments) {
    return skein::test::unless_stalled([&] { return skein(arguments); }, [](const Result& r) { return r.err; });
  };
  const Result impatient = tested({"robots", "test", "serial:" + robot, "--reply-timeout", "0.05"});
  EXPECT_EQ(impatient.status, 3) << impatient.out;
  EXPECT_TRUE(has(impatient.err, "the left wheel's encoder is silent: 0 steps")) << impatient.err;
  const Result patient = tested({"robots", "test", "serial:" + robot});
  EXPECT_EQ(patient.status, 0) << patient.err;
  EXPECT_TRUE(has(patient.out, "faults: 0")) << patient.out;
  emulator.send(SIGTERM);
  emulator.wait();
}

TEST(CommandLine, HelpOfEveryCommand) {
  for (const char* command : {"run", "check", "replay", "track", "emulate", "bench"}) {
    const Result r = skein({command, "--help"});
    EXPECT_EQ(r.status, 0) << command;
    EXPECT_GT(r.out.size(), 80u) << command;
  }
}

TEST(CommandLine, TheVersionNamesTheCommit) {
  const std::string version = skein({"--version"}).out;
  EXPECT_TRUE(std::regex_match(version, std::regex(R"(skein \d+\.\d+\.\d+ \([0-9a-f]{7,40}(\+changes)?\)\n)")))
      << version;
}

TEST(CommandLine, BenchmarksAreAProgramOfTheirOwn) {
  // The names of the libraries that a program links stand in it as they are.
  const std::string beside = skein::test::program() + "-bench";
  EXPECT_FALSE(has(read_file(skein::test::program()), "libbenchmark.so"));
  EXPECT_TRUE(has(read_file(beside), "libbenchmark.so")) << "else the line above proves nothing";
  // What was written for `skein bench` goes on working, options of Google Benchmark as well.
  const Result r = skein({"bench", "tick", "--benchmark_list_tests"});
  EXPECT_EQ(r.status, 0) << r.err;
  EXPECT_TRUE(has(r.out, "tick (n = 4)")) << r.out;
  EXPECT_EQ(skein({"bench", "nothing"}).status, 2);
}

/// What drives nothing and leaves nothing half done ends at once: reading a long run takes minutes.
TEST(CommandLine, ACommandThatOnlyReadsIsEndedBySignals) {
  Folder folder;
  std::filesystem::create_directory(folder / "run");
  std::ofstream(folder / "run/run.json") << R"({"name":")" << std::string(200'000, 'x') << "\"}";
  const std::string fifo = folder / "fifo";
  ASSERT_EQ(::mkfifo(fifo.c_str(), 0600), 0);
  for (const int signal : {SIGINT, SIGTERM}) {
    const int unread = ::open(fifo.c_str(), O_RDWR | O_NONBLOCK | O_CLOEXEC);
    ASSERT_GE(unread, 0);
    Program program({"runs", "show", folder / "run"}, fifo.c_str());
    EXPECT_TRUE(skein::test::eventually(
        [&] {
          int bytes = 0;
          return ::ioctl(unread, FIONREAD, &bytes) == 0 && bytes >= 65536;
        },
        std::chrono::seconds(60)))
        << "it waits for a reader";
    program.send(signal);
    EXPECT_EQ(program.wait(), 128 + signal);
    ::close(unread);
  }
}

class Signal : public testing::TestWithParam<int> {};

TEST_P(Signal, StopsEveryRobotAndSaysSo) {
  Folder folder;
  Program program({"run", experiments + "platoon-loopback.toml", "--speed", "realtime", "--csv", folder / "run.csv"});
  // Robots drive as soon as a row of the run is in the file.
  const auto until = std::chrono::steady_clock::now() + std::chrono::seconds(30);
  while (!std::filesystem::exists(folder / "run.csv") || std::filesystem::file_size(folder / "run.csv") < 8000) {
    ASSERT_LT(std::chrono::steady_clock::now(), until);
    std::this_thread::sleep_for(std::chrono::milliseconds(10));
  }
  program.send(GetParam());
  EXPECT_EQ(program.wait(), 1) << program.err();
  EXPECT_TRUE(has(program.out(), "not_stopped: none")) << program.out();
  EXPECT_TRUE(has(program.err(), "stopped at")) << program.err();
  EXPECT_TRUE(has(read_file(folder / "run.csv"), "stop")) << "the log of the run has it";
}

/// A robot that never answers would be waited for for 15 s.
TEST_P(Signal, EndsAProgramThatIsStillReachingItsRobots) {
  Folder folder;
  int robot = -1, line = -1;
  termios raw{};
  ::cfmakeraw(&raw);
  ASSERT_EQ(::openpty(&robot, &line, nullptr, &raw, nullptr), 0);
  const std::string link = std::string("serial:") + ::ttyname(line);
  std::ofstream(folder / "robots.toml") << "[[robot]]\nname = \"anna\"\nmodel = \"epuck2\"\nlink = \"" << link
                                        << "\"\n";
  for (const std::vector<std::string>& words :
       {std::vector<std::string>{"run", experiments + "platoon.toml", "--set", "robot.4.link=" + link, "--set",
                                 "robot.4.model=epuck2", "--set", "camera.source=images:/nowhere", "--set",
                                 "camera.calibration=../cameras/overhead.toml"},
        {"robots", "test", "anna", "--file", folder / "robots.toml"}}) {
    ::tcflush(robot, TCIOFLUSH);
    Program program(words);
    pollfd asked{robot, POLLIN, 0};
    ASSERT_EQ(::poll(&asked, 1, 60'000), 1) << program.err();
    program.send(GetParam());
    EXPECT_EQ(program.wait(), 3) << program.err();
    EXPECT_TRUE(has(program.err(), "skein: stopped")) << program.err();
  }
  ::close(line);
  ::close(robot);
}

INSTANTIATE_TEST_SUITE_P(CommandLine, Signal, testing::Values(SIGINT, SIGTERM));

}  // namespace
