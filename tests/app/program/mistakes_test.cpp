// Mistakes of a command line and of a study: each is refused before any work is done, with a sentence.
#include <arpa/inet.h>
#include <gmock/gmock.h>
#include <signal.h>
#include <sys/socket.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <map>
#include <regex>
#include <sstream>
#include <string>

#include "tests/app/folder.h"
#include "tests/files.h"
#include "tests/places.h"

namespace {

using ::testing::AllOf;
using ::testing::AnyOf;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using ::testing::Not;

/// A shell in a folder of its own, with `$skein`, and the paper's experiment as e.toml.
class Mistakes : public ::testing::Test {
 public:
  Mistakes() {
    std::filesystem::copy_file(skein::test::in_source("resources/experiments/platoon.toml"), folder_ / "e.toml");
  }

  std::string read(const std::string& name) const { return skein::test::read_file(folder_ / name); }
  void write(const std::string& name, const std::string& text) const { std::ofstream(folder_ / name) << text; }
  bool exists(const std::string& name) const { return std::filesystem::exists(folder_ / name); }
  void study(const std::string& more) const {
    write("s.toml", "experiment = \"e.toml\"\nset = [\"duration=4\", \"perturb=[]\"]\nruns = 2\n" + more);
  }
  /// A kept run without anything but its story.
  void keep_run(const std::string& id, const std::string& began, int collisions) const {
    std::filesystem::create_directories(folder_ / "runs" / id);
    write("runs/" + id + "/run.json", R"({"id":")" + id + R"(","state":"finished","began":")" + began +
                                          R"(","summary":{"collisions":)" + std::to_string(collisions) + "}}");
  }
  /// Their exit status; what they say is in `said` (stderr) and `out`.
  int shell(const std::string& lines) {
    const std::string all = "exec > out 2> said; skein='" + skein::test::program() + "'; " + lines;
    const int status = std::system(("cd '" + folder_.string() + "' && { " + all + "\n}").c_str());
    said = read("said"), out = read("out");
    return WIFEXITED(status) ? WEXITSTATUS(status) : 128;
  }

  std::string said, out;
  const skein::test::Folder own_folder_;
  const std::filesystem::path folder_ = own_folder_.path;
};

TEST_F(Mistakes, RunsAreRemovedWhereNameAndConditionHold) {
  keep_run("a", "2026-11-01T12:00:00.000+01:00", 0);
  keep_run("b", "2026-11-02T12:00:00.000+01:00", 3);
  keep_run("c", "2026-11-03T12:00:00.000+01:00", 3);
  EXPECT_EQ(shell("$skein runs remove a b --where 'collisions > 0' --runs-dir runs --yes"), 0) << said;
  EXPECT_TRUE(exists("runs/a")) << "named, but the condition does not hold";
  EXPECT_EQ(shell("$skein runs remove a --where 'collisions > 0' --runs-dir runs"), 0) << said;
  EXPECT_EQ(out, "0 runs, 0.0 MB: there is none to remove\n");
  EXPECT_FALSE(exists("runs/b"));
  EXPECT_TRUE(exists("runs/c")) << "the condition holds, but it is not named";
  EXPECT_EQ(shell("mkdir other && cp -r runs/c other/c && $skein runs remove other/c --where 'collisions > 0' "
                  "--runs-dir runs --yes"),
            2);
  EXPECT_THAT(said, HasSubstr("other/c: is not in "));
  EXPECT_EQ(shell("$skein runs remove --where 'collisions > 0' --runs-dir runs --yes"), 0) << said;
  EXPECT_FALSE(exists("runs/c"));
}

TEST_F(Mistakes, AStudysKeysAreCheckedBeforeItsFirstRun) {
  study("control = [\"controller.k_z=3\"]\n[hand]\nt = 1\n");
  EXPECT_EQ(shell("$skein sweep s.toml"), 2);
  EXPECT_THAT(said, AllOf(HasSubstr("s.toml:4:"), HasSubstr("control: \"controller.k_z=3\""), HasSubstr("k_y")));
  EXPECT_THAT(out, IsEmpty());

  study("[hand]\nt = 1\n[compare]\nloose = [\"controller.k_y=-3\"]\n");
  EXPECT_EQ(shell("$skein sweep s.toml"), 2);
  EXPECT_THAT(said, AllOf(HasSubstr("s.toml:7:"), HasSubstr("compare.loose: \"controller.k_y=-3\""),
                          HasSubstr("allowed: a number")));

  study("[vary]\n\"controller.k_q\" = [1, 2]\n");
  EXPECT_EQ(shell("$skein sweep s.toml"), 2);
  EXPECT_THAT(said, AllOf(HasSubstr("s.toml:5:"), HasSubstr("vary: \"controller.k_q=1\"")));

  study("[vary]\n\"controller.k_y\" = [1, 1e9]\n");
  EXPECT_EQ(shell("$skein sweep s.toml"), 2) << "its upper end is not allowed";
  EXPECT_THAT(said, AllOf(HasSubstr("s.toml:5:"), HasSubstr("controller.k_y: found 1000000000")));

  study("[vary]\n\"controller.k_y\" = [5, 6]\n");
  EXPECT_EQ(shell("$skein sweep s.toml --set controller.k_z=3"), 2);
  EXPECT_THAT(said, HasSubstr("--set controller.k_z=3: controller.k_z: unknown key"));
  EXPECT_EQ(shell("$skein sweep s.toml"), 0) << said;
}

TEST_F(Mistakes, AHandNeedsItsTimeAndItsRobots) {
  study("[hand]\nt = 500\n");
  EXPECT_EQ(shell("$skein sweep s.toml"), 2);
  EXPECT_THAT(said, HasSubstr("s.toml:5:5: hand.t: found 500, allowed: a time before the experiment's end at 4 s"));
  study("[hand]\nt = 1\nrobots = 9\n");
  EXPECT_EQ(shell("$skein sweep s.toml"), 2);
  EXPECT_THAT(said, HasSubstr("s.toml:6:10: hand.robots: found 9, allowed: a whole number from 1 to 4"));
  study("[hand]\nt = 1\nrobots = 4\ndistance = [0.05, 0.06]\n");
  EXPECT_EQ(shell("$skein sweep s.toml"), 0) << said;
}

TEST_F(Mistakes, SeedsAreWholeNumbersThatAllRunsHave) {
  study("[hand]\nt = 1\n");
  for (const char* option : {"--seed", "--only"}) {
    EXPECT_EQ(shell(std::string("$skein sweep s.toml ") + option + " -1"), 2) << out;
    EXPECT_THAT(said,
                HasSubstr(std::string(option) + ": found -1, allowed: a whole number from 0 to 9223372036854775807"));
  }
  EXPECT_EQ(shell("$skein sweep s.toml --seed 9223372036854775806 --runs 4"), 2);
  EXPECT_THAT(said, HasSubstr("seed: found 9223372036854775806, allowed: at most 9223372036854775804"));
  EXPECT_EQ(shell("$skein sweep s.toml --seed 9223372036854775806"), 0) << said;
  EXPECT_EQ(shell("$skein sweep s.toml --runs 1e3"), 2);
  EXPECT_THAT(said, HasSubstr("--runs: found 1e3, allowed: a whole number from 1 to 10000000"));
}

TEST_F(Mistakes, OneRunIsDrawnToo) {
  study("[hand]\nt = 1\n");
  EXPECT_EQ(shell("$skein sweep s.toml --only 5 --report rq --csv rq.csv"), 0) << said;
  EXPECT_THAT(said, IsEmpty());
  EXPECT_TRUE(exists("rq/distances.pdf"));
  EXPECT_THAT(read("rq.csv"), HasSubstr("\nstudy,5,"));
}

TEST_F(Mistakes, ResultsAreWrittenAlsoWhereFiguresCannotBeDrawn) {
  study("[hand]\nt = 1\n");
  EXPECT_EQ(shell("mkdir bin; printf '#!/bin/sh\\ncase $1 in *.gp) exit 1;; esac\\necho gnuplot 5.4\\n' > bin/gnuplot; "
                  "chmod +x bin/gnuplot; "
                  "PATH=$PWD/bin:$PATH $skein sweep s.toml --report rq --csv rq.csv"),
            2);
  EXPECT_THAT(read("rq.csv"), HasSubstr("\nstudy,2,"));
}

TEST_F(Mistakes, MissingPartsAreNamedWithTheCommandThatMakesThem) {
  study("[hand]\nt = 1\n");
  const std::string options = " --runs 3 --seed 7 --set 'name=\"a b\"'";
  EXPECT_EQ(shell("$skein sweep s.toml --part 1/2 --into p --quiet" + options), 0) << said;
  EXPECT_EQ(shell("$skein sweep s.toml --merge p" + options), 1);
  const std::string command = "skein sweep 's.toml' --runs 3 --seed 7 --set 'name=\"a b\"' --part 2/2 --into 'p'";
  EXPECT_THAT(said, HasSubstr(command + "\n"));
  EXPECT_EQ(shell("skein() { $skein \"$@\"; }; " + command + " --quiet && $skein sweep s.toml --merge p" + options), 0)
      << said;
}

TEST_F(Mistakes, AnEmptyTextIsNoValue) {
  study("[hand]\nt = 1\n");
  for (const char* words : {"run e.toml --csv ''", "run e.toml --report ''", "run e.toml --publish ''", "run ''",
                            "sweep s.toml --part '' --into q", "runs show ''", "run e.toml --seed ''"}) {
    EXPECT_EQ(shell(std::string("$skein ") + words), 2) << words;
    EXPECT_THAT(said, HasSubstr("found an empty text, allowed: a value")) << words;
    EXPECT_THAT(out, IsEmpty()) << words;
  }
}

TEST_F(Mistakes, WhatIsNotANumberIsNoNumberOfSeconds) {
  for (const char* words : {"doctor --seconds nan", "doctor --seconds -1", "robots ping x --minutes nan",
                            "robots test x --reply-timeout nan", "camera latency e.toml --seconds inf"}) {
    EXPECT_EQ(shell(std::string("$skein ") + words), 2) << words;
    EXPECT_THAT(said, HasSubstr("allowed: a number from ")) << words;
  }
}

TEST_F(Mistakes, ListsOfRunsSayWhatIsWrong) {
  keep_run("a", "2026-11-01T12:00:00.000+01:00", 0);
  for (const char* number : {"-1", "0"}) {
    EXPECT_EQ(shell(std::string("$skein runs list --runs-dir runs --newest ") + number), 2) << number;
    EXPECT_THAT(said, HasSubstr("allowed: a whole number from 1"));
  }
  EXPECT_EQ(shell("$skein runs list --runs-dir runs --show nosuch"), 2);
  EXPECT_THAT(said, HasSubstr("nosuch: no run has such a key"));
  EXPECT_EQ(shell("$skein runs list --runs-dir runs --show collisions --newest 1"), 0) << said;
}

TEST_F(Mistakes, AFileOfAnotherKindIsNamed) {
  EXPECT_EQ(
      shell("$skein run e.toml --set duration=1 --csv run.csv --quiet; mkdir folder; head -c 500 $skein > binary"), 0);
  for (const char* command : {"run", "check", "doctor --seconds 0", "sweep", "tune", "camera latency"}) {
    EXPECT_EQ(shell(std::string("$skein ") + command + " run.csv"), 2) << command;
    EXPECT_THAT(said, HasSubstr("run.csv:1:1: found a recorded run (CSV), allowed: a text in TOML")) << command;
    EXPECT_EQ(shell(std::string("$skein ") + command + " binary"), 2) << command;
    EXPECT_THAT(said, HasSubstr("binary: found bytes that are no text, allowed: a text in TOML")) << command;
    EXPECT_EQ(shell(std::string("$skein ") + command + " folder"), 2) << command;
    EXPECT_THAT(said, HasSubstr("folder: cannot be read: it is a folder, allowed: a file")) << command;
  }
  EXPECT_EQ(shell("$skein replay nowhere.csv"), 2);
  EXPECT_THAT(said, HasSubstr("nowhere.csv: cannot be read: No such file or directory"));
}

/// Each kind of TOML file where each other kind is read. Its keys are unknown there, all of them.
TEST_F(Mistakes, AFileThatIsWellButOfAnotherKindIsSaidToBe) {
  study("");
  write("m.toml", "[[tag]]\nid = 1\nposition = [0, 0]\n");
  write("f.toml", "[[fault]]\nkind = \"burst\"\nat = 1\nfor = 1\n");
  write("r.toml", "[[robot]]\nname = \"a\"\nlink = \"serial:/dev/ttyUSB9\"\n");
  for (const char* name : {"c.toml", "camera.toml"})
    write(name, skein::test::read_file(skein::test::in_source("resources/cameras/overhead.toml")));
  const std::map<std::string, std::string> kinds{{"e.toml", "an experiment (`skein run`)"},
                                                 {"s.toml", "a study (`skein sweep`)"},
                                                 {"c.toml", "a calibration (`skein calibrate`)"},
                                                 {"r.toml", "a file of robots (`skein robots`)"},
                                                 {"m.toml", "marks on the floor (`skein calibrate floor`)"},
                                                 {"f.toml", "faults (`skein emulate`)"}};
  const std::map<std::string, std::string> readers{
      {"e.toml", "$skein check "},
      {"s.toml", "$skein sweep "},
      {"c.toml", "$skein track images:. --camera "},
      {"r.toml", "$skein robots list --file "},
      {"m.toml", "$skein calibrate floor images:. --camera camera.toml --marks "},
      {"f.toml", "$skein emulate --faults "}};
  for (const auto& [own, command] : readers)
    for (const auto& [file, kind] : kinds) {
      if (file == own || (own == "e.toml" && file == "r.toml")) continue;  // an experiment may have robots alone
      EXPECT_EQ(shell("timeout 20 " + command + file), 2) << command << file;
      EXPECT_THAT(said, testing::EndsWith(file + ": found " + kind + ", allowed: " + kinds.at(own) + "\n"))
          << command << file;
    }
}

TEST_F(Mistakes, ABareNameThatIsNoFileIsComparedWithWhatThereIs) {
  EXPECT_EQ(shell("$skein run platon"), 2);
  EXPECT_THAT(said, HasSubstr("skein run: experiment: found platon; did you mean platoon? allowed: a file, or one of "
                              "the experiments that come with Skein: antipodal-swap-10, "));
  EXPECT_EQ(shell("$skein sweep crowd"), 2);
  EXPECT_THAT(said, HasSubstr("found crowd; did you mean crowds? allowed: a file, or one of the studies"));
  for (const char* command : {"rnu", "rnu e.toml"}) {
    EXPECT_EQ(shell(std::string("$skein ") + command), 2);
    EXPECT_THAT(said, HasSubstr("skein: experiment: found rnu; did you mean run? allowed: a command (run, check, "));
  }
  EXPECT_EQ(shell("$skein gui e.toml"), 2) << "no command is like it";
  EXPECT_THAT(said, HasSubstr("skein: experiment: found gui, allowed: a command (run, check, "));
  EXPECT_EQ(shell("$skein run platon.toml"), 2) << "a file that is missing, by its ending";
  EXPECT_THAT(said, HasSubstr("platon.toml: cannot be read: No such file or directory"));
}

/// A file with mistakes hides neither those of the next file nor what is wrong with the machine.
TEST_F(Mistakes, ADoctorExaminesTheMachineAllTheSame) {
  EXPECT_EQ(shell("$skein doctor nowhere.toml e.toml nowhere-else.toml --seconds 0"), 2);
  EXPECT_THAT(said, HasSubstr("nowhere.toml: cannot be read"));
  EXPECT_THAT(said, HasSubstr("nowhere-else.toml: cannot be read"));
  EXPECT_THAT(out, HasSubstr("memory lock: "));
}

TEST_F(Mistakes, WhatTheWordsOrTheFileAreWrongAboutIsNoFailureOfADevice) {
  EXPECT_EQ(shell("$skein camera latency e.toml"), 2);
  EXPECT_THAT(said, HasSubstr("allowed: a robot with a link"));
  EXPECT_EQ(shell("$skein run e.toml --video film.mkv"), 2);
  EXPECT_THAT(said, HasSubstr("allowed: an experiment with a camera"));
  EXPECT_EQ(shell("$skein camera doctor --size 3mm"), 2);
  EXPECT_THAT(said, HasSubstr("--size 3mm; allowed: WIDTHxHEIGHT"));
  EXPECT_EQ(shell("$skein camera doctor --rate nan"), 2);
  EXPECT_THAT(said, HasSubstr("--rate: found nan, allowed: a number from 0.1 to 10000"));
  EXPECT_EQ(shell("$skein camera doctor --camera nowhere.toml"), 2);
  EXPECT_THAT(said, HasSubstr("nowhere.toml: cannot be read"));
  EXPECT_EQ(shell("$skein run e.toml --runs-dir runs"), 2);
  EXPECT_THAT(said, HasSubstr("--runs-dir: found without --keep, allowed: with it"));
  EXPECT_EQ(shell("unset DISPLAY WAYLAND_DISPLAY QT_QPA_PLATFORM; $skein e.toml"), 2);
  EXPECT_THAT(said, AnyOf(HasSubstr("no display for the window"), HasSubstr("built without a window")));
}

TEST_F(Mistakes, RunsWithAnotherKickOrPathAreNotSaidToBeTheSame) {
  const std::string run = "$skein run e.toml --quiet --keep --runs-dir runs --duration 1 ";
  EXPECT_EQ(shell(run + "&& " + run +
                  "--set perturb.2.dx=0.05 --set reference.path.width=1.2 --set controller.k_y=10 "
                  "--set 'obstacle=[{x=0.5,y=0.1,radius=0.05}]'; set -- runs/2*; mv $1 a; mv $2 b"),
            0)
      << said;
  EXPECT_EQ(shell("$skein runs compare a b"), 0) << said;
  for (const char* const row :
       {"perturb.2.dx +0.1 +0.05", "reference.path.width +1.3 +1.2", "controller.k_y +11 +10", "obstacle.1"})
    EXPECT_THAT(out, testing::ContainsRegex(row));
  EXPECT_THAT(out, Not(HasSubstr("perturb.1")));
  EXPECT_EQ(shell("$skein runs compare a b --json"), 0);
  EXPECT_THAT(out, HasSubstr("\"perturb.2.dx\": [\n    0.1,\n    0.05\n"));
  EXPECT_EQ(shell("$skein runs compare a a"), 0);
  EXPECT_THAT(out, Not(HasSubstr("perturb")));
  EXPECT_EQ(shell("rm a/experiment.toml; $skein runs compare a b"), 0);
  EXPECT_THAT(said, HasSubstr("only values of run.json are compared"));
}

TEST_F(Mistakes, PicturesOfTagsGoToTheFolderThatIsNamedAndToTheKeptRunsOwn) {
  EXPECT_EQ(
      shell("$skein run e.toml --quiet --keep --runs-dir runs --crops crops --duration 2 "
            "--set camera.source=synthetic --set 'expect={}' "
            "--set 'operator.1={t=0.4, does=\"move r2 x=3 y=3 theta=0\"}'; cmp crops/tag-2.png runs/2*/tag-2.png"),
      0)
      << said;
  EXPECT_THAT(said, HasSubstr("no tag 2 is in the picture (picture: crops/tag-2.png)"));
  EXPECT_EQ(
      shell("$skein runs verify last --runs-dir runs && $skein report last --html --runs-dir runs --out page.html"), 0)
      << said;
  EXPECT_EQ(shell("grep -c 'figcaption>Robot 2: no tag 2 is in the picture' page.html"), 0);
}

TEST_F(Mistakes, KeysOfTablesAreCompleted) {
  for (const auto& [typed, key] : {std::pair{"robot.", "robot.1.tag=\t"},
                                   {"robot.12.t", "robot.12.track=\t"},
                                   {"perturb.2.", "perturb.2.dtheta=\t"},
                                   {"obstacle.1.", "obstacle.1.radius=\t"},
                                   {"robot_defaults.", "robot_defaults.model=\t"},
                                   {"reference.path.", "reference.path.width=\t"},
                                   {"reference.path.", "reference.path.points=\t"},
                                   {"reference.path.shape=", "reference.path.shape=circle\t"}}) {
    EXPECT_EQ(shell(std::string("$skein complete run e.toml --set ") + typed), 0);
    EXPECT_THAT(out, HasSubstr(key)) << typed;
  }
}

TEST_F(Mistakes, AFolderInWhichNoRunCanBeKeptIsNamedAndNotItsRoom) {
  EXPECT_EQ(shell("$skein run e.toml --keep --runs-dir /proc/runs"), 2);
  EXPECT_THAT(said, HasSubstr("/proc/runs"));
  EXPECT_THAT(said, Not(HasSubstr("are free")));
}

TEST_F(Mistakes, GainsAndKeptRunsAreCompleted) {
  keep_run("2026-11-01_a", "2026-11-01T12:00:00.000+01:00", 0);
  EXPECT_EQ(shell("$skein complete run e.toml --set controller.gains.k_"), 0);
  for (const char* const gain : {"controller.gains.k_xx=\t", "controller.gains.k_tt=\t", "controller.gains.k_yy=\t"})
    EXPECT_THAT(out, HasSubstr(gain));
  EXPECT_EQ(shell("$skein complete run e.toml --set controller.c_x"), 0);
  EXPECT_THAT(out, AllOf(HasSubstr("controller.c_x="), HasSubstr("controller.c_xx=")));
  for (const char* const words : {"runs verify 2", "runs show 2", "runs compare last 2", "runs remove 2", "report 2",
                                  "export 2", "identify 2026-11-01_a 2"}) {
    EXPECT_EQ(shell(std::string("export SKEIN_RUNS=$PWD/runs; $skein complete ") + words), 0);
    EXPECT_THAT(out, HasSubstr("2026-11-01_a")) << words;
  }
  EXPECT_EQ(shell("for gain in c_xx c_tt c_yy l_xx l_tt gains.k_xx gains.k_tt gains.k_yy; do "
                  "$skein check e.toml --set controller.$gain=0.0001 || exit; done"),
            0)
      << "each is a key of the file: " << said;
}

/// A terminal obeys what a name contains: it must not clear the screen, hide a line or pretend to be one of the
/// program's.
TEST_F(Mistakes, ALongTextIsCutBetweenLettersAndNotWithinOne) {
  const auto keep = [&](const char* id, const std::string& name) {
    keep_run(id, "2026-11-01T12:00:00.000+01:00", 0);
    write(std::string("runs/") + id + "/run.json", R"({"name":")" + name + "\"}");
  };
  std::string umlauts;
  for (int i = 0; i < 40; ++i) umlauts += "ä";
  keep("a", "x" + umlauts);
  keep("b", "y" + umlauts);
  EXPECT_EQ(shell("$skein runs compare a b --runs-dir runs"), 0) << said;
  EXPECT_THAT(out, AllOf(HasSubstr("xäää"), HasSubstr("ä..."), Not(HasSubstr("\\x"))));
  EXPECT_EQ(shell("$skein runs find 'name = 1 x" + umlauts + "' --runs-dir runs"), 2);
  EXPECT_THAT(said, AllOf(HasSubstr("found \"xäää"), Not(HasSubstr("\\x"))));
  keep("a", umlauts + umlauts + "a");
  keep("b", umlauts + umlauts + "b");
  EXPECT_EQ(shell("$skein runs compare a b --runs-dir runs"), 0) << said;
  EXPECT_THAT(out, AllOf(HasSubstr("name  ...ä"), HasSubstr("äa"), HasSubstr("äb"), Not(HasSubstr("\\x"))));
  for (const char* const before : {"", "x"}) {
    write("runs/b/run.json", std::string("{\"name\": \"") + before + umlauts + umlauts + umlauts);
    EXPECT_EQ(shell("$skein runs show b --runs-dir runs"), 2);
    EXPECT_THAT(said, AllOf(HasSubstr("ä..."), Not(HasSubstr("\\x"))));
  }
}

TEST_F(Mistakes, NoNameIsObeyedByTheTerminal) {
  const std::string in_shell = R"(ill=$(printf '\033[2J\302\2332J\342\200\256\nskein: all is well\377'); )";
  const auto good = [&](const char* where) {
    for (const std::string& text : {said, out}) {
      EXPECT_EQ(text.find('\x1b'), std::string::npos) << where << text;
      EXPECT_EQ(text.find("\u202e"), std::string::npos) << where << text;
      EXPECT_EQ(text.find("\u009b"), std::string::npos) << where << text;
      EXPECT_EQ(text.find('\xff'), std::string::npos) << where << text;
      EXPECT_THAT("\n" + text, Not(HasSubstr("\nskein: all is well"))) << where;
    }
    EXPECT_THAT(said + out, HasSubstr(R"(\u009b2J\u202e)")) << where;
  };
  for (const char* const words : {"run \"$ill\"",
                                  "check e.toml --set \"$ill=1\"",
                                  "doctor --seconds 0 \"$ill\"",
                                  "replay \"$ill.csv\"",
                                  "\"$ill\"",
                                  "runs show \"$ill\" --runs-dir runs",
                                  "robots stop \"$ill\"",
                                  "robots list --file \"$ill\"",
                                  "guard \"$ill\"",
                                  "tags \"$ill\"",
                                  "track \"$ill\"",
                                  "sweep \"$ill\"",
                                  "tune \"$ill\"",
                                  "identify \"$ill\"",
                                  "export \"$ill\" --to csv",
                                  "report \"$ill\" --html",
                                  "runs compare \"$ill\" last --runs-dir runs",
                                  "emulate --listen \"tcp:$ill\"",
                                  "emulate --directory \"/dev/null/$ill\"",
                                  "emulate --faults \"$ill\"",
                                  "robots test \"$ill\"",
                                  "robots ping \"$ill\"",
                                  "camera doctor \"$ill\"",
                                  "calibrate floor images:. --camera \"$ill\"",
                                  "run e.toml --publish \"$ill\"",
                                  "run e.toml --csv \"/dev/null/$ill\""}) {
    EXPECT_NE(shell(in_shell + "$skein " + words), 0) << words;
    good(words);
  }
  const std::string name = R"(name = "\u009b2J\u202e")";
  write("robots.toml", "[[robot]]\n" + name + "\nlink = \"serial:/dev/nowhere\"\nmodel = \"epuck2\"\ntag = 1\n");
  EXPECT_EQ(shell("$skein robots list --file robots.toml"), 0) << said;
  good("robots list");
  write("e.toml", std::regex_replace(read("e.toml"), std::regex("\nname = .*"), "\n" + name));
  EXPECT_EQ(shell("$skein run e.toml --duration 1 --set expect={}"), 0) << said;
  good("the summary");
  EXPECT_EQ(shell("$skein run e.toml --duration 1 --set expect={} --json"), 0) << said;
  EXPECT_THAT(out, AllOf(HasSubstr("\u009b2J"), HasSubstr("\u202e"))) << "JSON keeps its letters";
}

TEST_F(Mistakes, TablesOfRunsAreAlignedInAllLanguages) {
  keep_run("Käfer", "2026-11-01T12:00:00.000+01:00", 0);
  keep_run("機器人", "2026-11-01T12:00:01.000+01:00", 0);
  keep_run("e\xcc\x81te\xcc\x81", "2026-11-01T12:00:02.000+01:00", 0);
  EXPECT_EQ(shell("$skein runs list --runs-dir runs --show state,collisions"), 0) << said;
  EXPECT_EQ(out,
            "run     state     collisions\n"
            "Käfer   finished  0\n"
            "機器人  finished  0\n"
            "e\xcc\x81te\xcc\x81     finished  0\n");
}

/// Enter behind a completed name would else run what is in it.
TEST_F(Mistakes, ACompletedNameIsNoCommand) {
  for (const char* const name : {"$(touch owned)", "a;touch owned", "a b", "`touch owned`", "it's"})
    keep_run(name, "2026-11-01T12:00:00.000+01:00", 0);
  write("complete.bash", "source '" + skein::test::in_source("resources/completion/skein.bash") +
                             "'\nCOMP_WORDS=(\"$1\" runs show \"$2\") COMP_CWORD=3\n_skein\n"
                             "for word in \"${COMPREPLY[@]}\"; do eval \"set -- $word\"; echo \"$#: $1\"; done\n");
  EXPECT_EQ(shell("export SKEIN_RUNS=$PWD/runs; bash complete.bash \"$skein\""), 0) << said;
  EXPECT_FALSE(exists("owned"));
  for (const char* const name : {"$(touch owned)", "a;touch owned", "a b", "`touch owned`", "it's", "last"})
    EXPECT_THAT(out, HasSubstr("1: " + std::string(name) + "\n"));
  EXPECT_EQ(shell("export SKEIN_RUNS=$PWD/runs; bash complete.bash \"$skein\" 'a\\ '"), 0) << said;
  EXPECT_EQ(out, "1: a b\n") << "a name that was half typed";
}

/// Else `last` would be a run that nobody made.
TEST_F(Mistakes, ARefusedRunLeavesNoKeptRun) {
  EXPECT_EQ(shell("mkdir runs; echo mine > there.csv; $skein run e.toml --keep --runs-dir runs --csv there.csv"), 2);
  EXPECT_THAT(said, HasSubstr("there.csv: already exists"));
  EXPECT_EQ(shell("$skein run e.toml --keep --runs-dir runs --publish udp:nowhere"), 2);
  EXPECT_EQ(shell("$skein run e.toml --keep --runs-dir runs --set camera.source=video:none.mkv "
                  "--set camera.calibration=none.toml"),
            2);
  EXPECT_EQ(shell("ls runs"), 0);
  EXPECT_EQ(out, "");
}

TEST_F(Mistakes, ARunWhoseControllerRefusesIsKeptWithTheFilesThatItHas) {
  EXPECT_EQ(shell("mkdir runs; $skein run e.toml --keep --runs-dir runs --set controller.command=/bin/false"), 3);
  EXPECT_THAT(read("said"), HasSubstr("the controller"));
  EXPECT_EQ(shell("$skein runs verify last --runs-dir runs"), 1) << "nothing was recorded";
  EXPECT_THAT(out, HasSubstr("files: holds"));
}

/// The figures come last: how the run went, and whether its robots stand, must be told all the same.
TEST_F(Mistakes, FiguresThatCannotBeDrawnHideNoResult) {
  write("gnuplot", "#!/bin/sh\n[ \"$1\" = --version ] && exit 0\necho no room >&2\nexit 1\n");
  const std::string run =
      "chmod +x gnuplot; PATH=\"$PWD:$PATH\"; $skein run e.toml --duration 2 --report r --keep --runs-dir runs ";
  EXPECT_EQ(shell(run), 2);
  EXPECT_THAT(said, HasSubstr("figure3.gp: gnuplot ended with status 1: no room"));
  EXPECT_THAT(out, HasSubstr("ticks: 50"));
  EXPECT_EQ(shell("$skein runs find 'state = finished' --runs-dir runs"), 0) << said;
  EXPECT_EQ(shell(run + "--set expect.min_distance=9 --force"), 1);
  EXPECT_THAT(said, HasSubstr("expect.min_distance"));
}

TEST_F(Mistakes, TheRecordOfTheReportMayBeNamedAsThatOfTheRun) {
  EXPECT_EQ(shell("$skein run e.toml --duration 2 --csv ./r/run.csv --report r --set 'expect={}'"), 0) << said;
  EXPECT_EQ(shell("$skein run e.toml --duration 2 --csv ./r/run.csv --report r --set 'expect={}'"), 2);
  EXPECT_THAT(said, HasSubstr("r/run.csv: already exists"));
}

TEST_F(Mistakes, AFigureThatGnuplotCouldNotWriteIsMissed) {
  write("gnuplot", "#!/bin/sh\n[ \"$1\" = --version ] || printf '%%PDF-' > figure3.pdf\n");  // as on a full disk
  EXPECT_EQ(shell("chmod +x gnuplot; PATH=\"$PWD:$PATH\"; $skein run e.toml --duration 2 --report r"), 2);
  EXPECT_THAT(said, HasSubstr("r/figure3.gp: gnuplot did not write all of figure3.pdf: is the disk full?"));
}

TEST_F(Mistakes, NoRunIsFoundByANumberThatIsNone) {
  keep_run("a", "2026-11-01T12:00:00.000+01:00", 0);
  EXPECT_EQ(shell("$skein runs find 'collisions = nan' --runs-dir runs"), 2);
  EXPECT_THAT(said, HasSubstr("column 14 of the condition: found nan, which no key has, allowed: a finite number"));
  EXPECT_EQ(shell("$skein runs find 'collisions = 0' --runs-dir runs"), 0) << said;
}

TEST_F(Mistakes, TooFewPicturesOfABoardAreCounted) {
  EXPECT_EQ(shell("$skein tags board --out board.svg && mkdir pictures"), 0) << said;
  EXPECT_EQ(shell("printf 'P5 64 64 255\\n' > pictures/a.pgm && head -c 4096 /dev/zero >> pictures/a.pgm && "
                  "$skein calibrate intrinsics images:pictures --out cal.toml"),
            3);
  EXPECT_THAT(said, HasSubstr("found the board in 0 views, allowed: 3 or more, each with at least 6 corners"));
  EXPECT_THAT(said, HasSubstr("(pictures looked at: 1)"));
}

TEST_F(Mistakes, WhereACalibrationGoesIsCheckedBeforeAPictureIsRead) {
  for (const std::string& place : {std::string("/proc/cal.toml"), std::string(251, 'n') + ".toml"}) {
    EXPECT_EQ(shell("$skein calibrate intrinsics images:nowhere --out " + place), 2) << place;
    EXPECT_THAT(said, AllOf(HasSubstr(place), HasSubstr("cannot be written"), Not(HasSubstr("nowhere")))) << place;
  }
}

/// The first picture may be of anything, such as a small one that another program has left there.
TEST_F(Mistakes, TheFirstPictureOfTheBoardSaysHowLargePicturesAre) {
  std::filesystem::create_directories(folder_ / "pictures");
  write("pictures/a.pgm", "P5 64 64 255\n" + std::string(64 * 64, 'x'));
  std::string board;
  for (int v = 0; v < 480; ++v)
    for (int u = 0; u < 640; ++u) {
      const bool inside = u >= 80 && u < 560 && v >= 80 && v < 400;  // 12 x 8 squares of 40 px
      board += inside && (u / 40 + v / 40) % 2 == 0 ? '\x10' : '\xf0';
    }
  write("pictures/b.pgm", "P5 640 480 255\n" + board);
  write("pictures/c.pgm", "P5 64 64 255\n" + std::string(64 * 64, 'x'));
  EXPECT_EQ(shell("$skein calibrate intrinsics images:pictures --board chessboard --out cal.toml"), 3);
  EXPECT_THAT(said, HasSubstr("a.pgm: no board"));
  EXPECT_THAT(said, HasSubstr("skipped c.pgm: 64x64 px, the first picture of the board has 640x480"));
  EXPECT_THAT(said, HasSubstr("found the board in 1 view"));
}

TEST_F(Mistakes, SheetsAreNotOverwritten) {
  EXPECT_EQ(shell("$skein tags 1-4 --out t.svg"), 0) << said;
  EXPECT_EQ(shell("echo mine > t.svg; $skein tags 1-4 --out t.svg"), 2);
  EXPECT_THAT(said, HasSubstr("t.svg: already exists, allowed: another name, or --force"));
  EXPECT_EQ(read("t.svg"), "mine\n");
  EXPECT_EQ(shell("$skein tags 1-4 --out t.svg --force"), 0) << said;
  EXPECT_NE(read("t.svg"), "mine\n");
}

TEST_F(Mistakes, ASheetThatAnotherProgramWritesIsWaitedFor) {
  EXPECT_EQ(shell("exec 9> t.svg.new; flock 9; draft=$(stat -c :%i t.svg.new)\n"
                  "$skein tags 1-4 --out t.svg 9>&- & \n"
                  "until [ -e t.svg ] || grep -q -e \"->.*$draft \" /proc/locks; do :; done\n"
                  "echo theirs >&9; mv t.svg.new t.svg && cp t.svg first.svg; exec 9>&-; wait $!"),
            0)
      << said;
  EXPECT_EQ(read("first.svg"), "theirs\n");
  EXPECT_THAT(read("t.svg"), AllOf(HasSubstr("<svg"), HasSubstr("</svg>"), Not(HasSubstr("theirs"))));
  EXPECT_EQ(shell("$skein tags 1-4 --out /no/such/folder/tags.pdf"), 2);
  EXPECT_THAT(said, HasSubstr("/no/such/folder/tags.pdf: cannot be written"));
}

TEST_F(Mistakes, WithoutAHomeTheUserDatabaseSaysWhere) {
  EXPECT_EQ(shell("unset XDG_DATA_HOME SKEIN_RUNS HOME; $skein runs show no-such-run"), 2);
  EXPECT_THAT(said, AnyOf(HasSubstr("/.local/share/skein/runs"), HasSubstr("SKEIN_RUNS")));
  EXPECT_THAT(said, Not(HasSubstr(" /.local/share")));
}

TEST_F(Mistakes, CheckSaysWhichCertificateFailed) {
  EXPECT_EQ(shell("$skein check e.toml --set controller.c_theta=200"), 2);
  EXPECT_THAT(said, AllOf(HasSubstr("not certified: "), HasSubstr("`skein run` would run it all the same")));
  EXPECT_EQ(shell("$skein check e.toml"), 0);
  EXPECT_THAT(said, IsEmpty());
}

/// Hours of work must neither end with a file that cannot be written nor begin by emptying an older one.
TEST_F(Mistakes, WhereResultsGoIsCheckedBeforeTheWorkAndLosesNothing) {
  study("[hand]\nt = 1\n[tune.search]\n\"controller.k_y\" = [4, 5]\n");
  const std::string text = read("s.toml"), experiment = read("e.toml");
  const std::string endless = " --runs 10000000 --quiet";  // of which none is driven
  EXPECT_EQ(shell("$skein sweep s.toml --csv nowhere/rows.csv" + endless), 2);
  EXPECT_THAT(said, HasSubstr("nowhere/rows.csv: cannot be written: No such file or directory"));
  EXPECT_EQ(shell("$skein sweep s.toml --part 1/2 --into /proc/nowhere" + endless), 2);
  EXPECT_THAT(said, HasSubstr("/proc/nowhere/part-1-of-2.csv"));
  for (const char* place : {"/proc/nowhere", "/proc/self"}) {
    EXPECT_EQ(shell(std::string("$skein sweep s.toml --part 1/2 --into ") + place + endless), 2);
    EXPECT_THAT(said, AllOf(HasSubstr("/part-1-of-2.csv: cannot be written: "), Not(HasSubstr("draft"))));
  }
  EXPECT_EQ(shell("mkdir -p full/part-1-of-2.csv; $skein sweep s.toml --part 1/2 --into full" + endless), 2);
  EXPECT_THAT(said, HasSubstr("full/part-1-of-2.csv: cannot be written: it is a folder"));
  EXPECT_EQ(shell("$skein tune s.toml --save both.toml --csv ./both.toml --quiet"), 2);
  EXPECT_THAT(said, HasSubstr("--save both.toml: is the file of --csv as well"));
  for (const char* command : {"sweep", "tune"})
    for (const char* file : {"s.toml", "./e.toml"}) {
      EXPECT_EQ(shell(std::string("$skein ") + command + " s.toml --csv " + file + endless), 2) << command << out;
      EXPECT_THAT(said,
                  HasSubstr(std::string(file) + ": is a file that the study is read from, allowed: another name"));
    }
  EXPECT_EQ(read("s.toml"), text);
  EXPECT_EQ(read("e.toml"), experiment);
  write("old.csv", "an earlier front\n");
  EXPECT_EQ(shell("$skein tune s.toml --csv old.csv --set duration=2 --runs 1 --quiet"), 2) << "no kick settles";
  EXPECT_THAT(said, HasSubstr("there is nothing to compare with"));
  EXPECT_EQ(read("old.csv"), "an earlier front\n");
  EXPECT_EQ(shell("$skein tune s.toml --csv new.csv --save new.toml --set duration=2 --runs 1 --quiet"), 2);
  EXPECT_FALSE(exists("new.csv") || exists("new.toml")) << "nothing is left behind";
  EXPECT_EQ(shell("mkdir big && ln -s big/front.csv link.csv && "
                  "$skein tune s.toml --csv link.csv --set duration=2 --runs 1 --quiet"),
            2);
  EXPECT_TRUE(std::filesystem::is_symlink(folder_ / "link.csv") && !exists("big/front.csv")) << "the link stays";
}

TEST_F(Mistakes, WhatIsWrongWithACameraIsSaidBeforeARobotIsReached) {
  const std::string test = "$skein robots test tcp:127.0.0.1:1 ";  // nothing listens there
  write("cal.toml", "[camera]\nwidth = 1280\n");
  EXPECT_EQ(shell(test + "--camera v4l2:/dev/nowhere --calibration cal.toml"), 2);
  EXPECT_THAT(said, AllOf(HasSubstr("cal.toml:1:1: camera.height: missing"), Not(HasSubstr("127.0.0.1"))));
  for (const char* source : {"v4l3:/dev/video0", "/dev/video0", "none", "video:run.mkv"}) {
    EXPECT_EQ(shell(test + "--calibration cal.toml --camera " + source), 2) << source;
    EXPECT_THAT(said, HasSubstr("--camera " + std::string(source) + ": is not a camera; allowed: v4l2:DEVICE"));
  }
  write(
      "lab.toml",
      "[camera]\nsource = \"v4l2:/dev/nowhere\"\ncalibration = \"cal.toml\"\n[[robot]]\nlink = \"tcp:127.0.0.1:1\"\n");
  for (const char* words : {"run lab.toml", "robots test lab.toml", "camera latency lab.toml"}) {
    EXPECT_EQ(shell("$skein " + std::string(words)), 2) << words;
    EXPECT_THAT(said, AllOf(HasSubstr("cal.toml:1:1: camera.height: missing"), Not(HasSubstr("127.0.0.1")))) << words;
  }
}

/// Which host a name means is known only where the robots are reached.
TEST_F(Mistakes, TwoLinksToOneRobotAreRefusedWhateverNamesItHas) {
  std::filesystem::copy_file(skein::test::in_source("resources/cameras/overhead.toml"), folder_ / "cal.toml");
  write("lab.toml",
        "[camera]\nsource = \"v4l2:/dev/nowhere\"\ncalibration = \"cal.toml\"\n[[robot]]\nlink = "
        "\"tcp:127.0.0.1:1\"\n[[robot]]\nlink = \"tcp:127.1:1\"\n");
  for (const char* words : {"run lab.toml", "robots ping lab.toml --minutes 0.05"}) {
    EXPECT_EQ(shell(std::string("$skein ") + words), 3) << words;
    EXPECT_THAT(said, HasSubstr("robot 2: link \"tcp:127.1:1\" leads to tcp:127.0.0.1:1, as that of robot 1 does; "
                                "allowed: a different robot for each link"))
        << words;
  }
}

TEST_F(Mistakes, ARecordWithoutRowsIsNotFoundToBeRepeated) {
  EXPECT_EQ(
      shell("$skein run e.toml --set duration=1 --quiet --csv whole.csv && sed '/^t,tick/q' whole.csv > run.csv && "
            "$skein replay run.csv"),
      2);
  EXPECT_THAT(said, HasSubstr("run.csv: it has no rows"));
}

TEST_F(Mistakes, WhereAFilmGoesIsCheckedBeforeARobotIsReached) {
  std::filesystem::copy_file(skein::test::in_source("resources/cameras/overhead.toml"), folder_ / "cal.toml");
  write(
      "lab.toml",
      "[camera]\nsource = \"v4l2:/dev/nowhere\"\ncalibration = \"cal.toml\"\n[[robot]]\nlink = \"tcp:127.0.0.1:1\"\n");
  EXPECT_EQ(shell("$skein run lab.toml --video nowhere/run.mkv"), 2);
  EXPECT_THAT(said, AllOf(HasSubstr("nowhere/run.mkv: cannot be written: No such file or directory"),
                          Not(HasSubstr("127.0.0.1"))));
}

TEST_F(Mistakes, WhatWasMeasuredIsSavedAlsoWhereStdoutIsFull) {
  std::string lab = "[robot_defaults]\nlink = \"loopback\"\n[camera]\nsource = \"synthetic\"\n";
  for (int robot = 0; robot < 16; ++robot) lab += "[[robot]]\n";  // more than the C library's buffer takes
  write("lab.toml", lab);
  EXPECT_EQ(shell("$skein robots ping lab.toml --save --minutes 0.05 > /dev/full"), 3);
  EXPECT_EQ(said, "skein: stdout: cannot be written: No space left on device\n");
  EXPECT_THAT(read("lab.toml"), HasSubstr("blind_distance = "));
}

/// A name as long as may be leaves no room for the draft beside it.
TEST_F(Mistakes, WhereMeasurementsAreSavedIsCheckedBeforeTheyAreMade) {
  const std::string full = std::string(250, 'l') + ".toml";
  const std::string robots = "[robot_defaults]\nlink = \"loopback\"\n[camera]\nsource = \"synthetic\"\n[[robot]]\n";
  write("lab.toml", robots);
  write(full, robots);
  EXPECT_EQ(shell("$skein camera latency " + full + " --seconds 4 --save"), 2);
  EXPECT_THAT(said, HasSubstr("cannot be written: File name too long"));
  EXPECT_THAT(out, IsEmpty());
  EXPECT_EQ(shell("$skein robots ping " + full + " --save --minutes 0.05"), 2);
  EXPECT_THAT(said, HasSubstr("cannot be written: File name too long"));
  EXPECT_THAT(out, IsEmpty());
  EXPECT_EQ(shell("$skein run e.toml --set duration=1 --csv run.csv --quiet"), 0);
  EXPECT_EQ(shell("$skein identify run.csv --save --file nowhere.toml --report figures"), 2);
  EXPECT_THAT(said, HasSubstr("nowhere.toml: cannot be read: No such file or directory"));
  EXPECT_FALSE(exists("figures"));
  EXPECT_EQ(shell("$skein robots test lab.toml --save --file nowhere.toml"), 2);
  EXPECT_THAT(said, HasSubstr("nowhere.toml: cannot be read: No such file or directory"));
  EXPECT_THAT(out, IsEmpty());
}

TEST_F(Mistakes, AStudyWhoseTableTheDiskDoesNotTakeIsToldAndCostsNoOlderTable) {
  study("");
  const std::string older = "an earlier table\n";
  write("old.csv", older);
  // The limit stands for the disk; what is said goes through a pipe, which it does not concern.
  EXPECT_EQ(
      shell("{ (ulimit -f 1; $skein sweep s.toml --runs 20 --csv old.csv; echo \"status: $?\"); } 2>&1 | cat > all"),
      0);
  EXPECT_THAT(read("all"), AllOf(HasSubstr("old.csv: cannot be written: File too large\n"), HasSubstr("\nruns: 20\n"),
                                 HasSubstr("status: 2\n")));
  EXPECT_EQ(read("old.csv"), older);
  EXPECT_EQ(shell("ls"), 0);
  EXPECT_THAT(out, Not(HasSubstr("old.csv."))) << "nothing is left behind";
  EXPECT_EQ(shell("$skein sweep s.toml --csv old.csv --quiet && mkfifo fifo && { cat fifo > copy.csv & } && "
                  "$skein sweep s.toml --csv fifo --quiet && ln -s later.csv link.csv && "
                  "$skein sweep s.toml --csv link.csv --quiet && wait"),
            0)
      << said;
  EXPECT_THAT(read("old.csv"), Not(HasSubstr(older)));
  EXPECT_EQ(read("copy.csv"), read("old.csv"));
  EXPECT_EQ(read("later.csv"), read("old.csv"));
  EXPECT_TRUE(std::filesystem::is_symlink(folder_ / "link.csv"));
}

TEST_F(Mistakes, ANameThatIsTooLongIsSaidToBe) {
  study("[hand]\nt = 1\n[tune.search]\n\"controller.k_y\" = [4, 5]\n");
  const std::string name(300, 'n');
  for (const std::string& words : {"sweep s.toml --part 1/2 --into " + name, "sweep s.toml --merge " + name,
                                   "sweep s.toml --csv " + name, "tune s.toml --save " + name}) {
    EXPECT_EQ(shell("$skein " + words), 2) << words;
    EXPECT_THAT(said, AllOf(HasSubstr("File name too long"), Not(HasSubstr("filesystem error")))) << words;
  }
}

/// --force is for an earlier page or table: the record is what both are made from.
TEST_F(Mistakes, NoRecordIsReplacedByWhatIsMadeOfIt) {
  EXPECT_EQ(shell("$skein run e.toml --set duration=1 --csv run.csv --quiet && ln -s run.csv link"), 0) << said;
  const std::string record = read("run.csv");
  for (const char* words : {"export run.csv --to csv --out run.csv", "export run.csv --to mat --out ./link",
                            "report run.csv --html --out run.csv"}) {
    EXPECT_EQ(shell(std::string("$skein ") + words + " --force"), 2) << words;
    EXPECT_THAT(said, HasSubstr(": is the record that is to be converted, allowed: another name"));
    EXPECT_EQ(read("run.csv"), record) << words;
  }
}

TEST_F(Mistakes, WhatARunIsReadFromIsNotWrittenOver) {
  const std::string way = "t,x,y\n0,0,0\n1,0.02,0\n2,0.05,0\n3,0.08,0\n", experiment = read("e.toml");
  write("way.csv", way);
  write("t.toml", "duration = 1\n[reference]\nkind = \"independent\"\n[[robot]]\ntrajectory = { csv = \"way.csv\" }\n");
  EXPECT_EQ(shell("$skein run t.toml --csv ./way.csv --force"), 2);
  EXPECT_THAT(said, HasSubstr("./way.csv: is a file that the run is read from, allowed: another file"));
  EXPECT_EQ(read("way.csv"), way);
  write("robots.toml", "[[robot]]\nname = \"anna\"\nlink = \"serial:/dev/nowhere\"\nmodel = \"epuck2\"\n");
  EXPECT_EQ(shell("$skein run e.toml --set robots_file=robots.toml --csv robots.toml --force"), 2);
  EXPECT_THAT(said, HasSubstr("robots.toml: is a file that the run is read from"));
  EXPECT_EQ(shell("$skein run e.toml --set camera.source=synthetic --video e.toml --force"), 2);
  EXPECT_THAT(said, HasSubstr("e.toml: is a file that the run is read from"));
  EXPECT_EQ(read("e.toml"), experiment);
  EXPECT_EQ(shell("$skein run t.toml --csv other.csv --quiet && $skein run t.toml --csv other.csv --force --quiet"), 0)
      << said;
}

TEST_F(Mistakes, ACameraThatIsNotThereCostsNoOlderTable) {
  write("tags.csv", "an earlier table\n");
  EXPECT_EQ(shell("$skein track v4l2:/dev/nowhere --csv tags.csv"), 3);
  EXPECT_EQ(read("tags.csv"), "an earlier table\n");
  EXPECT_EQ(shell("cp '" + skein::test::in_source("resources/cameras/overhead.toml") +
                  "' cal.toml; $skein track images:. --camera cal.toml --csv cal.toml"),
            2);
  EXPECT_THAT(said, HasSubstr("cal.toml: is a file that is read, allowed: another name"));
  EXPECT_THAT(read("cal.toml"), HasSubstr("[camera"));
  EXPECT_EQ(shell("mkdir pictures && printf 'P5 64 64 255\n' > pictures/a.pgm && head -c 4096 /dev/zero >> "
                  "pictures/a.pgm && $skein track images:pictures --csv tags.csv"),
            0)
      << said;
  EXPECT_THAT(read("tags.csv"), testing::StartsWith("frame,source,t,tag,")) << "it is replaced by what comes";
}

TEST_F(Mistakes, APageBesideTheRecordOfAKeptRunBelongsToIt) {
  EXPECT_EQ(shell("$skein run e.toml --set duration=1 --quiet --keep --runs-dir runs && mv runs/2* a"), 0) << said;
  EXPECT_EQ(shell("cd a && $skein report . --html && $skein export . --to mat"), 0) << said;
  EXPECT_TRUE(exists("a/a.html"));
  EXPECT_EQ(shell("$skein runs verify a"), 0) << out;
  EXPECT_EQ(shell("$skein report a --html --out a/a.html --force && $skein runs verify a"), 0) << said << out;
  for (const char* own : {"experiment.toml", "run.json", "summary.json"}) {
    const std::string before = read(std::string("a/") + own);
    for (const char* words : {"report a --html", "export a --to csv"}) {
      EXPECT_EQ(shell(std::string("$skein ") + words + " --force --out a/" + own), 2) << words;
      EXPECT_THAT(said, HasSubstr(std::string("a/") + own + ": is a file of the kept run, allowed: another name"));
    }
    EXPECT_EQ(read(std::string("a/") + own), before);
  }
  EXPECT_EQ(shell("sed -i s/platoon/lemon/ a/run.json; $skein report a --html --out a/a.html --force"), 0) << said;
  EXPECT_EQ(shell("$skein runs verify a"), 1) << "a new hash must not hide what was changed";
  EXPECT_THAT(out, HasSubstr("story: FAILS"));
}

TEST_F(Mistakes, WithoutAFolderForTemporaryFilesItIsNamed) {
  EXPECT_EQ(shell("$skein run e.toml --set duration=1 --csv run.csv --quiet --set 'expect={}'"), 0) << said;
  EXPECT_EQ(shell("TMPDIR=/nowhere $skein report run.csv --html"), 0) << said;
  EXPECT_THAT(said, HasSubstr("the page has no figures: no folder for them can be made in TMPDIR, /nowhere: "));
  EXPECT_TRUE(exists("run.html"));
  EXPECT_EQ(shell("TMPDIR=/nowhere $skein emulate"), 3);
  EXPECT_THAT(said, HasSubstr("emulate: the folder for temporary files, TMPDIR or /tmp: "));
}

TEST_F(Mistakes, APageThatIsInterruptedLeavesNothing) {
  EXPECT_EQ(shell("$skein run e.toml --set duration=1 --csv run.csv --quiet && mkdir tmp bin"), 0) << said;
  for (const char* signal : {"INT", "TERM"}) {
    write("bin/gnuplot", "#!/bin/sh\n[ \"$1\" = --version ] || kill -" + std::string(signal) + " $PPID\n");
    const int status = shell("chmod +x bin/gnuplot; TMPDIR=$PWD/tmp PATH=$PWD/bin:$PATH $skein report run.csv --html");
    EXPECT_EQ(status, 128 + (signal == std::string("INT") ? SIGINT : SIGTERM)) << said;
    EXPECT_TRUE(std::filesystem::is_empty(folder_ / "tmp"));
    EXPECT_FALSE(exists("run.html"));
  }
}

TEST_F(Mistakes, TheDoctorEndsAtOnceWhenItIsInterrupted) {
  EXPECT_EQ(shell("timeout --preserve-status -s INT 1 $skein doctor --seconds 30"), 128 + SIGINT) << said;
}

/// The newest run was not found where the clock is before 1970.
TEST_F(Mistakes, RowsArriveAtAnIPv4ReceiverThoughLocalhostHasBothProtocols) {
  write("hosts", "127.0.0.1 localhost\n::1 localhost\n");
  const std::string with_hosts = "unshare -rm sh -c 'mount --bind hosts /etc/hosts && exec \"$@\"' sh ";
  if (!std::filesystem::exists("/proc/net/if_inet6") || shell(with_hosts + "true") != 0)
    GTEST_SKIP() << "no IPv6, or no namespace in which /etc/hosts is another one";
  const int receiver = ::socket(AF_INET, SOCK_DGRAM | SOCK_CLOEXEC, 0);
  sockaddr_in here{};
  here.sin_family = AF_INET;
  here.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
  socklen_t size = sizeof here;
  ASSERT_EQ(::bind(receiver, reinterpret_cast<sockaddr*>(&here), size), 0);
  ASSERT_EQ(::getsockname(receiver, reinterpret_cast<sockaddr*>(&here), &size), 0);
  EXPECT_EQ(shell(with_hosts + "$skein run e.toml --set duration=1 --speed max --quiet --publish udp:localhost:" +
                  std::to_string(ntohs(here.sin_port))),
            0)
      << said;
  char one = 0;
  EXPECT_EQ(::recv(receiver, &one, 1, MSG_DONTWAIT), 1);
  ::close(receiver);
}

/// As docs/robots.md has it, in the folder of the file of robots.
TEST_F(Mistakes, TheRecommendedMinuteIsRunWithTheFileOfRobots) {
  const std::string document = skein::test::read_file(skein::test::in_source("docs/robots.md"));
  const std::regex line("\n    (skein run identify --set robots_file=.*) \\.\\.\\. --csv run.csv  .*\n");
  std::smatch command;
  ASSERT_TRUE(std::regex_search(document, command, line));
  write("robots.toml", "[[robot]]\nname = \"anna\"\nlink = \"serial:/dev/nowhere\"\nmodel = \"epuck2\"\ntag = 1\n");
  EXPECT_EQ(shell("$" + command[1].str() + " --csv run.csv"), 2);
  EXPECT_THAT(said, AllOf(HasSubstr("camera.source: found \"none\""), HasSubstr("serial:/dev/nowhere")))
      << "all that is missing is the lab's camera";
}

TEST_F(Mistakes, WhatIsWrittenToStdoutStandsThereAlone) {
  EXPECT_EQ(shell("$skein run e.toml --set duration=1 --csv run.csv --quiet && $skein export run.csv --to csv && "
                  "$skein export run.csv --to csv --out /dev/stdout | cmp - run.plain.csv"),
            0)
      << said << out;
  EXPECT_EQ(shell("$skein report run.csv --out /dev/stdout | tail -n 1"), 0) << said;
  EXPECT_EQ(out, "</html>\n");
}

TEST_F(Mistakes, AnEmulatorWhoseTerminalIsClosedLeavesNothingAndGoesOnUnderNohup) {
  const std::string begin = "mkdir -p t; export TMPDIR=$PWD/t; ", started = "until [ -s out ]; do sleep 0.02; done; ";
  EXPECT_EQ(shell(begin + "$skein emulate & " + started + "kill -HUP $!; wait $!; ls t >&2"), 0);
  EXPECT_EQ(said, "");
  EXPECT_EQ(shell(begin + "trap '' HUP; $skein emulate & " + started +
                  "kill -HUP $!; sleep 0.2; kill -TERM $! || exit 9; wait $!; ls t >&2"),
            0);
  EXPECT_EQ(said, "");
}

TEST_F(Mistakes, AnExportThatIsInterruptedLeavesNothing) {
  EXPECT_EQ(
      shell("$skein run e.toml --set duration=1 --csv run.csv --quiet && tail -n 1 run.csv > row && "
            "for i in 1 2 3 4 5 6 7 8 9 10 11 12 13; do cat row row > rows && mv rows row; done && cat row >> run.csv"),
      0)
      << said;
  for (const int signal : {SIGINT, SIGTERM, SIGKILL}) {
    // Rows enough to be interrupted in: as soon as the draft is there.
    const int status = shell(
        "$skein export run.csv --to csv --out x.csv & "
        "while ! [ -e x.csv.part ] && ! ls -l /proc/$!/fd | grep -q '(deleted)' && kill -0 $!; do :; done; kill -" +
        std::to_string(signal) + " $!; wait $!");
    EXPECT_EQ(status, 128 + signal) << said;
    EXPECT_EQ(shell("ls x.csv*"), 2) << out;
  }
}

TEST_F(Mistakes, AStudysTableDoesNotReplaceTheRecordOfARun) {
  study("");
  EXPECT_EQ(shell("$skein run e.toml --set duration=1 --csv run.csv --quiet && cp run.csv copy.csv"), 0) << said;
  for (const std::string command : {"sweep s.toml", "tune tune"}) {
    EXPECT_EQ(shell("$skein " + command + " --csv run.csv"), 2);
    EXPECT_THAT(said, HasSubstr("run.csv: is the record of a run, allowed: another name"));
    EXPECT_EQ(read("run.csv"), read("copy.csv"));
  }
  EXPECT_EQ(shell("$skein sweep s.toml --csv table.csv --quiet && $skein sweep s.toml --csv table.csv --quiet"), 0)
      << "the control: an earlier table " << said;
}

TEST_F(Mistakes, AProgramThatWasCopiedAloneSaysWhatItLacks) {
  EXPECT_EQ(shell("mkdir -p a/b && cp \"$skein\" \"$skein-bench\" a/b && a/b/skein run platoon"), 2);
  EXPECT_THAT(said, AllOf(HasSubstr("platoon: cannot be read"), HasSubstr("are not beside this program")));
  for (const std::string word : {"identify", "controllers"}) {
    EXPECT_EQ(shell("a/b/skein-bench " + word + " --runs 1 --seconds 1"), 2) << out;
    EXPECT_THAT(said, HasSubstr("a/b: the experiments and studies that come with Skein are not beside this program"));
  }
  EXPECT_EQ(shell("a/b/skein run no.toml"), 2);
  EXPECT_EQ(shell("a/b/skein run e.toml --set duration=1"), 0) << said;
  EXPECT_EQ(shell("$skein run no-such"), 2);
  EXPECT_THAT(said, Not(HasSubstr("not beside this program")));
}

TEST_F(Mistakes, AClockThatIsWrongIsNamed) {
#ifdef __SANITIZE_ADDRESS__
  GTEST_SKIP() << "the sanitizer lets no library be loaded before its own";
#endif
  const std::string library = "/usr/lib/x86_64-linux-gnu/faketime/libfaketime.so.1";
  if (!std::filesystem::exists(library)) GTEST_SKIP() << "no libfaketime";
  // The clock of the day alone: no machine's monotonic one is negative.
  const std::string wrong = "FAKETIME_DONT_FAKE_MONOTONIC=1 FAKETIME=-60y LD_PRELOAD=" + library + " ";
  EXPECT_EQ(shell(wrong + "$skein run e.toml --set duration=1 --keep --runs-dir runs --quiet && " + wrong +
                  "$skein runs verify last --runs-dir runs"),
            0)
      << said;
  EXPECT_THAT(said, HasSubstr("this machine's clock says that it is the year 19"));
  shell(wrong + "$skein doctor");
  EXPECT_THAT(out, HasSubstr("ILL   clock: says that it is the year 19"));
}

TEST_F(Mistakes, ARunWithoutItsRecordIsNotSaidToHaveAnEmptyOne) {
  keep_run("a", "2026-11-01T12:00:00.000+01:00", 0);
  write("runs/a/run.json", R"({"format":1,"files":{}})");
  EXPECT_EQ(shell("$skein runs verify a --runs-dir runs"), 1);
  EXPECT_THAT(out, HasSubstr("experiment: FAILS, runs/a/run.csv: cannot be opened: No such file or directory"));
  EXPECT_THAT(out, Not(HasSubstr("empty")));
}

TEST_F(Mistakes, WhatIsWrongWithARunJsonIsSaidWithItsPlace) {
  EXPECT_EQ(shell("$skein run e.toml --set duration=1 --quiet --keep --runs-dir runs && mv runs/2* a"), 0) << said;
  const auto refusal = [&](const std::string& text) {
    write("a/run.json", text);
    EXPECT_EQ(shell("$skein runs show a"), 2) << text;
    EXPECT_THAT(said, AllOf(HasSubstr("a/run.json: "), HasSubstr("allowed: a file written by `skein run --keep`")));
    return said;
  };
  EXPECT_THAT(refusal("{\n  \"state\": fini}\n"), HasSubstr("line 2, column 13"));
  EXPECT_THAT(refusal("{\"collisions\": 1" + std::string(500, '0') + "}"),
              AllOf(HasSubstr("number overflow"), Not(HasSubstr(std::string(300, '0')))));
  EXPECT_THAT(refusal("[1, 2]"), HasSubstr("it is not a JSON object"));
  EXPECT_THAT(refusal("{\"x\":" + std::string(200, '[') + std::string(200, ']') + "}"), HasSubstr("100 levels deep"));
  EXPECT_EQ(shell("$skein report a --html --out page.html"), 0) << said;
  EXPECT_THAT(said, HasSubstr("a/run.json: it is nested")) << "the page lacks what stands there";
}

TEST_F(Mistakes, RunsInFoldersOfOtherNamesAreComparedByThem) {
  EXPECT_EQ(shell("$skein run e.toml --set duration=1 --quiet --keep --runs-dir runs && cp -r runs/2* b && "
                  "mv runs/2* a && cd a && $skein runs compare . ../b"),
            0)
      << said;
  EXPECT_THAT(out, testing::MatchesRegex(" *a +b\n.*"));
}

TEST_F(Mistakes, AReaderThatHasGoneIsNoLossOfOutput) {
  EXPECT_EQ(shell("{ \"$skein-bench\" identify --runs 1 2> bench-said; } | true"), 0);
  EXPECT_THAT(read("bench-said"), IsEmpty());
}

/// 64 kB were too much to be printed at once, and nothing was.
TEST_F(Mistakes, ALongResultIsPrintedWhole) {
  std::string text =
      "duration = 2\narena = { width = 7, height = 7 }\n"
      "reference = { spacing = 0.3, path = { shape = \"circle\", radius = 3 } }\n";
  for (int k = 0; k < 40; ++k) text += "[[robot]]\n";
  write("many.toml", text);
  EXPECT_EQ(shell("$skein run many.toml --csv many.csv --quiet"), 0) << said;
  shell("$skein identify many.csv --json");
  EXPECT_GT(out.size(), 70'000u);
  EXPECT_TRUE(out.ends_with("]\n")) << out.size();
}

TEST_F(Mistakes, ASimulationWithoutNoiseIsNotAccused) {
  EXPECT_EQ(shell("$skein run e.toml --csv run.csv --quiet && $skein identify run.csv"), 0) << said << out;
  EXPECT_THAT(said, Not(HasSubstr("correlated")));
}

}  // namespace
