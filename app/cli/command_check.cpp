#include <fmt/format.h>

#include "app/cli/commands.h"
#include "app/experiment/certificate.h"
#include "app/experiment/ways.h"
#include "app/run/exit_status.h"
#include "app/run/output.h"
#include "app/run/terminal_text.h"
#include "app/session/experiment_cameras.h"
#include "app/tools/controller_check.h"

namespace skein::app {
namespace {

/// What of the certificate does not hold, for the one who does not read all of it.
std::string failures(const Certificate& certificate) {
  std::string all;
  const auto add = [&](const char* what) { all += (all.empty() ? "" : ", ") + std::string(what); };
  if (!certificate.reference_fits()) add("the reference is beyond the robots' limits");
  if (!certificate.other_law.empty()) return all;
  if (certificate.reference_fits() && !certificate.holds()) add("conditions (18) do not hold");
  if (!certificate.sampled_loop_stable()) add("the sampled loop is unstable (delay_margin)");
  if (!certificate.keeps_tracking()) add("the couplings leave tracking too little (tracking_authority)");
  return all;
}

}  // namespace

int check(const ExperimentRequest& request, bool controller) {
  const auto experiment = load(request);
  if (!experiment) return wrong_input;
  if (!can_read_calibrations(*experiment)) return wrong_input;
  const Certificate certificate = certify(*experiment);
  fmt::print("experiment: {}\n{}", shown(experiment->name), as_lines(certificate));
  for (const std::string& sentence : missing_ways(*experiment)) fmt::print("way: {}\n", shown(sentence));
  for (const UnguardedCalibration& one : unguarded_calibrations(*experiment))
    fmt::print("calibration: {}\n", shown(one.sentence));
  for (const std::string& sentence : uneven_focal_lengths(*experiment))
    fmt::print("calibration: {}\n", shown(sentence));
  for (std::size_t i = 0; i < experiment->robots.size(); ++i) {
    const RobotSpec& robot = experiment->robots[i];
    if (!robot.is_real()) continue;
    fmt::print("watchdog: {}: {}\n", shown(robot_name(*experiment, i)),
               !robot.watchdog ? "not known; `skein robots test --save` measures it"
               : *robot.watchdog == 0.0
                   ? "none: it drives on when its link dies"
                   : fmt::format("stops by itself after {:g} s without a command", *robot.watchdog));
  }
  if (controller) {
    const auto law = check_controller(*experiment);
    if (!law) {
      complain(law.error());
      return wrong_input;
    }
    fmt::print("{}", shown_lines(as_lines(*law)));
    if (!law->fit()) return expectation_failed;
  }
  if (certificate.sound()) return done;
  complain(fmt::format("not certified: {}; `skein run` would run it all the same", failures(certificate)));
  return wrong_input;
}

}  // namespace skein::app
