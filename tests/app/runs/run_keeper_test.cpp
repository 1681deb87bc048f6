#include "app/runs/run_keeper.h"

#include <fmt/format.h>
#include <gtest/gtest.h>
#include <stdlib.h>
#include <sys/stat.h>
#include <unistd.h>

#include <filesystem>
#include <fstream>
#include <memory>

#include "app/experiment/experiment_file.h"
#include "app/runs/find_run.h"
#include "app/runs/run_folder.h"
#include "app/runs/run_page.h"
#include "app/runs/verify.h"
#include "app/session/session.h"
#include "tests/app/folder.h"
#include "tests/small_disk.h"

namespace skein::app {
namespace {

using test::Folder;
using test::SmallDisk;

Experiment seconds(int duration) {
  auto experiment = parse_experiment(paper_experiment().source, "e.toml", {"duration=" + std::to_string(duration)});
  EXPECT_TRUE(experiment) << experiment.error().front().message();
  return experiment.value_or(Experiment{});
}

/// How a run ends whose session has this keeper.
Phase run(const Experiment& experiment, RunKeeper& keeper, SessionFacts& facts) {
  SessionOptions options;
  options.sinks = {&keeper};
  options.crops = &keeper.crops();
  auto session = Session::open(experiment, Session::Clock::virtual_, options);
  EXPECT_TRUE(session) << session.error();
  const Phase end = (*session)->run();
  (*session)->close();
  facts = facts_of(**session, end);
  return end;
}

TEST(RunKeeper, KeepsARunAsTheCommandLineDoes) {
  const Folder place;
  const Experiment experiment = seconds(2);
  RunKeeper keeper;
  EXPECT_FALSE(keeper.keeps());
  ASSERT_TRUE(keeper.begin({place / "runs", {}, {}, {"window"}, true, experiment.source}, experiment));
  EXPECT_TRUE(keeper.keeps());
  SessionFacts facts;
  EXPECT_EQ(run(experiment, keeper, facts), Phase::finished);
  const auto ended = keeper.end(facts);
  EXPECT_TRUE(ended) << ended.error();
  EXPECT_FALSE(keeper.keeps());
  EXPECT_EQ(keeper.problem(), "");
  EXPECT_EQ(find_run("last", place / "runs").value_or(""), keeper.folder());
  const auto found = verify_run(keeper.folder());
  ASSERT_TRUE(found) << found.error();
  for (const Verification::Step& step : found->steps) EXPECT_TRUE(step.holds) << step.what << ": " << step.finding;
  const auto story = read_story(keeper.folder()).value();
  EXPECT_EQ(story["state"], "finished");
  EXPECT_EQ(story["exit_status"], 0);
  EXPECT_EQ(story["summary"]["ticks"], 50);
}

TEST(RunKeeper, SaysWhatTheOperatorChangedAsSetsThatRepeatTheRun) {
  const Folder place;
  const std::string written = seconds(3).source;
  const Experiment experiment =
      parse_experiment(written, "e.toml", {"controller.coupling=bounded", "duration=2"}).value();
  RunKeeper keeper;
  ASSERT_TRUE(keeper.begin({place / "runs", {}, {}, {"window"}, true, written}, experiment));
  SessionOptions options;
  options.sinks = {&keeper};
  auto session = Session::open(experiment, Session::Clock::virtual_, options);
  ASSERT_TRUE(session) << session.error();
  int asked = 0;  // every 16 ticks
  const Phase end = (*session)->run([&] {
    if (++asked == 2) {
      EXPECT_TRUE((*session)->set_gain(core::GainName::k_xx, 0.05));
    }
    if (asked == 3) {
      EXPECT_TRUE((*session)->couple(0, 1, false));
    }
    return true;
  });
  (*session)->close();
  ASSERT_TRUE(keeper.end(facts_of(**session, end)));

  const auto story = read_story(keeper.folder()).value();
  const auto sets = story["sets"].get<std::vector<std::string>>();
  ASSERT_EQ(sets.size(), 4u) << story["sets"].dump(1);
  EXPECT_EQ(sets[0], "controller.coupling=\"bounded\"");
  EXPECT_EQ(sets[1], "duration=2");
  EXPECT_EQ(sets[2].substr(0, 12), "operator.1={") << sets[2];
  EXPECT_NE(sets[3].find("uncouple"), std::string::npos) << sets[3];

  const auto again = load_experiment(keeper.folder() + '/' + run_files::as_written, sets);
  ASSERT_TRUE(again) << again.error().front().message();
  RunKeeper repeated;
  ASSERT_TRUE(repeated.begin({place / "again", {}, {}, {}, true, again->source}, *again));
  SessionFacts facts;
  EXPECT_EQ(run(*again, repeated, facts), Phase::finished);
  ASSERT_TRUE(repeated.end(facts));
  for (const char* const figure : {"final_error", "min_distance"})
    EXPECT_EQ(read_story(repeated.folder()).value()["summary"].at(figure), story["summary"].at(figure)) << figure;
  EXPECT_TRUE(read_story(repeated.folder()).value()["sets"].empty()) << "its file has everything";
}

TEST(RunKeeper, ComparesWithTheFileWithoutCheckingItOnceMore) {
  const Folder place;
  const Experiment experiment = seconds(2);
  std::string refused = experiment.source;  // as somebody has edited it since
  const std::size_t rate = refused.find("rate = 25.0");
  ASSERT_NE(rate, std::string::npos);
  refused.replace(rate, 11, "rate = -3.0");
  RunKeeper keeper;
  ASSERT_TRUE(keeper.begin({place / "runs", {}, {}, {"window"}, true, refused}, experiment));
  SessionFacts facts;
  EXPECT_EQ(run(experiment, keeper, facts), Phase::finished);
  ASSERT_TRUE(keeper.end(facts));
  const auto sets = read_story(keeper.folder()).value()["sets"].get<std::vector<std::string>>();
  ASSERT_EQ(sets.size(), 1u);
  EXPECT_EQ(sets[0].substr(0, 7), "rate=25") << sets[0];
}

/// Robot 2 vanishes from the picture.
TEST(RunKeeper, HasThePicturesOfTagsThatWereNotSeenWithTheirSentences) {
  const Folder place;
  const auto experiment = parse_experiment(
      paper_experiment().source, "e.toml",
      {"duration=2", "perturb=[]", "camera.source=synthetic", "operator.1={t=0.4, does=\"move r2 x=3 y=3 theta=0\"}"});
  ASSERT_TRUE(experiment) << experiment.error().front().message();
  RunKeeper keeper;
  ASSERT_TRUE(keeper.begin({place / "runs", {}, {}, {"window"}, true, experiment->source}, *experiment));
  SessionFacts facts;
  EXPECT_EQ(run(*experiment, keeper, facts), Phase::finished);
  ASSERT_TRUE(keeper.end(facts));
  const std::string folder = keeper.folder();
  const auto story = read_story(folder).value();
  ASSERT_TRUE(story.contains("not_seen"));
  EXPECT_EQ(story["not_seen"].dump(), R"([{"robot":2,"sentence":"no tag 2 is in the picture","file":"tag-2.png"}])");
  ASSERT_TRUE(story["files"].contains("tag-2.png"));
  const auto found = verify_run(folder);
  ASSERT_TRUE(found) << found.error();
  for (const Verification::Step& step : found->steps) EXPECT_TRUE(step.holds) << step.what << ": " << step.finding;

  const auto page = page_of_run(folder + "/run.csv", folder);
  ASSERT_TRUE(page) << page.error();
  EXPECT_NE(page->html.find("src=\"data:image/png;base64,iVBORw0KGgo"), std::string::npos);
  EXPECT_NE(page->html.find("<figcaption>Robot 2: no tag 2 is in the picture</figcaption>"), std::string::npos);

  // What is seen later is of no run any more.
  keeper.crops().add({0, "tag-1.png", "dark", std::make_shared<const Picture>(Picture{2, 1, {0, 255}})});
  EXPECT_TRUE(verify_run(folder)->holds());
}

TEST(RunKeeper, ThePageTakesNoFileFromOutsideTheFolder) {
  const Folder place;
  const Experiment experiment = seconds(1);
  RunKeeper keeper;
  ASSERT_TRUE(keeper.begin({place / "runs", {}, {}, {"window"}, true, experiment.source}, experiment));
  SessionFacts facts;
  EXPECT_EQ(run(experiment, keeper, facts), Phase::finished);
  ASSERT_TRUE(keeper.end(facts));
  const std::string folder = keeper.folder();
  std::ofstream(place / "runs/secret.png") << "secret";
  auto story = read_story(folder).value();
  EXPECT_FALSE(story.contains("not_seen"));
  story["not_seen"] = {{{"robot", 1}, {"sentence", "<b>"}, {"file", "../secret.png"}},
                       {{"robot", 0}, {"sentence", "nobody"}, {"file", "figure3.png"}},
                       {{"robot", 2}, {"sentence", 7}, {"file", 8}}};
  std::ofstream(folder + "/run.json") << sealed(story);
  const auto page = page_of_run(folder + "/run.csv", folder);
  ASSERT_TRUE(page) << page.error();
  EXPECT_NE(page->html.find("<figure><figcaption>Robot 1: &lt;b&gt;</figcaption>"), std::string::npos);
  EXPECT_EQ(page->html.find("nobody"), std::string::npos);
  EXPECT_NE(page->html.find("<figcaption>Robot 2: </figcaption>"), std::string::npos);
}

TEST(RunKeeper, WithoutABeginningTakesNothing) {
  RunKeeper keeper;
  SessionFacts facts;
  EXPECT_EQ(run(seconds(1), keeper, facts), Phase::finished);
  EXPECT_FALSE(keeper.keeps());
  EXPECT_TRUE(keeper.end(facts));
  EXPECT_EQ(keeper.folder(), "");
}

TEST(RunKeeper, AFullDiskEndsTheRecordAndNotTheRun) {
  const Folder place;
  const Experiment experiment = seconds(60);
  RunKeeper keeper;
  ASSERT_TRUE(keeper.begin({place / "runs", {}, {}, {}, true, experiment.source}, experiment));
  SessionFacts facts;
  {
    const SmallDisk disk(200'000);
    EXPECT_EQ(run(experiment, keeper, facts), Phase::finished);
  }
  EXPECT_EQ(facts.failure, "");
  (void)keeper.end(facts);
  EXPECT_NE(keeper.problem().find("run.csv"), std::string::npos) << keeper.problem();
  const auto story = read_story(keeper.folder()).value();
  EXPECT_EQ(story["summary"]["ticks"], 1500) << "the results are those of the whole run";
  const std::string problems = story["problems"].dump();
  EXPECT_NE(problems.find("the record of the run is not complete: "), std::string::npos) << problems;
}

/// Between two disks a film is copied. Of one that does not fit nothing stays, and the reason is that of the disk.
TEST(RunKeeper, AFilmForWhichThereIsNoRoomIsSaidAndTakesNone) {
  const Folder place;
  std::string other = "/dev/shm/skein-film-XXXXXX";
  struct stat here {};
  struct stat there {};
  const int film = ::mkstemp(other.data());
  if (film < 0 || ::fstat(film, &there) != 0 || ::stat(place.path.c_str(), &here) != 0 || here.st_dev == there.st_dev)
    GTEST_SKIP() << "there is no other disk";
  EXPECT_EQ(::ftruncate(film, 1'000'000), 0);
  ::close(film);
  const Experiment experiment = seconds(1);
  RunKeeper keeper;
  ASSERT_TRUE(keeper.begin({place / "runs", {}, {}, {}, true, experiment.source}, experiment));
  SessionFacts facts;
  EXPECT_EQ(run(experiment, keeper, facts), Phase::finished);
  {
    const SmallDisk disk(500'000);
    EXPECT_EQ(keeper.end(facts, other).error(),
              fmt::format("{}: cannot be copied to {}/film.mkv: File too large", other, keeper.folder()));
  }
  std::filesystem::remove(other);
  EXPECT_FALSE(std::filesystem::exists(keeper.folder() + "/film.mkv"));
  EXPECT_EQ(read_story(keeper.folder()).value()["state"], "finished");
}

TEST(RunKeeper, APlaceThatCannotBeWrittenIsSaid) {
  RunKeeper keeper;
  const auto begun = keeper.begin({"/proc/none", {}, {}, {}, true}, paper_experiment());
  ASSERT_FALSE(begun);
  EXPECT_NE(begun.error().find("/proc/none"), std::string::npos);
  EXPECT_FALSE(keeper.keeps());
}

}  // namespace
}  // namespace skein::app
