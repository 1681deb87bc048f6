#include "app/cli/command_line_runs.h"

#include "app/manual/whole_number.h"
#include "core/words.h"

namespace skein::app {

CLI::Option* add_runs_directory(CLI::App& command, std::string& directory) {
  return command
      .add_option("--runs-dir", directory,
                  "folder of the kept runs; default: $SKEIN_RUNS, else $XDG_DATA_HOME/skein/runs, else "
                  "~/.local/share/skein/runs")
      ->type_name("DIR");
}

void RunCommands::add_export(CLI::App& to) {
  to.add_option("run", export_request_.run, "a CSV of a run, or a kept run: its name, its folder, or last")->required();
  to.add_option("--to", format_,
                "csv: without the lines before the header row; mcap: for Foxglove and PlotJuggler; mat: for MATLAB "
                "and Octave")
      ->required()
      ->check(CLI::IsMember({"csv", "mcap", "mat"}));
  to.add_option("--out", export_request_.out,
                "default: RUN.plain.csv, RUN.mcap or RUN.mat, beside a CSV; for a kept run, here")
      ->type_name("FILE");
  to.add_option("--compression", compression_, "of MCAP")
      ->check(CLI::IsMember({"zstd", "none"}))
      ->capture_default_str();
  to.add_flag("--force", export_request_.options.rules.force, "overwrite an existing file");
}

void RunCommands::add_to(CLI::App& program) {
  export_ = program.add_subcommand("export", "Converts a recorded run into a file for other programs (docs/tools.md)");
  add_export(*export_);
  add_runs_directory(*export_, export_request_.directory);

  report_ = program.add_subcommand("report", "Converts a recorded run into one self-contained page");
  report_->add_option("run", page_request_.run, "a CSV of a run, or a kept run: its name, its folder, or last")
      ->required();
  report_->add_flag("--html", html_, "as a page for a browser, the only format so far");
  report_->add_option("--out", page_request_.out, "default: RUN.html, beside a CSV; for a kept run, here")
      ->type_name("FILE");
  report_->add_flag("--force", page_request_.force, "overwrite an existing file");
  add_runs_directory(*report_, page_request_.directory);

  identify_ =
      program.add_subcommand("identify",
                             "Identifies the robots of recorded runs: wheels, track, delay, slip and more, each with a "
                             "95 % interval (docs/robots.md); exit status 1 if the runs do not determine a value");
  identify_
      ->add_option("run", identify_request_.runs,
                   "CSVs of runs, or kept runs: their names, their folders, or last; several runs of one robot give "
                   "narrower intervals")
      ->required();
  identify_->add_flag(
      "--save", identify_request_.save,
      "write wheel_diameter, wheel_ratio, track and actuation_delay, where determined, to the file of robots");
  identify_
      ->add_option("--file", identify_request_.file,
                   "file of robots; default: robots.toml here, else $XDG_CONFIG_HOME/skein/robots.toml")
      ->type_name("ROBOTS.TOML");
  identify_
      ->add_option("--report", identify_request_.report, "write tables and figures of the residuals to this folder")
      ->type_name("DIR");
  identify_->add_flag("--json", identify_request_.json, "print it as JSON");
  add_runs_directory(*identify_, identify_request_.directory);

  CLI::App& runs = *program.add_subcommand(
      "runs", "Lists, finds, compares, verifies and removes kept runs (`skein run --keep`, docs/runs.md)");
  runs.require_subcommand(1);
  const auto add = [&](const char* name, const char* what) {
    CLI::App* const command = runs.add_subcommand(name, what);
    add_runs_directory(*command, runs_request_.directory);
    return command;
  };
  constexpr const char* which = "its name or the beginning of it, its folder, or last";
  const auto table = [&](CLI::App* command) {
    command->add_option("--show", runs_request_.show, "keys to show for each run, e.g. k_xx")
        ->delimiter(',')
        ->type_name("KEY,...");
    command->add_option("--newest", runs_request_.newest, "at most this many")
        ->check(whole_number(1, 1'000'000'000))
        ->type_name("N");
    command->add_flag("--json", runs_request_.json, "print them as JSON");
  };
  list_ = add("list", "Lists all runs, the newest last");
  table(list_);
  show_ = add("show", "Prints everything that is known about a run");
  show_->add_option("run", runs_request_.run, which)->required();
  show_->add_flag("--json", runs_request_.json, "print its run.json");
  find_ = add("find", "Finds the runs for which a condition holds, e.g. 'k_xx > 0.01 and collisions = 0'");
  CLI::Option* const query = find_->add_option("query", runs_request_.query,
                                               "comparisons (= != < <= > >=, ~ for contains) of keys with numbers or "
                                               "texts, combined with and, or, not, brackets");
  find_->add_flag("--keys", runs_request_.keys, "list the available keys instead")->excludes(query);
  table(find_);
  compare_ = add("compare", "Prints the differences between two runs");
  compare_->add_option("run", runs_request_.run, which)->required();
  compare_->add_option("other", runs_request_.other, which)->required();
  compare_->add_flag("--json", runs_request_.json, "print it as JSON");
  verify_ =
      add("verify",
          "Verifies that the record of a run follows from its inputs, bit for bit: hashes, replay, and a repetition");
  verify_->add_option("run", runs_request_.run, which)->required();
  remove_ = add("remove", "Removes runs; without --yes it only prints which, and how much space they take");
  remove_->add_option("run", runs_request_.runs, which);
  remove_
      ->add_option("--where", runs_request_.query,
                   "the runs for which a condition holds, as for `skein runs find`; with names: only those among them")
      ->type_name("QUERY");
  remove_->add_flag("--yes", runs_request_.yes, "remove them");
  export_kept_ =
      runs.add_subcommand("export", "Converts a kept run into a file for other programs, like `skein export`");
  add_export(*export_kept_);
  add_runs_directory(*export_kept_, export_request_.directory);
}

bool RunCommands::may_be_ended() const {
  for (const CLI::App* const command : {report_, identify_, list_, show_, find_, compare_, verify_})
    if (*command) return true;
  return false;
}

std::optional<int> RunCommands::run() {
  if (*export_ || *export_kept_) {
    export_request_.options.format = core::from_word<ExportFormat>(format_).value();
    export_request_.options.compressed = compression_ == "zstd";
    return export_file(export_request_);
  }
  if (*report_) return write_page(page_request_);
  if (*identify_) return identify(identify_request_);
  if (*list_) return list_runs(runs_request_);
  if (*show_) return show_run(runs_request_);
  if (*find_) return find_runs(runs_request_);
  if (*compare_) return compare_runs(runs_request_);
  if (*verify_) return verify_runs(runs_request_);
  if (*remove_) return remove_runs(runs_request_);
  return {};
}

}  // namespace skein::app
