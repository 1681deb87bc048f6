#include <fmt/format.h>

#include <algorithm>

#include "app/cli/commands.h"
#include "app/doctor/doctor.h"
#include "app/run/exit_status.h"
#include "app/run/output.h"
#include "app/run/shell_word.h"
#include "app/run/terminal_text.h"

namespace skein::app {
namespace {

/// Runs the commands that the findings name, once each; before that each is printed as a shell takes it. What only a
/// person can do is said. False: a command failed, and the later ones of that finding, which need it, were not run.
bool mend(const Machine& machine, const std::vector<Finding>& findings) {
  std::vector<std::vector<std::string>> succeeded, failed;
  const auto among = [](const auto& commands, const auto& command) {
    return std::find(commands.begin(), commands.end(), command) != commands.end();
  };
  for (const Finding& finding : findings) {
    if (finding.fix.empty() && finding.state == Finding::State::ill)
      print_out(fmt::format("by hand  {}: {}\n", shown(finding.what), shown(finding.remedy)));
    for (const std::vector<std::string>& command : finding.fix) {
      if (among(succeeded, command)) continue;
      if (among(failed, command)) break;
      std::string text;
      for (const std::string& word : command) text += " " + shell_word_if_needed(word);
      print_out(fmt::format("fix   {}:{}\n", shown(finding.what), text));
      const auto executed = machine.execute(command);
      (executed ? succeeded : failed).push_back(command);
      if (executed) continue;
      complain(fmt::format("{}: {}", finding.what, executed.error()));
      break;
    }
  }
  return failed.empty();
}

}  // namespace

int doctor(const DoctorRequest& request) {
  Machine machine = this_machine();
  machine.window = request.window;
  return doctor(request, machine);
}

int doctor(const DoctorRequest& request, const Machine& machine) {
  Examination examination{request.seconds};
  bool readable = true;  // a file with mistakes does not hide what is wrong with the machine
  for (const ExperimentRequest& file : request.experiments) {
    if (auto experiment = load(file))
      examination.experiments.emplace_back(file.file, std::move(*experiment));
    else
      readable = false;
  }
  const std::vector<Finding> findings = examine(machine, examination);
  bool ill = false;
  for (const Finding& finding : findings) {
    print_out(as_line(finding));
    ill = ill || finding.state == Finding::State::ill;
  }
  const bool mended = !request.fix || mend(machine, findings);
  if (!readable) return wrong_input;
  return ill || !mended ? expectation_failed : done;
}

}  // namespace skein::app
