#include <fmt/format.h>

#include <nlohmann/json.hpp>

#include "app/cli/command_line_runs.h"
#include "app/cli/commands.h"
#include "app/experiment/known_robots.h"
#include "app/record/report.h"
#include "app/run/exit_status.h"
#include "app/run/output.h"
#include "app/runs/find_run.h"
#include "app/tools/identify.h"
#include "core/words.h"

namespace skein::app {
namespace {

using core::Estimate;
using core::Unknown;
using Json = nlohmann::ordered_json;

/// A line of what was found: as the drive's file of robots calls it, and what was believed before, where anything was.
struct Line {
  std::string name;
  Estimate estimate;
  std::optional<double> believed;
};

std::vector<Line> lines_of(const IdentifiedRobot& robot) {
  const core::DifferentialDrive& believed = robot.history.input.believed;
  std::vector<Line> lines{{"wheel_diameter", robot.found.wheel_diameter, believed.wheel_diameter},
                          {"wheel_ratio", robot.found.wheel_ratio, believed.wheel_ratio}};
  for (const Unknown unknown : core::all_of<Unknown>()) {
    std::optional<double> before;
    if (unknown == Unknown::left_diameter) before = believed.left_diameter();
    if (unknown == Unknown::right_diameter) before = believed.right_diameter();
    if (unknown == Unknown::track) before = believed.track;
    if (unknown == Unknown::delay) before = robot.history.believed_delay;
    lines.push_back({std::string(word(unknown)), robot.found[unknown], before});
  }
  return lines;
}

std::string text_of(const IdentifiedRobot& robot) {
  std::string text =
      fmt::format("{}\nruns: {}\nposes: {}\ndriven: {:.3f}\nturned: {:.2f}\n", robot.history.name, robot.history.runs,
                  robot.history.input.poses.size(), robot.found.driven, robot.found.turned);
  if (!robot.found.converged) return text;
  for (const Line& line : lines_of(robot)) {
    text += fmt::format("{}: {:.5g} ({:.5g} to {:.5g})", line.name, line.estimate.value, line.estimate.low,
                        line.estimate.high);
    if (line.believed) text += fmt::format(", believed {:.5g}", *line.believed);
    text += line.estimate.known ? "\n" : ", not determined\n";
  }
  return text + fmt::format("outliers: {}\npersistence: {:.2f}\n", robot.outliers, robot.persistence);
}

Json json_of(const IdentifiedRobot& robot) {
  Json json{{"robot", robot.history.name},  {"runs", robot.history.runs},   {"poses", robot.history.input.poses.size()},
            {"driven", robot.found.driven}, {"turned", robot.found.turned}, {"converged", robot.found.converged}};
  if (!robot.found.converged) return json;
  for (const Line& line : lines_of(robot)) {
    Json& entry = json[line.name];
    entry = {{"value", line.estimate.value}, {"low", line.estimate.low}, {"high", line.estimate.high}};
    if (line.believed) entry["believed"] = *line.believed;
    entry["known"] = line.estimate.known;
  }
  json["outliers"] = robot.outliers;
  json["persistence"] = robot.persistence;
  return json;
}

}  // namespace

int identify(const IdentifyRequest& request) {
  if (request.save)  // nothing yet: what prevents it is to be known before the work
    if (const int possible = save_found(known_robots_file(request.file), {}); possible != done) return possible;
  if (!request.report.empty())
    if (const auto possible = check_report(request.report); !possible) return complain(possible.error()), wrong_input;
  std::vector<RobotHistory> robots;
  std::vector<std::vector<RobotHistory>> known;  // of each run
  for (const std::string& run : request.runs) {
    const auto record = record_of(run, request.directory);
    if (!record) return complain(record.error()), wrong_input;
    auto history = read_history(record->csv);
    if (!history) return complain(history.error()), wrong_input;
    if (history->torn) complain(*history->torn);
    if (history->gaps > 0)
      complain(
          fmt::format("{}: rows are missing in {} place{}, as if it had been thinned out or cut; the motion across "
                      "them is not used: give the run's own CSV",
                      run, history->gaps, history->gaps == 1 ? "" : "s"));
    // Twice the same measurements tell no more than once, but would make the intervals narrower.
    for (std::size_t k = 0; k < known.size(); ++k)
      if (same_run(known[k], history->robots))
        return complain(fmt::format("{}: is the same run as {}, allowed: each run once", run, request.runs[k])),
               wrong_input;
    if (request.runs.size() > 1) known.push_back(history->robots);
    append(robots, std::move(history->robots));
  }
  if (robots.empty()) return complain("no robot was seen in these runs: nothing can be identified"), expectation_failed;
  const std::vector<IdentifiedRobot> found = identify_robots(std::move(robots));

  bool told = true;
  Json json = Json::array();
  for (const IdentifiedRobot& robot : found) {
    if (request.json)
      json.push_back(json_of(robot));
    else
      print_out(text_of(robot) + "\n", reader_patience);
    for (const std::string& sentence : doubts(robot)) {
      complain(robot.history.name + ": " + sentence);
      told = false;
    }
  }
  if (request.json) print_out(json.dump(2) + "\n", reader_patience);
  if (!request.report.empty())
    if (const auto drawn = write_residuals(request.report, found); !drawn) return complain(drawn.error()), wrong_input;
  if (request.save) {
    std::vector<FoundRobot> kept;
    kept.reserve(found.size());
    for (const IdentifiedRobot& robot : found)
      kept.push_back({robot.history.spec, robot.history.name, values_to_keep(robot)});
    if (const int saved = save_found(known_robots_file(request.file), kept); saved != done) return saved;
  }
  return told ? done : expectation_failed;
}

}  // namespace skein::app
