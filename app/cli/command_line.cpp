#include "app/cli/command_line.h"

#include <fmt/format.h>

#include <unistd.h>
#include <CLI/CLI.hpp>
#include <cerrno>
#include <charconv>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <sstream>

#include "app/cli/candidates.h"
#include "app/cli/command_line_robots.h"
#include "app/cli/command_line_runs.h"
#include "app/cli/command_line_studies.h"
#include "app/cli/command_line_vision.h"
#include "app/cli/commands.h"
#include "app/cli/shipped_file.h"
#include "app/controllers/adversary.h"
#include "app/controllers/library_host.h"
#include "app/experiment/experiment_schema.h"
#include "app/experiment/fault_file.h"
#include "app/experiment/text_file.h"
#include "app/guard/guard.h"
#include "app/guard/run_marker.h"
#include "app/guard/stop_run.h"
#include "app/manual/manual.h"
#include "app/manual/mistakes.h"
#include "app/manual/whole_number.h"
#include "app/run/exit_status.h"
#include "app/run/interrupted.h"
#include "app/run/output.h"
#include "app/run/resources.h"
#include "app/run/terminal_text.h"
#include "app/run/version.h"
#include "comms/crash_stop.h"
#include "comms/emulator/emulate.h"
#include "vision/sources/open_source.h"

namespace skein::app {
namespace {

/// The robots that are no mere simulations.
std::vector<std::string> linked_models() {
  std::vector<std::string> names;
  for (const core::RobotType& type : core::robot_types)
    if (type.motor != core::MotorModel::ideal) names.emplace_back(type.name);
  return names;
}

/// Python starts the program with one end of a pipe: its run ends when that Python has ended, even by SIGKILL.
bool ends_with_its_starter() {
  const char* const given = std::getenv("SKEIN_WHILE_OPEN");
  if (!given) return true;
  const std::string_view text = given;
  int pipe = -1;
  const auto [stop, error] = std::from_chars(text.data(), text.data() + text.size(), pipe);
  const bool good = error == std::errc{} && stop == text.data() + text.size() && interrupt_when_closed(pipe);
  if (!good) complain(fmt::format("SKEIN_WHILE_OPEN={}: allowed: the number of an open pipe", text));
  ::unsetenv("SKEIN_WHILE_OPEN");  // not for those that it starts
  return good;
}

/// What all commands that run or check an experiment have in common.
struct ExperimentOptions {
  std::string file;
  std::vector<std::string> sets;
  std::string duration, seed;
  bool rehearse = false;

  void add_to(CLI::App& command, bool required) {
    auto* option = command.add_option(
        "experiment", file,
        required ? "experiment file (TOML), or the name of one that comes with Skein"
                 : "experiment file (TOML), the name of one that comes with Skein, or a recorded run (CSV) to replay");
    take_shipped_files(*option, "experiments", required ? nullptr : &command);
    if (required) option->required();
    command.add_option("--set", sets, "key=value: any key of the file, e.g. controller.v_max=0.08; repeatable")
        ->type_name("KEY=VALUE")
        ->expected(1)
        ->multi_option_policy(CLI::MultiOptionPolicy::TakeAll);
  }
  void add_run_options(CLI::App& command) {
    command.add_option("--duration", duration, "duration of the experiment [s], instead of the file's")->type_name("S");
    command.add_option("--seed", seed, "seed of all random numbers, instead of the file's")->type_name("N");
    command.add_flag("--rehearse", rehearse,
                     "without the hardware: emulated robots and rendered pictures in place of the real ones");
  }
  ExperimentRequest request() const {
    ExperimentRequest result{file, sets, rehearse};
    if (!duration.empty()) result.sets.push_back("duration=" + duration);
    if (!seed.empty()) result.sets.push_back("seed=" + seed);
    return result;
  }
};

/// What `skein emulate --faults` was given, "random" or a file, as faults; says what is wrong with the file on stderr.
bool read_faults(const std::string& source, comms::EmulateOptions& options) {
  constexpr double a_day = 86400.0, seconds_between_faults = 10.0;
  if (source.empty()) return true;
  if (source == "random") {
    options.faults = comms::random_faults(options.robots, a_day, seconds_between_faults, options.seed);
    return true;
  }
  auto faults = load_faults(source, options.robots);
  if (faults) {
    options.faults = std::move(*faults);
    return true;
  }
  print_error(messages(faults.error()) + "\n");
  return false;
}

/// Becomes the program `name` in this program's folder; returns only where there is none.
int start_beside(const std::string& name, std::vector<std::string> words) {
  std::error_code none;
  const auto path = std::filesystem::read_symlink("/proc/self/exe", none).parent_path() / name;
  words.insert(words.begin(), name);
  std::vector<char*> arguments;
  arguments.reserve(words.size() + 1);
  for (std::string& word : words) arguments.push_back(word.data());
  arguments.push_back(nullptr);
  ::execv(path.c_str(), arguments.data());
  complain(path.string() + ": " + std::strerror(errno) + "; it is a package of its own");
  return wrong_input;
}

int parse_and_do(int argc, char** argv, const ShowWindow& show_window) {
  // Benchmarks are a program of their own, beside this one: what was written for `skein bench` goes on working.
  if (argc > 1 && std::string_view(argv[1]) == "bench") return start_beside("skein-bench", {argv + 2, argv + argc});

  CLI::App program{
      "Skein: real-time lab control for groups of unicycle robots.\nWithout a command it opens the operator's window, "
      "with the paper's experiment unless a file is given.",
      "skein"};
  program.set_version_flag("--version", "skein " + version_and_commit());
  program.require_subcommand(0, 1);
  ExperimentOptions window_experiment;
  window_experiment.add_to(program, false);
  window_experiment.add_run_options(program);

  CLI::App& run_command = *program.add_subcommand("run", "Runs an experiment without a window");
  ExperimentOptions run_experiment;
  RunRequest run_request;
  run_experiment.add_to(run_command, true);
  run_experiment.add_run_options(run_command);
  run_command.add_option("--csv", run_request.csv, "write every tick to this file")->type_name("FILE");
  run_command.add_option("--report", run_request.report, "write the paper's figures and summary.json to this folder")
      ->type_name("DIR");
  run_command
      .add_option("--video", run_request.video,
                  "record the camera's frames to this film (Matroska), lossless unless camera.film is small")
      ->type_name("FILE.MKV");
  run_command
      .add_option("--crops", run_request.crops,
                  "write a picture of each tag that is not seen to this folder (--keep writes them to the run's own)")
      ->type_name("DIR");
  CLI::Option* const keep = run_command.add_flag(
      "--keep", run_request.keep, "keep the run with all its inputs in a folder of its own (docs/runs.md)");
  add_runs_directory(run_command, run_request.runs_directory)->needs(keep);
  run_command
      .add_option("--publish", run_request.publish,
                  "send every tick as JSON datagrams, live, to PlotJuggler's UDP server or your own program; then the "
                  "default is --speed realtime")
      ->type_name("udp:HOST:PORT");
  run_command
      .add_option("--speed", run_request.speed,
                  "max: as fast as possible, on the virtual clock (default without real robots and camera); realtime: "
                  "at the file's rate")
      ->check(CLI::IsMember({"max", "realtime"}));
  run_command.add_flag("--quiet", run_request.quiet, "no progress, no summary");
  run_command.add_flag("--force", run_request.force, "overwrite the files of an earlier run");
  run_command.add_flag("--json", run_request.json, "print the summary as one JSON object");

  CLI::App& check_command = *program.add_subcommand(
      "check",
      "Reports every mistake in an experiment file, and certifies its gains; exit status 0 if they are "
      "certified, 1 if --controller finds the law unfit, 2 if the file has mistakes or they "
      "are not certified (`skein run` still runs it)");
  ExperimentOptions check_experiment;
  check_experiment.add_to(check_command, true);
  bool check_law = false;
  check_command.add_flag("--controller", check_law,
                         "also run it with simulated robots, and report whether the law keeps its deadline and its "
                         "limits, and how often the shield acts");
  check_command
      .add_flag_callback(
          "--schema",
          [] {
            print_out(experiment_schema(), reader_patience);
            throw CLI::Success();
          },
          "print a JSON schema of experiment files instead, for editors that complete and check TOML")
      ->trigger_on_parse();  // before CLI11 asks for the experiment

  CLI::App& doctor_command = *program.add_subcommand("doctor",
                                                     "Checks everything that a good run needs on this machine, one "
                                                     "line each, with a remedy; exit status 1 if a check fails");
  DoctorRequest doctor_request;
  std::vector<std::string> doctor_files;
  doctor_command
      .add_option("experiment", doctor_files, "experiment files to be run here: checks their robots and cameras")
      // A name that is wrong must not keep the machine from being examined.
      ->transform([](const std::string& name) { return find_resource("experiments", name); });
  doctor_command.add_option("--seconds", doctor_request.seconds, "duration of the timing test; 0: no test")
      ->check(number_within(0.0, 3600.0))
      ->capture_default_str();
  doctor_command.add_flag("--fix", doctor_request.fix,
                          "apply the remedies that are commands, as root or with sudo, and print each");

  CLI::App& replay_command = *program.add_subcommand(
      "replay", "Runs the ticks of a recorded CSV again and reports whether every command is the same, bit for bit");
  std::string replay_file;
  replay_command.add_option("file", replay_file, "a CSV written by `skein run --csv` or by the window")->required();
  std::string replay_film;
  replay_command.add_option("--video", replay_film,
                            "the film of the same run (`skein run --video`): every pose is computed from it again");

  bool replay_repairs = false;
  replay_command.add_flag(
      "--repair", replay_repairs,
      "first repair a file torn by a power cut: keep only its complete rows; the original becomes FILE.torn");

  bool replay_asks = false;
  replay_command.add_flag(
      "--controller", replay_asks,
      "also start the run's own controller, and report where its answers differ from the recorded ones");

  StudyCommands study_commands;
  study_commands.add_to(program);

  CLI::App& track_command = *program.add_subcommand("track", "Finds tags in pictures, a video or a camera; no control");
  TrackRequest track_request;
  track_command.add_option("source", track_request.source, vision::source_forms())->required();
  track_command.add_option("--camera", track_request.camera, "calibration file; without one, pixels only")
      ->type_name("CAL.TOML");
  track_command.add_option("--csv", track_request.csv, "one row per detection; default: stdout")->type_name("FILE");
  track_command.add_option("--record", track_request.record, "record the frames to this film, lossless (Matroska)")
      ->type_name("FILE.MKV");
  CLI::Option* const real_tracker =
      track_command.add_flag("--tracker", track_request.tracker,
                             "use the tracker of a run instead of AprilTag; count what it rejects, time its stages, "
                             "and report why a tag is not taken");
  track_command
      .add_option("--tags", track_request.tags, "tags to follow, such as 1-4,7; default: those in the first frame")
      ->type_name("IDS")
      ->needs(real_tracker);
  track_command
      .add_option("--crops", track_request.crops, "write a picture of each tag that is not taken to this folder")
      ->type_name("DIR")
      ->needs(real_tracker);
  track_command.add_flag("--list-controls", track_request.list_controls,
                         "only list the camera's formats, rates and controls");
  add_camera_words(track_command, track_request.words, /*calibrated=*/false);
  track_command.add_flag("--quiet", track_request.quiet, "no progress, no summary");

  CLI::App& camera_command = *program.add_subcommand("camera", "Lists, examines and times cameras");
  camera_command.require_subcommand(1);
  CLI::App& list_command =
      *camera_command.add_subcommand("list", "Lists the cameras, or the formats, rates and controls of one");
  std::string camera_device;
  list_command.add_option("camera", camera_device, "such as /dev/video0 or aravis:NAME");

  CLI::App& camera_doctor_command =
      *camera_command.add_subcommand("doctor",
                                     "Examines a camera by its frames, at 25 frames/s without --rate, and prints what "
                                     "to do and a [camera] table to paste; exit status 1 if something must be fixed");
  CameraDoctorRequest camera_doctor_request;
  camera_doctor_command.add_option("source", camera_doctor_request.source,
                                   vision::source_forms() + " or synthetic; default: the only camera there is");
  camera_doctor_command.add_option("--camera", camera_doctor_request.camera, "its calibration file")
      ->type_name("CAL.TOML");
  camera_doctor_command.add_option("--seconds", camera_doctor_request.seconds, "how long to look [s]")
      ->check(number_within(1.0, 60.0))
      ->capture_default_str();
  add_camera_words(camera_doctor_command, camera_doctor_request.words, /*calibrated=*/false);
  camera_doctor_command.get_option("--rate")->description(
      "requested from the camera [frames/s]; default: 25, as in a run");

  CLI::App& camera_latency_command =
      *camera_command.add_subcommand("latency",
                                     "Measures how late the time stamps of an experiment's cameras are: a robot with a "
                                     "link turns to and fro on the spot, and its headings are compared with its wheel "
                                     "counters; prints camera.latency; exit status 1 if the data do not determine it");
  ExperimentOptions latency_experiment;
  latency_experiment.add_to(camera_latency_command, true);
  CameraLatencyRequest latency_request;
  camera_latency_command
      .add_option("--robot", latency_request.robots,
                  "the robot that turns, from 1; repeatable: several robots, one after the other, at different rows of "
                  "the picture, also determine the row time of a rolling shutter")
      ->check(whole_number(1, 1000))
      ->expected(1)
      ->multi_option_policy(CLI::MultiOptionPolicy::TakeAll)
      ->capture_default_str();
  camera_latency_command.add_option("--seconds", latency_request.seconds, "how long it turns [s]")
      ->check(number_within(4.0, 120.0))
      ->capture_default_str();
  camera_latency_command.add_flag("--save", latency_request.save,
                                  "write the result to the experiment file, and a row time to the calibration");

  VisionCommands vision_commands;
  vision_commands.add_to(program);

  CLI::App& emulate_command = *program.add_subcommand(
      "emulate",
      "Runs emulated robots until it is interrupted, on pseudo-terminals by default, and prints their addresses");
  comms::EmulateOptions emulate_options;
  std::string model = "epuck2";
  auto* robots_option = emulate_command.add_option("--robots", emulate_options.robots, "how many")
                            ->check(whole_number(1, 64))
                            ->capture_default_str();
  emulate_command.add_option("--model", model, "which robots")
      ->check(CLI::IsMember(linked_models()))
      ->capture_default_str();
  emulate_command.add_option("--directory", emulate_options.directory, "folder for the links robot1, robot2, ...")
      ->type_name("DIR");
  emulate_command
      .add_option("--listen", emulate_options.listen,
                  "rfcomm:ADAPTER/CHANNEL (rfcomm:hci4/1), tcp:ADDRESS:PORT for an e-puck2 with WiFi, or "
                  "udp:ADDRESS:PORT for a robot with the open "
                  "protocol: a robot listens there; repeatable, one robot each")
      ->type_name("WHERE")
      ->excludes(robots_option);
  emulate_command.add_flag("--verbose", emulate_options.verbose, "print every change of a wheel speed");

  std::string faults;
  emulate_command.add_option("--faults", faults, "faults: a file (TOML, see docs/emulator.md), or random")
      ->type_name("FILE|random");
  emulate_command.add_option("--seed", emulate_options.seed, "seed of the random faults")->capture_default_str();

  RobotCommands robot_commands;
  robot_commands.add_to(program);

  RunCommands run_commands;
  run_commands.add_to(program);

  CLI::App& stop_command = *program.add_subcommand("stop",
                                                   "Sends STOP to every run of this user, for a key, a foot switch or "
                                                   "a script; exit status 3 if a robot does not acknowledge");

  CLI::App& guard_command =
      *program.add_subcommand("guard", "Started by a run with real robots: stops them when the run is killed");
  std::string marker;
  guard_command.add_option("marker", marker, "the file that lists the robots")->required()->envname(marker_variable);

  CLI::App& manual_command = *program.add_subcommand("manual", "Writes its own manual pages into a folder");
  std::string manual_folder;
  manual_command.group("")->add_option("folder", manual_folder)->required();

  CLI::App& host_command = *program.add_subcommand(
      "controller-host", "Started by a run whose controller is a library: loads it in a process of its own");
  std::string library;
  auto* const library_option = host_command.group("")->add_option("library", library, "the shared library");
  std::optional<std::uint64_t> adversary;
  host_command.add_option("--adversary", adversary, "instead, for studies: a hostile controller")
      ->type_name("SEED")
      ->excludes(library_option);
  bool honest = false;
  host_command.add_flag("--honest", honest, "instead, for measurements: a controller that tracks and answers at once");

  if (argc > 1 && std::string_view(argv[1]) == "complete") {  // a shell asks: resources/completion
    print_out(completions(program, {argv + 2, argv + argc}, candidates));
    return done;
  }
  refuse_missing_values(program);
  say_mistakes_plainly(program);
  try {
    program.parse(argc, argv);
  } catch (const CLI::ParseError& error) {
    std::ostringstream help, mistake;
    const int status = program.exit(error, help, mistake);  // --help and --version end here as well
    print_out(help.str(), reader_patience);
    print_error(mistake.str());
    return status == 0 ? done : wrong_input;
  }
  if (const auto mistake = misplaced(program)) {
    print_error(shown(*mistake) + "\n");
    return wrong_input;
  }

  if (manual_command) {
    const auto written = write_manual(program, version_and_commit(), manual_folder);
    if (!written) complain(written.error());
    return written ? done : wrong_input;
  }
  // The emulator waits for signals in its own way.
  if (emulate_command) {
    emulate_options.model = core::find_robot_type(model);
    if (!emulate_options.listen.empty()) emulate_options.robots = emulate_options.listen.size();
    if (!read_faults(faults, emulate_options)) return wrong_input;
    constexpr double as_long_as_it_takes = 1e6;  // as a pipe, whose reader may be slow [s]
    emulate_options.say = [](const std::string& line) { print_out(line + "\n", as_long_as_it_takes); };
    emulate_options.complain = [](const std::string& sentence) { complain("emulate: " + sentence); };
    return comms::emulate(emulate_options);
  }
  if (host_command) return honest ? be_honest() : adversary ? be_adversary(*adversary) : host_library(library);
  if (guard_command) return guard(marker, STDIN_FILENO);
  if (stop_command) {
    ignore_output_signals();
    return stop_runs();
  }
  catch_interrupts();
  if (!ends_with_its_starter()) return wrong_input;
  comms::stop_robots_on_crash();
  comms::stop_robots_on_suspend(interrupt);
  if (run_command) {
    look_after_bad_ends();
    run_request.experiment = run_experiment.request();
    run_request.words.assign(argv + 1, argv + argc);
    return run(run_request);
  }
  if ((check_command && !check_law) || (replay_command && !replay_asks && !replay_repairs) || doctor_command ||
      run_commands.may_be_ended())
    end_by_interrupts();
  if (check_command) return check(check_experiment.request(), check_law);
  if (doctor_command) {
    for (const std::string& file : doctor_files) doctor_request.experiments.push_back({file, {}});
    doctor_request.window = bool(show_window);
    return doctor(doctor_request);
  }
  if (replay_command) return replay(replay_file, replay_film, replay_repairs, replay_asks);
  if (const auto status = study_commands.run()) return *status;
  if (track_command) return track(track_request);
  if (const auto status = vision_commands.run()) return *status;
  if (const auto status = robot_commands.run()) return *status;
  if (const auto status = run_commands.run()) return *status;
  if (list_command) return list_cameras(camera_device);
  if (camera_doctor_command) return camera_doctor(camera_doctor_request);
  if (camera_latency_command) {
    latency_request.experiment = latency_experiment.request();
    look_after_bad_ends();
    return camera_latency(latency_request);
  }
  if (!show_window) {
    complain("this program was built without a window; try: skein run EXPERIMENT, skein --help");
    return wrong_input;
  }
  const auto open_window = [&](const WindowRequest& request) -> int {
    const auto is_set = [](const char* name) {
      const char* const value = std::getenv(name);
      return value != nullptr && *value != '\0';
    };
    if (is_set("DISPLAY") || is_set("WAYLAND_DISPLAY") || is_set("QT_QPA_PLATFORM"))
      return show_window(request, argc, argv);
    complain(
        "no display for the window (DISPLAY and WAYLAND_DISPLAY are not set); try: skein run EXPERIMENT, skein --help");
    return wrong_input;
  };
  look_after_bad_ends();
  if (const std::string& file = window_experiment.file; file.ends_with(".csv")) {
    if (const ExperimentRequest& request = window_experiment.request(); request.rehearse || !request.sets.empty()) {
      complain(file + ": a recorded run is replayed unchanged, without --set, --duration, --seed and --rehearse");
      return wrong_input;
    }
    if (const auto is_file = check_is_file(file); !is_file) {
      complain(is_file.error());
      return wrong_input;
    }
    if (!std::ifstream(file)) {
      complain(file + ": cannot be opened: " + std::strerror(errno));
      return wrong_input;
    }
    return open_window({{}, {}, file});
  }
  const auto experiment = load(window_experiment.request());
  // A file with errors is mended in the window's editor; what the command line itself got wrong is said here.
  const bool mendable = !experiment && window_experiment.request().sets.empty() && !window_experiment.rehearse &&
                        check_is_file(window_experiment.file) && std::ifstream(window_experiment.file);
  if (mendable) return open_window({{}, window_experiment.file, {}});
  return experiment ? open_window({*experiment, window_experiment.file, {}}) : wrong_input;
}

}  // namespace

int command_line(int argc, char** argv, const ShowWindow& show_window) {
  return exit_status_of([&] { return parse_and_do(argc, argv, show_window); });
}

}  // namespace skein::app
