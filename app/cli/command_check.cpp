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
  for (std::size_t i = 0; i < experiment->robots.size(); ++i) {
    const RobotSpec& robot = experiment->robots[i];
    if (robot.link != RobotSpec::Link::device) continue;
    fmt::print("watchdog: {}: {}\n", robot_name(*experiment, i),
               !robot.watchdog          ? "not known; `skein robots test --save` finds out"
               : *robot.watchdog == 0.0 ? "none: it drives on when its link dies"
                                        : fmt::format("stops by itself after {:g} s without a command", *robot.watchdog));
  }
  return certificate.holds() ? done : wrong_input;
}

}  // namespace skein::app
