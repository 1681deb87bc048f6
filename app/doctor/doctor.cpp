#include "app/doctor/doctor.h"

#include <fmt/format.h>

#include "app/doctor/checks.h"
#include "app/run/terminal_text.h"

namespace skein::app {

std::vector<Finding> examine(const Machine& machine, const Examination& examination) {
  using namespace detail;
  Findings all;
  append(all, check_permissions(machine));
  append(all, check_computer(machine));
  append(all, check_storage(machine));
  append(all, check_links(machine, examination));
  append(all, check_cameras(machine, examination));
  append(all, check_program(machine, examination));
  if (examination.seconds > 0.0) all.push_back(check_timing(machine, examination.seconds));
  return all;
}

std::string as_line(const Finding& finding) {
  const char* word = "well";
  switch (finding.state) {
    case Finding::State::well:
      break;
    case Finding::State::note:
      word = "note";
      break;
    case Finding::State::ill:
      word = "ILL ";
      break;
  }
  return fmt::format("{}  {}: {}{}{}\n", word, shown(finding.what), shown(finding.found),
                     finding.remedy.empty() ? "" : " -> ", shown(finding.remedy));
}

}  // namespace skein::app
