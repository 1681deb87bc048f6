#include <fmt/format.h>

#include "app/certificate.h"
#include "app/commands/command_line.h"
#include "app/commands/commands.h"

namespace skein::app {

int check(const ExperimentRequest& request) {
  const auto experiment = load(request);
  if (!experiment) return wrong_input;
  const Certificate certificate = certify(*experiment);
  fmt::print("experiment: {}\n{}", experiment->name, as_lines(certificate));
  return certificate.holds() ? done : wrong_input;
}

}  // namespace skein::app
