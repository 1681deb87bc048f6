#include "app/cli/command_line_robots.h"

#include <fmt/format.h>

#include "app/experiment/experiment.h"
#include "app/guard/stop_run.h"
#include "app/manual/whole_number.h"
#include "vision/sources/open_source.h"

namespace skein::app {

void RobotCommands::add_to(CLI::App& program) {
  CLI::App& robots = *program.add_subcommand("robots", "Finds, pairs, tests and stops real robots");
  robots.require_subcommand(1);
  const auto add = [&](const char* name, const char* what) {
    CLI::App* const command = robots.add_subcommand(name, what);
    command
        ->add_option("--file", request_.file,
                     "file of robots; default: robots.toml here, else $XDG_CONFIG_HOME/skein/robots.toml")
        ->type_name("ROBOTS.TOML");
    return command;
  };
  constexpr const char* which =
      "rfcomm:ADDR/CHANNEL, serial:DEVICE, tcp:HOST, udp:HOST or open+serial:DEVICE, a robot's name in the file of "
      "robots, a file of robots or an "
      "experiment file for all of its";

  list_ = add("list", "Lists the robots of the file of robots");

  stop_ = add("stop", "Stops robots, whatever state they were left in; exit status 3 if one does not acknowledge");
  stop_->add_option(
      "robots", request_.words,
      std::string(which) + "; default: all known robots, and those of every run, alive, frozen or killed");

  forget_ = add("forget",
                "Ends the guards that still try to stop robots of runs that ended badly, and forgets these runs: for "
                "robots that have been switched off by hand");

  test_ = add("test",
              "Asks robots for version and battery, turns each wheel 10 mm, and reports their faults; with a camera it "
              "checks their tags, and drives them 6 cm and turns them to measure their wheels");
  test_->add_option("robots", request_.words, which)->required();
  CLI::Option* const camera = test_
                                  ->add_option("--camera", request_.camera,
                                               vision::camera_forms() + "; default: the camera of the experiment file")
                                  ->type_name("SOURCE");
  CLI::Option* const calibration =
      test_->add_option("--calibration", request_.calibration, "its calibration file")->type_name("CAL.TOML");
  camera->needs(calibration);
  calibration->needs(camera);
  test_
      ->add_option("--reply-timeout", request_.reply_timeout,
                   fmt::format("a reply later than this counts as lost [s]; default: links.reply_timeout of the "
                               "experiment file, else {:g}",
                               LinksSpec{}.reply_timeout))
      ->check(number_within(0.02, 10.0))
      ->type_name("SECONDS");
  test_->add_flag("--save", request_.save, "write tag, version, wheel diameter and track to the file of robots");

  ping_ = add("ping", "Measures the robots' round trips under the traffic of a run; they stand meanwhile");
  ping_->add_option("robots", request_.words, which)->required();
  ping_->add_option("--minutes", request_.minutes, "how long")
      ->check(number_within(0.01, 1440.0))
      ->capture_default_str();
  ping_->add_flag("--save", request_.save, "write the proposal for [links] to the experiment file");

  const auto adapter = [&](CLI::App* command) {
    command->add_option("--adapter", request_.adapter, "hci1, or its address; default: all")->type_name("ADAPTER");
    command->add_flag("--save", request_.save, "add them to the file of robots");
  };
  scan_ = add("scan", "Looks for e-pucks by Bluetooth and prints them as tables of a file of robots");
  scan_->add_option("--seconds", request_.seconds, "duration; a complete inquiry takes 10.24 s")
      ->check(number_within(0.1, 3600.0))
      ->capture_default_str();
  adapter(scan_);

  pair_ = add("pair", "Pairs with e-pucks: an e-puck1 gets its number as PIN, an e-puck2 needs no PIN");
  pair_->add_option("robots", request_.words, "names (e-puck_1234) or Bluetooth addresses")->required();
  adapter(pair_);
}

std::optional<int> RobotCommands::run() {
  if (*list_) return list_robots(request_.file);
  if (*stop_) return stop_robots(request_.words, request_.file);
  if (*forget_) return forget_runs();
  if (*test_) return test_robots(request_);
  if (*ping_) return ping_robots(request_);
  if (*scan_) return scan_robots(request_);
  if (*pair_) return pair_robots(request_);
  return {};
}

}  // namespace skein::app
