#include "app/runs/kept_run.h"

#include <fmt/format.h>
#include <gtest/gtest.h>
#include <sys/stat.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <fstream>
#include <future>
#include <sstream>

#include "app/calibration/calibration_file.h"
#include "app/experiment/experiment_file.h"
#include "app/record/csv_file.h"
#include "app/runs/machine.h"
#include "app/runs/run_folder.h"
#include "app/runs/run_page.h"
#include "app/runs/sha256.h"
#include "app/runs/verify.h"
#include "app/session/session.h"
#include "tests/app/folder.h"
#include "tests/files.h"
#include "tests/places.h"
#include "tests/small_disk.h"

namespace skein::app {
namespace {

using test::Folder;

using test::read_file;
using test::SmallDisk;

/// A run of a file in `place`, kept below `runs`.
std::string keep(const Folder& place, const std::string& runs, const std::string& text,
                 const std::vector<std::string>& sets = {}) {
  const std::string file = place / "my.toml";
  std::ofstream(file) << text;
  const auto experiment = load_experiment(file, sets);
  EXPECT_TRUE(experiment) << experiment.error().front().message();
  auto kept = KeptRun::begin({runs, file, sets, {"run", file}, false}, *experiment);
  EXPECT_TRUE(kept) << kept.error();
  Statistics statistics(*experiment);
  CsvFile csv(kept->csv(), *experiment);
  auto session = Session::open(*experiment, Session::Clock::virtual_, {.sinks = {&statistics, &csv}});
  (*session)->run();
  (*session)->close();
  csv.finish();
  const auto ended = kept->end(statistics.summary(), {});
  EXPECT_TRUE(ended) << ended.error();
  return kept->folder();
}

const std::string text =
    "# mine\nname = \"my first run\"\nduration = 2 # s\n[controller.gains]\nk_xx = 0.008  # weak\n";

/// The step of that name.
bool holds(const Verification& found, const std::string& what) {
  for (const Verification::Step& step : found.steps)
    if (step.what == what) return step.holds;
  ADD_FAILURE() << "no step " << what;
  return false;
}

TEST(KeptRun, TakesMoreFilesAndStillVerifies) {
  const Folder place;
  const std::string folder = keep(place, place / "runs", text);
  std::ofstream(folder + "/results.txt") << "settled";
  auto found = verify_run(folder);
  ASSERT_TRUE(found);
  EXPECT_FALSE(holds(*found, "files")) << "the control: a file that nobody has named";
  ASSERT_TRUE(add_to_kept_run(folder, {"results.txt"}));
  found = verify_run(folder);
  ASSERT_TRUE(found);
  EXPECT_TRUE(holds(*found, "files"));
  EXPECT_FALSE(add_to_kept_run(folder, {"nothing.txt"}));
  EXPECT_FALSE(add_to_kept_run(place / "runs", {"results.txt"})) << "not the folder of a run";
}

/// Each of several programs that write into the folder at once adds its file to run.json.
TEST(KeptRun, TakesFilesOfSeveralProgramsAtOnce) {
  const Folder place;
  const std::string folder = keep(place, place / "runs", text);
  constexpr int programs = 4, files = 20;
  const auto name = [](int program, int file) { return fmt::format("{}-{}.txt", program, file); };
  std::vector<std::future<void>> all;
  for (int program = 0; program < programs; ++program)
    all.push_back(std::async(std::launch::async, [&, program] {
      for (int file = 0; file < files; ++file) {
        std::ofstream(folder + '/' + name(program, file)) << "settled";
        EXPECT_TRUE(add_to_kept_run(folder, {name(program, file)}));
      }
    }));
  for (std::future<void>& program : all) program.get();
  const auto story = read_story(folder).value();
  for (int program = 0; program < programs; ++program)
    for (int file = 0; file < files; ++file)
      EXPECT_TRUE(story["files"].contains(name(program, file))) << name(program, file);
}

TEST(KeptRun, HasTheFilmOfEveryCamera) {
  const Folder place;
  const auto experiment = load_experiment(test::in_source("resources/experiments/two-cameras.toml"));
  ASSERT_TRUE(experiment);
  ASSERT_EQ(experiment->cameras(), 2u);
  std::ofstream(place / "lab.mkv") << "one";
  std::ofstream(place / "lab-2.mkv") << "two";
  auto kept = KeptRun::begin({place / "runs", {}, {}, {}, true, experiment->source}, *experiment);
  ASSERT_TRUE(kept) << kept.error();
  ASSERT_TRUE(kept->end(Statistics(*experiment).summary(), {0, {}, place / "lab.mkv"}));
  EXPECT_EQ(read_file(kept->folder() + "/film.mkv"), "one");
  EXPECT_EQ(read_file(kept->folder() + "/film-2.mkv"), "two");
  EXPECT_TRUE(read_story(kept->folder()).value()["files"].contains("film-2.mkv"));
}

/// Whoever keeps films on a large disk has a link to it where the run is.
TEST(KeptRun, HasTheFilmItselfWhereItsNameIsALink) {
  const Folder place;
  const Experiment experiment = paper_experiment();
  std::filesystem::create_directories(place / "large");
  std::ofstream(place / "large/film.mkv") << "the film";
  std::filesystem::create_symlink("large/film.mkv", place / "lab.mkv");
  auto kept = KeptRun::begin({place / "runs", {}, {}, {}, true, experiment.source}, experiment).value();
  const auto ended = kept.end(Statistics(experiment).summary(), {0, {}, place / "lab.mkv"});
  EXPECT_TRUE(ended) << ended.error();
  EXPECT_EQ(read_file(kept.folder() + "/film.mkv"), "the film");
  EXPECT_FALSE(std::filesystem::is_symlink(kept.folder() + "/film.mkv"));
}

/// In place of gnuplot a script, while one of these lives.
class OtherGnuplot {
 public:
  OtherGnuplot(const Folder& place, const std::string& script) {
    std::filesystem::create_directories(place / "bin");
    std::ofstream(place / "bin/gnuplot") << "#!/bin/sh\n[ \"$1\" = --version ] && exit 0\n" << script;
    std::filesystem::permissions(place / "bin/gnuplot", std::filesystem::perms::owner_all);
    ::setenv("PATH", (place / "bin:" + before_).c_str(), 1);
  }
  ~OtherGnuplot() { ::setenv("PATH", before_.c_str(), 1); }
  OtherGnuplot(const OtherGnuplot&) = delete;
  OtherGnuplot& operator=(const OtherGnuplot&) = delete;

 private:
  const std::string before_ = getenv("PATH");
};

/// The record of a run of one row.
void record(const KeptRun& kept, const Experiment& experiment) {
  CsvFile csv(kept.csv(), experiment);
  TickRecord row;
  row.robots.resize(experiment.robots.size());
  row.delta.assign(row.robots.size() - 1, 0.0);
  csv.record(row);
  csv.finish();
}

/// Drawing takes seconds on a busy machine, in which somebody closes the window.
TEST(KeptRun, HasItsResultsBeforeItsFiguresAreDrawn) {
  const Folder place;
  const OtherGnuplot gnuplot(place, "cp run.json \"${0%/*}/seen.json\"\n");
  const auto experiment = parse_experiment(text, "my.toml").value();
  auto kept = KeptRun::begin({place / "runs", {}, {}, {}, true, text}, experiment).value();
  record(kept, experiment);
  EXPECT_FALSE(kept.end(Statistics(experiment).summary(), {})) << "this gnuplot draws nothing";
  EXPECT_TRUE(kept.complete());
  const auto seen = nlohmann::ordered_json::parse(read_file(place / "bin/seen.json"));
  EXPECT_EQ(seen["state"], "finished");
  EXPECT_TRUE(seen["summary"].contains("ticks"));
  EXPECT_TRUE(seen["files"].contains("run.csv"));
  EXPECT_TRUE(seen["files"].contains("summary.json"));
  EXPECT_EQ(seal_holds(seen), true);
}

/// However its record fills the disk.
TEST(KeptRun, HoldsRoomForItsResultsWhileItGoesOn) {
  const Folder place;
  const auto experiment = parse_experiment(text, "my.toml").value();
  auto kept = KeptRun::begin({place / "runs", {}, {}, {}, true, text}, experiment).value();
  struct stat room {};
  ASSERT_EQ(::stat((kept.folder() + "/.room").c_str(), &room), 0);
  EXPECT_GE(room.st_blocks * 512, 200'000) << "on the disk, not a hole";
  std::ofstream(kept.csv()) << "the record";
  (void)kept.end(Statistics(experiment).summary(), {});  // this record cannot be drawn
  EXPECT_FALSE(std::filesystem::exists(kept.folder() + "/.room"));
}

/// Figures can be drawn again, the results of a run cannot: a disk that is full of the ones still has the others.
TEST(KeptRun, FiguresForWhichThereIsNoRoomAreLeftOutAndItsResultsAreThere) {
  const Folder place;
  const OtherGnuplot gnuplot(place, "rm run.json; mkdir run.json; : > figure3.svg\n");  // it cannot be written again
  const auto experiment = parse_experiment(text, "my.toml").value();
  auto kept = KeptRun::begin({place / "runs", {}, {}, {}, true, text}, experiment).value();
  record(kept, experiment);
  EXPECT_FALSE(kept.end(Statistics(experiment).summary(), {}));
  EXPECT_TRUE(kept.complete());
  EXPECT_EQ(files_of_run(kept.folder()),
            (std::vector<std::string>{"experiment-as-written.toml", "experiment.toml", "run.csv", "summary.json"}));
}

TEST(KeptRun, OneWhoseDiskHasNoRoomForFiguresWasNotKilled) {
  const Folder place;
  const auto experiment = parse_experiment(text, "my.toml").value();
  const auto end = [&](const std::string& script, rlim_t room) {
    const OtherGnuplot gnuplot(place, script);
    auto kept = KeptRun::begin({place / "runs", {}, {}, {}, true, text}, experiment).value();
    record(kept, experiment);
    const SmallDisk disk(room);
    EXPECT_FALSE(kept.end(Statistics(experiment).summary(), {}));
    return kept.folder();
  };
  end("cp run.json \"${0%/*}/seen.json\"\n", RLIM_INFINITY);  // before its figures
  const std::string run = end(": > figure3.svg\n", read_file(place / "bin/seen.json").size() + 20);
  EXPECT_FALSE(read_story(run).value().contains(figures_to_come));
  const auto found = verify_run(run);
  ASSERT_TRUE(found) << found.error();
  EXPECT_TRUE(holds(*found, "files"));
  for (const std::string& note : found->notes) EXPECT_EQ(note.find("killed"), std::string::npos) << note;
}

TEST(KeptRun, HasAllThatItCameFromAndAllThatItGave) {
  const Folder folder;
  const std::string run = keep(folder, folder / "runs", text, {"controller.gains.k_xx=0.003"});
  EXPECT_EQ(read_file(run + "/experiment-as-written.toml"), text);
  EXPECT_NE(read_file(run + "/experiment.toml").find("# mine\n"), std::string::npos);
  EXPECT_NE(read_file(run + "/experiment.toml").find("k_xx = 0.003  # weak\n"), std::string::npos);
  const auto story = read_story(run).value();
  EXPECT_EQ(story["state"], "finished");
  EXPECT_EQ(story["name"], "my first run");
  EXPECT_EQ(story["id"].get<std::string>().substr(17), "_my-first-run");
  EXPECT_EQ(story["experiment"]["controller.gains.k_xx"], 0.003);
  EXPECT_EQ(story["summary"]["ticks"], 50);
  EXPECT_EQ(story["machine"]["host"], describe_machine().host);
  EXPECT_EQ(story["sets"][0], "controller.gains.k_xx=0.003");
  for (const char* const name : {"run.csv", "experiment.toml", "figure3.svg", "figure4.pdf", "summary.json"})
    EXPECT_TRUE(story["files"].contains(name)) << name;
  EXPECT_EQ(story["files"].size() + 1, files_of_run(run).size()) << "all but run.json itself";
}

/// A laptop gets the time from its network a while after it was switched on; here the clock goes back each time that it
/// is asked.
TEST(KeptRun, EndsAfterItBeganThoughTheClockIsSetBackMeanwhile) {
  using Clock = std::chrono::system_clock;
  const Folder folder;
  KeepRequest request{folder / "runs", {}, {}, {}, true, text};
  request.clock = +[] {
    static Clock::time_point next = Clock::now();
    return std::exchange(next, next - std::chrono::hours(1));
  };
  auto kept = KeptRun::begin(request, paper_experiment()).value();
  ASSERT_TRUE(kept.end({}, {}));
  const auto story = read_story(kept.folder()).value();
  EXPECT_GE(story["ended"].get<std::string>(), story["began"].get<std::string>());
}

TEST(KeptRun, RunsOfOneSecondHaveFoldersOfTheirOwn) {
  const Folder folder;
  std::set<std::string> names;
  for (int i = 0; i < 3; ++i) names.insert(keep(folder, folder / "runs", text));
  EXPECT_EQ(names.size(), 3u);
}

TEST(KeptRun, IsNotKeptInTheFolderOfAnother) {
  const Folder folder;
  const Experiment experiment = paper_experiment();
  const std::string run = KeptRun::begin({folder.path, "", {}, {}, true}, experiment)->folder();
  const auto inside = KeptRun::begin({run, "", {}, {}, true}, experiment);
  ASSERT_FALSE(inside);
  EXPECT_NE(inside.error().find("is the folder of a kept run itself"), std::string::npos) << inside.error();
}

TEST(KeptRun, OneThatWasKilledIsThereAndSaysThatItOnlyBegan) {
  const Folder folder;
  const Experiment experiment = paper_experiment();
  const std::string run = KeptRun::begin({folder.path, "", {}, {}, true}, experiment)->folder();
  const auto story = read_story(run).value();
  EXPECT_EQ(story["state"], "begun");
  EXPECT_FALSE(story.contains("ended"));
  EXPECT_FALSE(verify_run(run)->holds());
}

/// Nobody has stopped it, and its clock may have been the virtual one.
TEST(Verify, SaysOfARunThatWasKilledThatItDidNotFinish) {
  const Folder folder;
  const std::string run = keep(folder, folder / "runs", text);
  auto story = read_story(run).value();
  story["state"] = "begun";
  story.erase("files");
  std::ofstream(run + "/run.json") << sealed(story);
  const auto found = verify_run(run).value();
  EXPECT_FALSE(holds(found, "files"));
  EXPECT_TRUE(holds(found, "commands"));
  ASSERT_EQ(found.notes.size(), 1u);
  EXPECT_TRUE(found.notes[0].starts_with("the run did not finish: ")) << found.notes[0];
  // Nor has anybody stopped one whose disk became full.
  story["state"] = "failed";
  std::ofstream(run + "/run.json") << sealed(story);
  EXPECT_TRUE(verify_run(run)->notes.at(0).starts_with("the run failed: "));
}

TEST(KeptRun, ADirectoryThatCannotBeMadeIsSaid) {
  const auto kept = KeptRun::begin({"/proc/none", "", {}, {}, false}, paper_experiment());
  ASSERT_FALSE(kept);
  EXPECT_NE(kept.error().find("/proc/none"), std::string::npos);
  // The lab's disk is not mounted.
  const Folder folder;
  std::filesystem::create_symlink("/nowhere/runs", folder / "runs");
  EXPECT_EQ(KeptRun::begin({folder / "runs", "", {}, {}, false}, paper_experiment()).error(),
            folder / "runs" + ": cannot be made: it is a link to /nowhere/runs, which is no folder");
}

TEST(KeptRun, HasTheFilesOfAControllerOfOnesOwn) {
  const Folder folder;
  std::filesystem::create_directories(folder / "laws");
  std::ofstream(folder / "laws/mine.py") << "the law";
  std::ofstream(folder / "table.csv") << "its table";
  std::ofstream(folder / "experiment.toml") << "the run has a file of this name";
  std::ofstream(folder / "my.toml")
      << "controller.command = 'python3 laws/mine.py ./table.csv experiment.toml none.py'\n";
  const auto experiment = load_experiment(folder / "my.toml");
  ASSERT_TRUE(experiment) << experiment.error().front().message();
  const auto kept = KeptRun::begin({folder / "runs", folder / "my.toml", {}, {}, false}, *experiment);
  ASSERT_TRUE(kept) << kept.error();
  EXPECT_EQ(read_file(kept->folder() + "/laws/mine.py"), "the law");
  EXPECT_EQ(read_file(kept->folder() + "/table.csv"), "its table");
  EXPECT_EQ(read_file(kept->folder() + "/experiment.toml"), experiment->source);
}

TEST(Verify, HoldsForAnUntouchedRunWhereverItIs) {
  const Folder folder, elsewhere;
  const std::string run = keep(folder, folder / "runs", text);
  std::filesystem::copy(run, elsewhere / "copy", std::filesystem::copy_options::recursive);
  std::filesystem::remove_all(folder / "my.toml");
  const auto found = verify_run(elsewhere / "copy").value();
  EXPECT_TRUE(found.holds());
  EXPECT_EQ(found.steps.size(), 5u);
  for (const Verification::Step& step : found.steps) EXPECT_TRUE(step.holds) << step.what << ": " << step.finding;
}

TEST(KeptRun, ASeedThatNoDoubleHoldsKeepsItsDigits) {
  const Folder folder;
  const std::string seed = "9007199254740993";
  const std::string run = keep(folder, folder / "runs", "seed = " + seed + "\nduration = 0.2\n");
  EXPECT_NE(read_file(run + "/run.json").find("\"experiment.seed\": " + seed + ","), std::string::npos);
  EXPECT_EQ(std::get<std::int64_t>(run_facts(read_story(run).value()).at("experiment.seed")), 9007199254740993);
  EXPECT_TRUE(verify_run(run)->holds());
}

TEST(KeptRun, CalibrationsFromAnywhereHaveNamesOfTheirOwn) {
  EXPECT_EQ(calibration_in_folder("sub/./lab.toml", 0), "sub/lab.toml");
  EXPECT_EQ(calibration_in_folder("lab..2.toml", 0), "lab..2.toml");
  for (const char* const elsewhere : {"/lab/one.toml", "../one.toml", "a/../../one.toml"})
    EXPECT_EQ(calibration_in_folder(elsewhere, 1), "calibration-2.toml") << elsewhere;
  EXPECT_EQ(calibration_in_folder("calibration.toml", 0), "calibration.toml");
  EXPECT_EQ(calibration_in_folder("calibration.toml", 1), "calibration-2.toml")
      << "that of camera 1 may have that name";
  EXPECT_EQ(calibration_in_folder("experiment.toml", 0), "calibration.toml") << "the run has a file of that name";
}

TEST(Verify, UsesTheCalibrationOfTheFolderAndNotWhatLiesWhereItWas) {
  const Folder folder;
  const std::string calibration = folder / "lab..1.toml";
  ASSERT_TRUE(save_calibration(vision::overhead_calibration(2.0, 1.5), calibration));
  for (const std::string& named : {calibration, std::string("lab..1.toml")}) {
    ASSERT_TRUE(save_calibration(vision::overhead_calibration(2.0, 1.5), calibration));
    const std::string run = keep(folder, folder / "runs",
                                 "duration = 0.2\n[camera]\nsource = \"synthetic\"\ncalibration = \"" + named + "\"\n");
    ASSERT_TRUE(
        save_calibration(vision::overhead_calibration(2.6, 1.9), calibration));  // the camera hangs elsewhere now
    const auto found = verify_run(run).value();
    for (const Verification::Step& step : found.steps) EXPECT_TRUE(step.holds) << step.what << ": " << step.finding;
  }
}

/// Each file in turn, by one byte in its middle, is noticed and named.
TEST(Verify, NamesWhicheverFileIsDamaged) {
  const Folder folder;
  const std::string run = keep(folder, folder / "runs", text);
  ASSERT_TRUE(verify_run(run)->holds());
  const std::vector<std::string> files = files_of_run(run);
  EXPECT_GE(files.size(), 5u);
  for (const std::string& name : files) {
    const std::string path = fmt::format("{}/{}", run, name), whole = read_file(path);
    std::string damaged = whole;
    std::size_t at = damaged.size() / 2;
    if (name == "run.json") at = damaged.find("\"host\": \"") + 9;  // still JSON
    damaged[at] = damaged[at] == 'x' ? 'y' : 'x';
    std::ofstream(path, std::ios::binary) << damaged;
    const auto found = verify_run(run);
    ASSERT_TRUE(found) << name << ": " << found.error();
    EXPECT_FALSE(found->holds()) << name;
    std::string findings;
    for (const Verification::Step& step : found->steps) findings += step.finding + "\n";
    EXPECT_NE(findings.find(name + ":"), std::string::npos) << findings;
    std::ofstream(path, std::ios::binary) << whole;
  }
  EXPECT_TRUE(verify_run(run)->holds());
}

TEST(Verify, NamesEachFileThatWasChanged) {
  const Folder folder;
  const std::string run = keep(folder, folder / "runs", text);
  for (const char* const name : {"/summary.json", "/figure3.svg"}) std::ofstream(run + name, std::ios::app) << ' ';
  std::filesystem::remove(run + "/figure4.png");
  std::ofstream(run + "/mine.txt") << "a note";
  const auto found = verify_run(run).value();
  for (const char* const name : {"summary.json: was changed", "figure3.svg: was changed", "figure4.png: cannot be op",
                                 "mine.txt: does not belong"})
    EXPECT_NE(found.steps[1].finding.find(name), std::string::npos) << found.steps[1].finding;
}

/// Of a file elsewhere, the record does not follow, though its hash be right.
TEST(Verify, TakesNoFileFromOutsideTheFolder) {
  const Folder folder;
  const std::string run = keep(folder, folder / "runs", text);
  for (const std::string& name : {std::string("../lab.toml"), folder / "lab.toml", std::string("a/../../lab.toml")}) {
    const std::filesystem::path file = name[0] == '/' ? name : run + "/../lab.toml";
    std::ofstream(file) << "what another run had";
    std::filesystem::create_directories(run + "/a");
    auto edited = read_story(run).value();
    edited["files"][name] = {{"sha256", sha256_of_file(file.string()).value()}};
    std::ofstream(run + "/run.json") << edited.dump();
    const auto found = verify_run(run);
    ASSERT_TRUE(found);
    EXPECT_FALSE(holds(*found, "files")) << name;
    edited["files"].erase(name);
    std::ofstream(run + "/run.json") << edited.dump();
    EXPECT_TRUE(holds(*verify_run(run), "files")) << "the control: without it all files are right";
  }
}

/// What somebody has written into run.json by hand is no bug of ours.
TEST(Verify, AnEditedRunJsonIsAFindingWhateverStandsInIt) {
  const Folder folder;
  const std::string run = keep(folder, folder / "runs", "duration = 0.2\n");
  const auto story = read_story(run).value();
  for (const auto& [key, value] : story.items()) {
    auto edited = story;
    edited[key] = value.is_array() ? nlohmann::ordered_json("x") : nlohmann::ordered_json::array({7});
    std::ofstream(run + "/run.json") << edited;
    const auto found = verify_run(run);
    EXPECT_FALSE(found && found->holds()) << key;
    EXPECT_TRUE(found || key == "format") << found.error();
    EXPECT_TRUE(page_of_run(run + "/run.csv", run)) << key;
    EXPECT_FALSE(run_facts(edited).empty());
  }
  auto hashes = story;
  hashes["files"]["run.csv"]["sha256"] = 7;
  std::ofstream(run + "/run.json") << hashes;
  EXPECT_FALSE(holds(*verify_run(run), "files"));
}

TEST(Verify, ARunOfANewerFormatIsLeftToTheVersionThatKeptIt) {
  const Folder folder;
  const std::string run = keep(folder, folder / "runs", text);
  auto story = read_story(run).value();
  story["format"] = story_format + 1;
  std::ofstream(run + "/run.json") << sealed(story);
  const auto found = verify_run(run);
  ASSERT_FALSE(found);
  EXPECT_NE(found.error().find("found format 2, allowed: 1"), std::string::npos) << found.error();
  // One from before run.json had a hash: all else is checked.
  story["format"] = story_format;
  story.erase("sha256");
  std::ofstream(run + "/run.json") << story;
  const auto old = verify_run(run);
  ASSERT_TRUE(old);
  EXPECT_TRUE(old->holds());
  EXPECT_EQ(old->notes.size(), 1u);
}

TEST(Verify, NoticesAChangedByteAMissingFileAndOneTooMany) {
  const Folder folder;
  const std::string run = keep(folder, folder / "runs", text);
  const std::string summary = read_file(run + "/summary.json");
  std::ofstream(run + "/summary.json") << summary << ' ';
  EXPECT_FALSE(holds(*verify_run(run), "files"));
  std::ofstream(run + "/summary.json") << summary;
  EXPECT_TRUE(verify_run(run)->holds());
  std::ofstream(run + "/mine.txt") << "a note";
  EXPECT_FALSE(holds(*verify_run(run), "files"));
  std::filesystem::remove(run + "/mine.txt");
  std::filesystem::remove(run + "/figure3.svg");
  EXPECT_FALSE(holds(*verify_run(run), "files"));
}

/// Its results are whole; what is left of the figures proves nothing, and is named.
TEST(Verify, ARunThatWasKilledWhileItsFiguresWereDrawnHolds) {
  const Folder folder;
  std::string run;
  {
    const OtherGnuplot gnuplot(folder, "kill -9 $PPID\n");
    const pid_t child = ::fork();
    if (child == 0) {
      keep(folder, folder / "runs", text);
      ::_exit(0);
    }
    int status = 0;
    ASSERT_EQ(::waitpid(child, &status, 0), child);
    ASSERT_TRUE(WIFSIGNALED(status));
  }
  for (const auto& entry : std::filesystem::directory_iterator(folder / "runs")) run = entry.path();
  ASSERT_TRUE(std::filesystem::exists(run + "/figure3.gp"));
  std::ofstream(run + "/figure3.pdf") << "half of it";
  std::ofstream(run + "/run.json.new") << "{";
  auto found = verify_run(run);
  ASSERT_TRUE(found) << found.error();
  EXPECT_TRUE(found->holds());
  ASSERT_EQ(found->notes.size(), 1u);
  EXPECT_EQ(found->notes[0],
            "the program was killed while it drew the run's figures: `skein report` draws them; not verified, and "
            "perhaps not complete: figure3.dat, figure3.gp, figure3.pdf, run.json.new");
  std::ofstream(run + "/mine.txt") << "a note";
  EXPECT_FALSE(holds(*verify_run(run), "files"));
  EXPECT_FALSE(read_story(keep(folder, folder / "others", text)).value().contains(figures_to_come));
}

/// What is no file has no hash, and reading a FIFO would wait for ever.
TEST(Verify, NoticesLinksAndWhatIsNoFile) {
  const Folder folder;
  const std::string run = keep(folder, folder / "runs", text);
  std::filesystem::create_directory_symlink(folder.path, run + "/elsewhere");
  EXPECT_FALSE(holds(*verify_run(run), "files"));
  std::filesystem::remove(run + "/elsewhere");
  std::filesystem::create_symlink("/nowhere", run + "/dangling");
  EXPECT_FALSE(holds(*verify_run(run), "files"));
  std::filesystem::remove(run + "/dangling");
  EXPECT_TRUE(verify_run(run)->holds());
  for (const char* const name : {"/summary.json", "/run.csv"}) {
    std::filesystem::remove(run + name);
    ASSERT_EQ(::mkfifo((run + name).c_str(), 0600), 0);
    EXPECT_FALSE(holds(*verify_run(run), "files")) << name;
  }
}

/// Whoever changes a number and its hash as well is found out by the run itself.
TEST(Verify, NoticesAFolderThatMayNotBeLookedInto) {
  if (::geteuid() == 0) GTEST_SKIP() << "root may look into every folder";
  const Folder folder;
  const std::string run = keep(folder, folder / "runs", text);
  std::filesystem::create_directories(run + "/hidden");
  std::filesystem::permissions(run + "/hidden", std::filesystem::perms::none);
  const auto found = verify_run(run);
  std::filesystem::permissions(run + "/hidden", std::filesystem::perms::owner_all);
  ASSERT_TRUE(found);
  EXPECT_FALSE(holds(*found, "files"));
}

TEST(Verify, NoticesARecordThatDoesNotFollowFromItsInputs) {
  const Folder folder;
  const std::string run = keep(folder, folder / "runs", text);
  const std::string csv = read_file(run + "/run.csv");
  const auto forge = [&](const std::string& forged) {
    std::ofstream(run + "/run.csv", std::ios::binary) << forged;
    auto story = read_story(run).value();
    story["files"]["run.csv"]["sha256"] = sha256_of_file(run + "/run.csv").value();
    std::ofstream(run + "/run.json") << story;
    auto found = verify_run(run).value();
    EXPECT_TRUE(holds(found, "files"));
    return found;
  };
  // The last row's V, and nothing else: no command changes, but the run made once more gives another.
  const std::size_t row = csv.rfind('\n', csv.size() - 2) + 1;
  std::size_t cell = row;
  for (int column = 0; column < 5; ++column) cell = csv.find(',', cell) + 1;
  std::string forged = csv;
  forged.replace(cell, csv.find(',', cell) - cell, "0.125");
  const auto other_v = forge(forged);
  EXPECT_TRUE(holds(other_v, "commands"));
  EXPECT_FALSE(holds(other_v, "run_again"));
  // Rows that were left out.
  EXPECT_FALSE(holds(forge(csv.substr(0, row)), "run_again"));
  // Another gain in the embedded experiment.
  forged = csv;
  forged.replace(forged.find("k_xx = 0.008"), 12, "k_xx = 0.007");
  EXPECT_FALSE(holds(forge(forged), "experiment"));
}

TEST(Verify, SaysThatAnotherProgramKeptTheRunWhereSomethingDiffers) {
  const Folder folder;
  const std::string run = keep(folder, folder / "runs", text);
  auto story = read_story(run).value();
  story["program"]["commit"] = "0123456789ab";
  story.erase("sha256");
  std::ofstream(run + "/run.json") << sealed(story);
  const auto says = [&] {
    const std::vector<std::string> notes = verify_run(run)->notes;
    return std::any_of(notes.begin(), notes.end(), [](const std::string& note) {
      return note.find("(0123456789ab), verified by") != std::string::npos;
    });
  };
  EXPECT_FALSE(says()) << "nothing differs";
  std::ofstream(run + "/run.csv", std::ios::app) << "1,2,3\n";
  EXPECT_TRUE(says());
}

TEST(Sha256, IsThatOfTheStandard) {
  const Folder folder;
  std::ofstream(folder / "abc") << "abc";
  EXPECT_EQ(sha256_of_file(folder / "abc").value(), "ba7816bf8f01cfea414140de5dae2223b00361a396177a9cb410ff61f20015ad");
  EXPECT_FALSE(sha256_of_file(folder / "none"));
}

TEST(MachineDescription, TimesNameTheirZone) {
  const char* const zone = getenv("TZ");
  const std::string before = zone != nullptr ? zone : "";
  ::setenv("TZ", "CET-1CEST", 1);
  ::tzset();
  const auto time = std::chrono::system_clock::time_point(std::chrono::milliseconds(1'764'000'000'250));
  EXPECT_EQ(local_time(time), "2025-11-24T17:00:00.250+01:00");
  EXPECT_EQ(time_for_name(time), "2025-11-24_170000");
  ::setenv("TZ", before.c_str(), 1);
  ::tzset();
}

}  // namespace
}  // namespace skein::app
