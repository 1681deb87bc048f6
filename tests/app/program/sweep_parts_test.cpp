// A study in parts, each a process of its own, as a cluster runs it: merged, it is the study of one machine, bit for
// bit.
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/wait.h>

#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <sstream>
#include <string>

#include "tests/app/folder.h"
#include "tests/files.h"
#include "tests/places.h"

namespace {

using ::testing::HasSubstr;
using ::testing::Not;

class Parts : public ::testing::Test {
 public:
  Parts() {
    std::filesystem::create_directories(folder_);
    std::ofstream(folder_ / "study.toml")
        << "name = \"parts\"\nexperiment = \"" << skein::test::in_source("resources/experiments/platoon.toml") << "\"\n"
        << "runs = 13\nset = [\"duration=5\", \"perturb=[]\"]\ncontrol = [\"controller.gains.k_xx=0\"]\n"
        << "[vary]\n\"reference.start\" = [0.0, 4.196]\n[hand]\nt = 1.0\nrobots = 2\n"
        << "[compare]\n\"stiff, coupled\" = [\"controller.gains.k_xx=0.012\"]\n";
  }

  std::string read(const std::string& name) const { return skein::test::read_file(folder_ / name); }
  /// Lines of a shell in the test's folder, `$skein` being the sweep of the study; their exit status.
  int shell(const std::string& lines) const {
    const std::string all =
        "cd '" + folder_.string() + "' && skein='" + skein::test::program() +
        " sweep study.toml'\nunset SLURM_ARRAY_TASK_ID SLURM_PROCID PMI_RANK OMPI_COMM_WORLD_RANK\n" + lines;
    const int status = std::system(all.c_str());
    return WIFEXITED(status) ? WEXITSTATUS(status) : 128;
  }

  const skein::test::Folder own_folder_;
  const std::filesystem::path folder_ = own_folder_.path;
};

TEST_F(Parts, MergedAreTheStudyOfOneMachineBitForBit) {
  EXPECT_EQ(shell("$skein --csv whole.csv --json > whole.json"), 0) << read("whole.json");
  EXPECT_EQ(shell("for i in 1 2 3 4; do $skein --part $i/4 --into parts --threads 1 > part$i.txt & done; wait"), 0);
  EXPECT_THAT(read("part2.txt"), HasSubstr("part: 2 of 4\nruns: 3\nkept: parts/part-2-of-4.csv\n"));
  EXPECT_EQ(shell("$skein --merge parts --csv merged.csv --json > merged.json"), 0);
  EXPECT_EQ(read("whole.csv"), read("merged.csv"));
  EXPECT_EQ(read("whole.json"), read("merged.json"));
  const std::string document = skein::test::read_file(skein::test::in_source("docs/studies.md"));
  std::istringstream header(read("merged.csv").substr(0, read("merged.csv").find('\n')));
  for (std::string column; std::getline(header, column, ',');) EXPECT_THAT(document, HasSubstr("`" + column + "`"));
  EXPECT_THAT(read("merged.json"), HasSubstr("\"runs\": 13"));
  EXPECT_THAT(read("merged.csv"), HasSubstr("\ncontrol,13,"));
  EXPECT_THAT(read("merged.csv"), HasSubstr("\n\"stiff, coupled\",13,"));
  EXPECT_THAT(read("merged.json"), HasSubstr("\"stiff, coupled\": {"));
}

TEST_F(Parts, ThoseThatWereKilledAreNamedAndMadeAgain) {
  // The shell kills the third by itself, so that the number is surely its child's.
  EXPECT_EQ(shell("for i in 1 3; do $skein --part $i/3 --into parts --quiet || exit 9; done\n"
                  "timeout -s KILL 0.05 $skein --runs 10000000 --part 2/3 --into parts --quiet; :"),
            0);
  EXPECT_EQ(shell("$skein --merge parts > merged.txt 2> said.txt"), 1);
  EXPECT_THAT(read("said.txt"),
              HasSubstr("part 2 of 3: it is not there: skein sweep 'study.toml' --part 2/3 --into 'parts'"));
  EXPECT_THAT(read("said.txt"), HasSubstr("1 of 3 parts are missing"));
  EXPECT_EQ(read("merged.txt"), "");

  // Torn by a full disk or a copy that broke off: no part either.
  EXPECT_EQ(shell("$skein --part 2/3 --into parts --quiet && cp parts/part-2-of-3.csv kept && "
                  "head -c -20 kept > parts/part-2-of-3.csv"),
            0);
  EXPECT_EQ(shell("$skein --merge parts > merged.txt 2> said.txt"), 1);
  EXPECT_THAT(read("said.txt"), HasSubstr("torn"));
  // Nor is one with another digit, wherever it is.
  EXPECT_EQ(shell("sed '/^study,/s/0\\.1/0.2/' kept > parts/part-2-of-3.csv && ! cmp -s kept parts/part-2-of-3.csv"),
            0);
  EXPECT_EQ(shell("$skein --merge parts > merged.txt 2> said.txt"), 1);
  EXPECT_THAT(read("said.txt"), HasSubstr("part-2-of-3.csv: it has been changed since it was computed"));
  EXPECT_EQ(shell("$skein --part 2/3 --into parts > again.txt && cmp kept parts/part-2-of-3.csv"), 0);
  EXPECT_THAT(read("again.txt"), Not(HasSubstr("already")));
  EXPECT_EQ(shell("$skein --part 2/3 --into parts > again.txt"), 0);
  EXPECT_THAT(read("again.txt"), HasSubstr("already there"));
  EXPECT_EQ(shell("$skein --merge parts > merged.txt && $skein > whole.txt && cmp merged.txt whole.txt"), 0);
}

TEST_F(Parts, OfAnotherStudyAreRefused) {
  EXPECT_EQ(shell("for i in 1 2; do $skein --runs 2 --part $i/2 --into parts --quiet || exit 9; done"), 0);
  EXPECT_EQ(shell("$skein --runs 2 --set controller.k_y=9 --merge parts 2> said.txt"), 1);
  EXPECT_THAT(read("said.txt"), HasSubstr("to another study, other --runs, --seed or --set, or another program"));
  EXPECT_EQ(shell("$skein --runs 2 --merge parts --quiet 2> said.txt"), 0) << read("said.txt");
  // Of one part that is wrong, what is wrong with it.
  const auto said_of = [&](const std::string& change) {
    EXPECT_EQ(shell("rm -rf p; cp -r parts p; " + change + "; $skein --runs 2 --merge p 2> said.txt"), 1);
    return read("said.txt");
  };
  EXPECT_THAT(said_of("cp p/part-1-of-2.csv p/part-2-of-2.csv"),
              HasSubstr("p/part-2-of-2.csv: it is part 1 of 2 of \""));
  EXPECT_THAT(said_of(": > p/part-2-of-2.csv"), HasSubstr("p/part-2-of-2.csv: it is empty: skein sweep"));
  EXPECT_THAT(said_of("head -c 60 parts/part-2-of-2.csv > p/part-2-of-2.csv"),
              HasSubstr("torn within its first lines"));
  EXPECT_THAT(said_of("sed -i '1s/.*/# skein 0.0.9 (abc)/' p/part-2-of-2.csv"),
              HasSubstr("p/part-2-of-2.csv: it was computed by skein 0.0.9 (abc), allowed: skein "));
  EXPECT_EQ(shell("$skein --runs 2 --part 1/3 --into parts --quiet && $skein --runs 2 --merge parts 2> said.txt"), 2);
  EXPECT_THAT(read("said.txt"), HasSubstr("use a folder for each"));
  EXPECT_EQ(shell("$skein --merge nowhere 2> said.txt"), 2);
  EXPECT_THAT(read("said.txt"), HasSubstr("nowhere: cannot be read"));
}

TEST_F(Parts, JobsSayThemselvesWhichPartIsTheirs) {
  EXPECT_EQ(shell("SLURM_ARRAY_TASK_ID=2 SLURM_ARRAY_TASK_MIN=1 SLURM_ARRAY_TASK_MAX=3 SLURM_ARRAY_TASK_COUNT=3 "
                  "$skein --runs 3 --part auto --into parts > said.txt"),
            0);
  EXPECT_THAT(read("said.txt"), HasSubstr("part: 2 of 3"));
  EXPECT_EQ(shell("OMPI_COMM_WORLD_RANK=0 OMPI_COMM_WORLD_SIZE=2 $skein --runs 3 --part auto --into mpi > said.txt"),
            0);
  EXPECT_THAT(read("said.txt"), HasSubstr("part: 1 of 2"));
  EXPECT_EQ(shell("SLURM_ARRAY_TASK_ID=7 SLURM_ARRAY_TASK_MIN=3 SLURM_ARRAY_TASK_MAX=7 SLURM_ARRAY_TASK_COUNT=2 "
                  "$skein --runs 3 --part auto --into parts 2> said.txt"),
            2);
  EXPECT_THAT(read("said.txt"), HasSubstr("this Slurm array is incomplete"));
  EXPECT_EQ(shell("$skein --part auto --into parts 2> said.txt"), 2);
  EXPECT_THAT(read("said.txt"), HasSubstr("allowed here: i/n"));
  for (const char* part : {"0/3", "4/3", "1", "1/0", "a/b", "1/3x"})
    EXPECT_EQ(shell(std::string("$skein --part ") + part + " --into parts 2> said.txt"), 2) << part;
  EXPECT_THAT(read("said.txt"), HasSubstr("found \"1/3x\""));
}

TEST_F(Parts, APlanSaysWhatAMillionRunsCostAndHowTheyAreStarted) {
  EXPECT_EQ(shell("$skein --plan --runs 1000000 --threads 2 > plan.txt"), 0);
  const std::string plan = read("plan.txt");
  EXPECT_THAT(plan, HasSubstr("study: parts\nruns: 1000000\ndrives_per_run: 3\nsampled_runs: 32\nseconds_per_run: "));
  const auto number = [&](const std::string& key) {
    const auto at = plan.find("\n" + key + ": ");
    return at == std::string::npos ? std::nan("") : std::strtod(plan.c_str() + at + key.size() + 3, nullptr);
  };
  const double hours = 1e6 * number("seconds_per_run") / 3600.0;
  EXPECT_GT(hours, 0.0);
  EXPECT_NEAR(number("core_hours") / hours, 1.0, 0.01);
  EXPECT_NEAR(number("hours_on_64_cores") * 64.0 / hours, 1.0, 0.01);
  EXPECT_GE(number("parts"), number("core_hours") * 0.99);
  const std::string parts = std::to_string(static_cast<int>(number("parts")));
  EXPECT_THAT(plan, HasSubstr("slurm: STUDY='study.toml' PARTS=" + parts + " WORDS='--runs 1000000' sbatch --array=1-" +
                              parts + " --export=ALL "));
  EXPECT_THAT(plan, HasSubstr("merge: skein sweep 'study.toml' --runs 1000000 --merge parts\n"));
  EXPECT_EQ(shell("$skein --plan --csv rows.csv 2> said.txt"), 2);
  EXPECT_THAT(read("said.txt"), HasSubstr("--csv"));
  // What it prints for Slurm is what a task runs.
  EXPECT_EQ(
      shell("printf '#!/bin/sh\nfor a; do script=$a; done; SLURM_ARRAY_TASK_ID=1 SKEIN=" + skein::test::program() +
            " exec bash \"$script\"\n' > sbatch && chmod +x sbatch && " + skein::test::program() +
            " sweep study.toml --plan --runs 4 --set duration=4 > small.txt && "
            "PATH=$PWD:$PATH sh -c \"$(sed -n 's/^slurm: //p' small.txt)\" && test -s parts/part-1-of-1.csv"),
      0)
      << read("small.txt");
  // Also of a study and of values with blanks and quotes.
  EXPECT_EQ(
      shell("mv study.toml \"a student's study.toml\"; rm -r parts; " + skein::test::program() +
            " sweep \"a student's study.toml\" --plan --runs 4 --set 'obstacle=[{x = 0.7, y = 0.5, radius = 0.05}]' "
            "--set 'name=\"x\"' > small.txt && PATH=$PWD:$PATH sh -c \"$(sed -n 's/^slurm: //p' small.txt)\" && "
            "sh -c \"PATH=" +
            std::filesystem::path(skein::test::program()).parent_path().string() +
            ":$PATH; $(sed -n 's/^merge: //p' small.txt)\" > merged.txt"),
      0)
      << read("small.txt");
  EXPECT_THAT(read("merged.txt"), HasSubstr("\nruns: 4\n"));
}

}  // namespace
