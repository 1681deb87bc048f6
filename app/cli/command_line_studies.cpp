#include "app/cli/command_line_studies.h"

#include <CLI/CLI.hpp>

#include <limits>

#include "app/cli/shipped_file.h"
#include "app/manual/whole_number.h"

namespace skein::app {

namespace {

constexpr std::int64_t largest_seed = std::numeric_limits<std::int64_t>::max();

/// What every command about a study takes.
template <typename Request>
void add_common(CLI::App& command, Request& request, const char* runs) {
  take_shipped_files(
      *command
           .add_option("study", request.file,
                       "study file (TOML), see docs/studies.md, or the name of one that comes with Skein")
           ->required(),
      "studies");
  command.add_option("--runs", request.runs, runs)->check(whole_number(1, 10'000'000))->type_name("N");
  command.add_option("--seed", request.seed, "seed of the first run; each further run adds 1")
      ->check(whole_number(0, largest_seed))
      ->type_name("N");
  command.add_option("--set", request.sets, "key=value: any key of the experiment; repeatable")
      ->type_name("KEY=VALUE")
      ->expected(1)
      ->multi_option_policy(CLI::MultiOptionPolicy::TakeAll);
  command.add_option("--threads", request.threads, "default: one per core that the program may use")
      ->check(whole_number(1, 1024))
      ->type_name("N");
}

}  // namespace

void StudyCommands::add_to(CLI::App& program) {
  sweep_ = program.add_subcommand(
      "sweep", "Runs an experiment many times with the random changes of a study file, and summarises the results");
  SweepRequest& request = sweep_request_;
  add_common(*sweep_, request, "number of runs, instead of the file's");
  CLI::Option* const only =
      sweep_
          ->add_option("--only", request.only, "only the run with this seed, and print the `skein run` that repeats it")
          ->check(whole_number(0, largest_seed))
          ->type_name("SEED");
  CLI::Option* const csv = sweep_->add_option("--csv", request.csv, "one row per run")->type_name("FILE");
  CLI::Option* const report =
      sweep_->add_option("--report", request.report, "write figures of distributions and the worst runs to this folder")
          ->type_name("DIR");
  CLI::Option* const part =
      sweep_
          ->add_option("--part", request.part,
                       "i/n: only the i-th of n parts, for --merge; auto: from the Slurm array or the MPI job")
          ->type_name("i/n")
          ->excludes(only)
          ->excludes(csv)
          ->excludes(report);
  CLI::Option* const into =
      sweep_->add_option("--into", request.into, "the folder for the parts")->type_name("DIR")->needs(part);
  part->needs(into);
  sweep_
      ->add_option("--merge", request.merge,
                   "combine the parts in this folder into the result that a single machine gives; names missing parts")
      ->type_name("DIR")
      ->excludes(part)
      ->excludes(only);
  CLI::Option* const plan = sweep_->add_flag("--plan", request.plan,
                                             "only estimate what the study will cost: measures 32 of its runs here, "
                                             "and prints core-hours and the Slurm array for them");
  for (CLI::Option* const other : {only, csv, report, part, sweep_->get_option("--merge")}) plan->excludes(other);
  sweep_->add_flag("--json", request.json, "print the summary as one JSON object");
  sweep_->add_flag("--quiet", request.quiet, "no progress, no summary");

  tune_ = program.add_subcommand(
      "tune",
      "Searches for gains inside (18): the Pareto front of formation against tracking recovery, every point "
      "certified and measured on kicks that the search has not seen");
  TuneRequest& gains = tune_request_;
  add_common(*tune_, gains, "kicks on which each candidate is tried, instead of the file's runs");
  const auto count = whole_number(1, 1'000'000);
  tune_->add_option("--candidates", gains.candidates, "of each search, instead of the file's tune.candidates")
      ->check(count)
      ->type_name("N");
  tune_->add_option("--held-out", gains.held_out, "kicks held out, instead of the file's tune.held_out")
      ->check(count)
      ->type_name("N");
  tune_->add_option("--csv", gains.csv, "the front, one row per point")->type_name("FILE");
  tune_
      ->add_option("--report", gains.report, "write the front's figure and each point's experiment file to this folder")
      ->type_name("DIR");
  tune_->add_option("--save", gains.save, "write the experiment with the chosen gains to this file, which must be new")
      ->type_name("EXPERIMENT.TOML");
  tune_->add_flag("--quiet", gains.quiet, "no progress, no table");
}

std::optional<int> StudyCommands::run() const {
  if (*sweep_) return sweep(sweep_request_);
  if (*tune_) return tune(tune_request_);
  return {};
}

}  // namespace skein::app
