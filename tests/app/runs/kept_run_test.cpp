#include "app/runs/kept_run.h"

#include <gtest/gtest.h>

#include <fstream>
#include <sstream>

#include "app/experiment/experiment_file.h"
#include "app/record/csv_file.h"
#include "app/runs/machine.h"
#include "app/runs/run_folder.h"
#include "app/runs/sha256.h"
#include "app/runs/verify.h"
#include "app/session/session.h"
#include "tests/app/folder.h"
#include "tests/places.h"

namespace skein::app {
namespace {

using test::Folder;

std::string read_file(const std::string& path) {
  std::ifstream file(path, std::ios::binary);
  std::ostringstream text;
  text << file.rdbuf();
  return text.str();
}

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

TEST(KeptRun, RunsOfOneSecondHaveFoldersOfTheirOwn) {
  const Folder folder;
  std::set<std::string> names;
  for (int i = 0; i < 3; ++i) names.insert(keep(folder, folder / "runs", text));
  EXPECT_EQ(names.size(), 3u);
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

TEST(KeptRun, ADirectoryThatCannotBeMadeIsSaid) {
  const auto kept = KeptRun::begin({"/proc/none", "", {}, {}, false}, paper_experiment());
  ASSERT_FALSE(kept);
  EXPECT_NE(kept.error().find("/proc/none"), std::string::npos);
}

TEST(Verify, HoldsForAnUntouchedRunWhereverItIs) {
  const Folder folder, elsewhere;
  const std::string run = keep(folder, folder / "runs", text);
  std::filesystem::copy(run, elsewhere / "copy", std::filesystem::copy_options::recursive);
  std::filesystem::remove_all(folder / "my.toml");
  const auto found = verify_run(elsewhere / "copy").value();
  EXPECT_TRUE(found.holds());
  EXPECT_EQ(found.steps.size(), 4u);
  for (const Verification::Step& step : found.steps) EXPECT_TRUE(step.holds) << step.what << ": " << step.finding;
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

/// Whoever changes a number and its hash as well is found out by the run itself.
TEST(Verify, NoticesARecordThatDoesNotFollowFromItsInputs) {
  const Folder folder;
  const std::string run = keep(folder, folder / "runs", text);
  const std::string csv = read_file(run + "/run.csv");
  const auto forge = [&](const std::string& forged) {
    std::ofstream(run + "/run.csv", std::ios::binary) << forged;
    auto story = read_story(run).value();
    story["files"]["run.csv"]["sha256"] = sha256_of_file(run + "/run.csv").value();
    std::ofstream(run + "/run.json") << story;
    const auto found = verify_run(run).value();
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

TEST(Sha256, IsThatOfTheStandard) {
  const Folder folder;
  std::ofstream(folder / "abc") << "abc";
  EXPECT_EQ(sha256_of_file(folder / "abc").value(), "ba7816bf8f01cfea414140de5dae2223b00361a396177a9cb410ff61f20015ad");
  EXPECT_FALSE(sha256_of_file(folder / "none"));
}

TEST(MachineDescription, TimesNameTheirZone) {
  const std::string before = getenv("TZ") ? getenv("TZ") : "";
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
