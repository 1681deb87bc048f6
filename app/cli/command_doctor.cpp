#include <fmt/format.h>

#include <algorithm>

#include "app/cli/commands.h"
#include "app/cli/shell_word.h"
#include "app/doctor/doctor.h"
#include "app/run/exit_status.h"
#include "app/run/output.h"

namespace skein::app {
namespace {

/// What the findings name, once each, as a person may read it before it is done.
void mend(const Machine& machine, const std::vector<Finding>& findings) {
  std::vector<std::vector<std::string>> done_already;
  for (const Finding& finding : findings) {
    for (const std::vector<std::string>& command : finding.fix) {
      if (std::find(done_already.begin(), done_already.end(), command) != done_already.end()) continue;
      done_already.push_back(command);
      std::string text;
      for (const std::string& word : command) text += " " + shell_word_if_needed(word);
      print_out(fmt::format("fix   {}:{}\n", finding.what, text));
      if (const int status = machine.execute(command); status != 0)
        complain(fmt::format("{}: {} ended with status {}", finding.what, command.front(), status));
    }
  }
}

}  // namespace

int doctor(const DoctorRequest& request) {
  Examination examination{request.seconds};
  bool readable = true;  // a file with mistakes does not hide what is wrong with the machine
  for (const ExperimentRequest& file : request.experiments) {
    if (auto experiment = load(file))
      examination.experiments.emplace_back(file.file, std::move(*experiment));
    else
      readable = false;
  }
  Machine machine = this_machine();
  machine.window = request.window;
  const std::vector<Finding> findings = examine(machine, examination);
  bool ill = false;
  for (const Finding& finding : findings) {
    print_out(as_line(finding));
    ill = ill || finding.state == Finding::State::ill;
  }
  if (request.fix) mend(machine, findings);
  if (!readable) return wrong_input;
  return ill ? expectation_failed : done;
}

}  // namespace skein::app
