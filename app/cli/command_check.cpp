#include <fmt/format.h>

#include "app/cli/commands.h"
#include "app/experiment/certificate.h"
#include "app/run/exit_status.h"

namespace skein::app {

int check(const ExperimentRequest& request) {
  const auto experiment = load(request);
  if (!experiment) return wrong_input;
  const Certificate certificate = certify(*experiment);
  fmt::print("experiment: {}\n{}", experiment->name, as_lines(certificate));
  return certificate.sound() ? done : wrong_input;
}

}  // namespace skein::app
