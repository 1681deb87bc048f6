// Search for gains: what it refuses, that it repeats, and that every point of the front is what it says.
#include "app/tools/tune.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <sstream>

#include "app/experiment/certificate.h"
#include "app/experiment/experiment_file.h"
#include "app/record/report.h"
#include "tests/app/folder.h"
#include "tests/files.h"
#include "tests/places.h"

namespace skein::app {
namespace {

using ::testing::AllOf;
using ::testing::HasSubstr;
using ::testing::Not;

const auto go_on = [](std::int64_t) { return true; };

/// A small search: three kicks of the platoon, and gains that are known to be poor to begin with.
Study small(const std::string& tune_table = {}, const std::string& rest = {}) {
  const auto path = std::filesystem::temp_directory_path() / ("skein-tune-" + std::to_string(::getpid()) + ".toml");
  std::ofstream(path)
      << "experiment = \"" << test::in_source("resources/experiments/platoon.toml") << "\"\n"
      << "runs = 3\nset = [\"duration=16\", \"perturb=[]\", \"controller.k_y=3\", \"controller.c_x=3\"]\n"
      << rest << "[hand]\nt = 1.0\ndistance = [0.05, 0.12]\n[tune]\n"
      << (tune_table.empty() ? "objectives = 3\ncandidates = 40\nheld_out = 12\nlimited_share = 1.0\n"
                               "effort = 100.0\ndelay_margin = 0.02\n"
                             : tune_table)
      << "[tune.search]\n\"controller.k_y\" = [3, 12]\n\"controller.c_x\" = [2, 40]\n"
      << "\"controller.gains.k_xx\" = [0.0, 0.0145]\n";
  auto study = load_study(path.string());
  std::filesystem::remove(path);
  if (!study) ADD_FAILURE() << study.error().front().message();
  return study ? *study : Study{};
}

std::string refusal(const std::string& text) {
  const auto path = std::filesystem::temp_directory_path() / ("skein-tune-" + std::to_string(::getpid()) + ".toml");
  std::ofstream(path) << "experiment = \"" << test::in_source("resources/experiments/platoon.toml") << "\"\n" << text;
  const auto study = load_study(path.string());
  std::filesystem::remove(path);
  if (!study) return study.error().front().message();
  const auto tuned = tune(*study, 1, go_on);
  return tuned ? "" : tuned.error();
}

TEST(Tune, SaysWhatIsWrongWithItsStudy) {
  EXPECT_THAT(refusal("runs = 1\n[hand]\n"), HasSubstr("no table [tune]"));
  EXPECT_THAT(refusal("[hand]\n[tune]\ncandidates = 5\n"), AllOf(HasSubstr(":3:"), HasSubstr("tune.search: missing")));
  EXPECT_THAT(refusal("[hand]\n[tune]\n[tune.search]\n"), HasSubstr("at least one key"));
  EXPECT_THAT(refusal("[hand]\n[tune.search]\n\"controller.k_y\" = [4, 4]\n"),
              AllOf(HasSubstr(":4:"), HasSubstr("low below high")));
  EXPECT_THAT(refusal("[hand]\n[tune.search]\n\"controller.k_y\" = 4\n"), HasSubstr("[low, high]"));
  EXPECT_THAT(refusal("[hand]\n[tune]\ncandidates = 0\n[tune.search]\n\"controller.k_y\" = [4, 5]\n"),
              AllOf(HasSubstr("tune.candidates"), HasSubstr("found 0")));
  EXPECT_THAT(refusal("[tune.search]\n\"controller.k_y\" = [4, 5]\n"), HasSubstr("no table [hand]"));
  EXPECT_THAT(refusal("[hand]\n[tune.search]\n\"controller.wings\" = [4, 5]\n"),
              AllOf(HasSubstr("\"controller.wings\""), HasSubstr("controller.k_y")));
  EXPECT_THAT(refusal("[hand]\n[vary]\n\"controller.k_y\" = [4, 5]\n[tune.search]\n\"controller.k_y\" = [4, 5]\n"),
              HasSubstr("[vary] leaves alone"));
  EXPECT_THAT(refusal("set = [\"controller.gains.k_xx=[[1, 2, 0.01]]\"]\n[hand]\n[tune.search]\n"
                      "\"controller.gains.k_xx\" = [0.001, 0.01]\n"),
              HasSubstr("one value for all pairs"));
  EXPECT_THAT(refusal("set = [\"controller.c_theta=500\"]\n[hand]\n[tune.search]\n\"controller.k_y\" = [4, 5]\n"),
              AllOf(HasSubstr("`skein check` refuses"), HasSubstr("UNSTABLE")));
  EXPECT_THAT(refusal("set = [\"duration=2\"]\n[hand]\nt = 3.0\n[tune.search]\n\"controller.k_y\" = [4, 5]\n"),
              HasSubstr("hand.t"));
  // All times would be the same, whatever the gains.
  EXPECT_THAT(refusal("runs = 2\nset = [\"duration=2\", \"perturb=[]\"]\n[hand]\nt = 1.0\n"
                      "[tune.search]\n\"controller.k_y\" = [4, 5]\n"),
              HasSubstr("none of 2 kicks has settled 1 s later"));
}

TEST(Tune, FindsGainsThatAreBetterOnKicksThatItHasNotSeen) {
  const Study study = small();
  const auto tuned = tune(study, 2, go_on);
  ASSERT_TRUE(tuned) << tuned.error();
  ASSERT_FALSE(tuned->front.empty());
  EXPECT_EQ(tuned->candidates, 3 * 40);
  EXPECT_LE(tuned->runs, most_runs(study) + 12 * (1 + static_cast<std::int64_t>(tuned->front.size())));
  const TunedPoint& chosen = tuned->front[tuned->chosen];
  EXPECT_TRUE(chosen.better_in_both(tuned->own)) << as_table(study, *tuned);
  EXPECT_FALSE(tuned->own.better_in_both(tuned->own));
  EXPECT_THAT(verdict(*tuned), HasSubstr("point"));
}

TEST(Tune, EveryPointOfTheFrontIsWhatItSays) {
  const Study study = small();
  const auto tuned = tune(study, 2, go_on);
  ASSERT_TRUE(tuned) << tuned.error();
  const auto mean = [](const std::vector<RunOutcome>& runs, const std::optional<double> RunOutcome::*value) {
    double sum = 0.0;
    for (const RunOutcome& run : runs) sum += (run.*value).value_or(15.0);
    return sum / static_cast<double>(runs.size());
  };
  for (const TunedPoint& p : tuned->front) {
    // No other candidate that keeps the constraints is as good in both and better in one.
    for (const TunedPoint& q : tuned->tried)
      EXPECT_FALSE(q.searched.formation <= p.searched.formation && q.searched.tracking <= p.searched.tracking &&
                   (q.searched.formation < p.searched.formation || q.searched.tracking < p.searched.tracking));
    // Its experiment file has its numbers, and `skein check` is content with it.
    const auto text = experiment_with(study, p, "tuned.toml");
    ASSERT_TRUE(text) << text.error();
    const auto experiment = parse_experiment(*text, "tuned.toml");
    ASSERT_TRUE(experiment) << experiment.error().front().message();
    EXPECT_EQ(experiment->controller.c_x, p.values[0]);  // in the order of their names
    EXPECT_EQ(experiment->controller.gains.k_xx(0, 1), p.values[1]);
    EXPECT_EQ(experiment->controller.k_y, p.values[2]);
    const Certificate certificate = certify(*experiment);
    EXPECT_TRUE(certificate.sound()) << as_lines(certificate);
    EXPECT_GE(certificate.delay.margin.delay, 0.02);
    EXPECT_GE(p.delay_margin, 0.02);
    // Its means are those of the same runs by `skein sweep`, on the kicks of the search and on those held out.
    Study again = study;
    for (const std::string& set : sets_of(*study.tune, p)) again.sets.push_back(set);
    const auto searched = sweep(again, 1, [](std::size_t) { return true; });
    EXPECT_DOUBLE_EQ(p.searched.formation, mean(searched, &RunOutcome::relative_settled));
    EXPECT_DOUBLE_EQ(p.searched.tracking, mean(searched, &RunOutcome::tracking_settled));
    again.seed = 4;
    again.runs = 12;
    const auto held_out = sweep(again, 1, [](std::size_t) { return true; });
    EXPECT_DOUBLE_EQ(p.held_out.formation, mean(held_out, &RunOutcome::relative_settled));
    EXPECT_EQ(p.formation_more.pairs, 12U);
  }
  for (std::size_t i = 1; i < tuned->front.size(); ++i) {
    EXPECT_LT(tuned->front[i - 1].searched.formation, tuned->front[i].searched.formation);
    EXPECT_GT(tuned->front[i - 1].searched.tracking, tuned->front[i].searched.tracking);
  }
}

TEST(Tune, TheSameStudyGivesTheSameFrontWhateverTheThreads) {
  Study study = small();
  study.tune->candidates = 12;
  const auto one = tune(study, 1, go_on), three = tune(study, 3, go_on);
  ASSERT_TRUE(one && three);
  EXPECT_EQ(as_csv(study, *one), as_csv(study, *three));
  study.seed = 100;
  const auto other = tune(study, 1, go_on);
  ASSERT_TRUE(other);
  EXPECT_NE(as_csv(study, *one), as_csv(study, *other)) << "another seed, other kicks and another search";
}

TEST(Tune, KeepsItsConstraints) {
  const auto with = [](const std::string& constraint) {
    const Study study = small("objectives = 2\ncandidates = 10\nheld_out = 1\n" + constraint);
    auto tuned = tune(study, 2, go_on);
    EXPECT_TRUE(tuned) << tuned.error();
    return tuned ? std::move(*tuned) : Tuned{};
  };
  const Tuned slow = with("effort = 1e-6\nlimited_share = 1.0\ndelay_margin = 0.001\n");
  EXPECT_TRUE(slow.front.empty());
  EXPECT_EQ(slow.unaffordable + slow.uncertified, 20);
  EXPECT_THAT(verdict(slow), HasSubstr("no candidate"));
  const Tuned never = with("effort = 1e6\nlimited_share = 1.0\ndelay_margin = 9.0\n");
  EXPECT_EQ(never.uncertified, 20);
  EXPECT_EQ(never.runs, 3 + 1) << "what is not certified does not run";
  EXPECT_THAT(verdict(never), HasSubstr("none is certified. The first is controller."));
  EXPECT_THAT(verdict(never), HasSubstr("s, allowed: at least 9 s"));
  EXPECT_THAT(verdict(slow), Not(HasSubstr("The first is"))) << "some were";
  // Without numbers they are the experiment's own.
  for (const Tuned& own = with(""); const TunedPoint& p : own.tried) {
    EXPECT_GE(p.delay_margin, own.own.delay_margin * (1.0 - 1e-9));
    EXPECT_LE(p.searched.limited_share, own.own.searched.limited_share * (1.0 + 1e-9));
    EXPECT_LE(p.searched.effort, own.own.searched.effort * (1.0 + 1e-9));
    EXPECT_EQ(p.searched.collisions, 0);
  }
}

/// An hour's search must not end with a file that cannot be read.
TEST(Tune, ThePointOfAnExperimentWithOtherFilesIsReadWhereverItIsSaved) {
  const test::Folder lab;
  std::filesystem::create_directories(lab / "found");
  std::ofstream(lab / "place.csv") << "t,x,y\n0,0,0\n10,0.5,0\n";
  std::ofstream(lab / "e.toml") << "# mine\nreference.kind = \"independent\"\n[controller]\nk_y = 9 # stiff\n"
                                   "[[robot]]\ntrajectory = { csv = \"place.csv\" }\n";
  Study study;
  study.experiment = lab / "e.toml";
  study.text = test::read_file(study.experiment);
  study.tune = Study::Tune{};
  study.tune->search = {{"controller.k_y", {4.0, 12.0}}};
  TunedPoint point;
  point.values = {5.0};
  for (const std::string& file : {lab / "tuned.toml", lab / "found/tuned.toml"}) {
    const auto text = experiment_with(study, point, file);
    ASSERT_TRUE(text) << text.error();
    EXPECT_THAT(*text, AllOf(HasSubstr("# mine\n"), HasSubstr("k_y = 5 # stiff")));
    std::ofstream(file) << *text;
    const auto experiment = load_experiment(file);
    EXPECT_TRUE(experiment) << experiment.error().front().message();
  }
  EXPECT_THAT(test::read_file(lab / "tuned.toml"), HasSubstr("\"place.csv\"")) << "beside it the names still hold";
}

TEST(Tune, EndsWhenItIsTold) {
  const auto tuned = tune(small(), 1, [](std::int64_t made) { return made < 10; });
  ASSERT_FALSE(tuned);
  EXPECT_THAT(tuned.error(), HasSubstr("stopped after"));
}

TEST(Tune, DrawsTheFront) {
  const auto folder = std::filesystem::temp_directory_path() / ("skein-front-" + std::to_string(::getpid()));
  ASSERT_TRUE(check_report(folder.string())) << "gnuplot is there";
  Study study = small();
  study.tune->candidates = 15;
  const auto tuned = tune(study, 2, go_on);
  ASSERT_TRUE(tuned) << tuned.error();
  ASSERT_FALSE(tuned->front.empty());
  const auto done = write_front(folder.string(), study, *tuned);
  EXPECT_TRUE(done) << done.error();
  for (const char* kind : {".pdf", ".svg", ".png"})
    EXPECT_GT(std::filesystem::file_size(folder / (std::string("front") + kind)), 3000U) << kind;
  EXPECT_EQ(test::read_file(folder / "front.csv"), as_csv(study, *tuned));
  EXPECT_TRUE(load_experiment((folder / "point-1.toml").string()));
  // Of an earlier search that found more nothing is left: it would seem to be of this one.
  Tuned none = *tuned;
  none.front.clear();
  for (const char* const earlier : {"point-2.toml", "point-3.toml"})
    std::filesystem::copy_file(folder / "point-1.toml", folder / earlier,
                               std::filesystem::copy_options::overwrite_existing);
  EXPECT_TRUE(write_front(folder.string(), study, none));
  for (const char* const earlier : {"point-1.toml", "point-3.toml", "front.svg", "front.gp"})
    EXPECT_FALSE(std::filesystem::exists(folder / earlier)) << earlier;
  EXPECT_TRUE(std::filesystem::exists(folder / "front.csv")) << "the control";
  std::filesystem::remove_all(folder);
}

}  // namespace
}  // namespace skein::app
