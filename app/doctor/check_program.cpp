#include "app/doctor/checks.h"

#include <fmt/format.h>

#include <utility>

namespace skein::app::detail {
namespace {

namespace fs = std::filesystem;
using State = Finding::State;

/// The experiments' own controllers.
Findings controllers(const Machine& machine, const Examination& examination) {
  Findings result;
  for (const auto& [file, experiment] : examination.experiments) {
    if (!experiment.controller.law.own()) continue;
    if (const auto started = machine.start_controller(experiment); started)
      result.push_back(well("controller", fmt::format("that of {} can be started", file)));
    else
      result.push_back({State::ill, "controller", fmt::format("{}: {}", file, started.error()),
                        fmt::format("skein check --controller {} shows all that it prints", file)});
  }
  return result;
}

Findings parts(const Machine& machine) {
  Findings result;
  if (const auto guard = machine.guard(); guard && guard->empty())
    result.push_back(well("guard", "can be started"));
  else if (guard)
    result.push_back({State::note, "guard", "can be started; " + *guard,
                      "make that folder writable: after a crash of the machine the next start then names the robots"});
  else
    result.push_back({State::ill, "guard", guard.error(),
                      "mend this: without a guard nothing stops the robots when the program is killed"});
  for (const std::string& run : machine.bad_ends())
    result.push_back({State::ill, "an earlier run", fmt::format("{} ended badly, its robots may still drive", run),
                      "skein robots stop"});
  if (const auto modules = machine.modules(); modules)
    result.push_back(well("modules", "films, calibration boards, GigE and USB3 Vision"));
  else
    result.push_back({State::ill, "modules", modules.error(), "reinstall skein"});
  if (machine.has_program("gnuplot"))
    result.push_back(well("gnuplot", "draws the figures of reports"));
  else
    result.push_back({State::note,
                      "gnuplot",
                      "is missing: no figures with --report",
                      "as root: apt-get install gnuplot-nox",
                      {{"apt-get", "install", "-y", "gnuplot-nox"}}});
  return result;
}

Finding display(const Machine& machine) {
  const char* const subject = "display";
  if (!machine.window) return {State::note, subject, "this program was built without a window", "skein run works"};
  if (machine.display.empty())
    return {State::note, subject, "none: no window here", "skein run works without; or ssh -X"};
  std::error_code error;
  if (machine.display.starts_with(":")) {
    const std::string number = machine.display.substr(1, machine.display.find('.') - 1);
    if (!fs::exists(below(machine, "/tmp/.X11-unix/X" + number), error))
      return {State::ill, subject, fmt::format("DISPLAY is {}, but there is no display server", machine.display),
              "log in at the machine, or unset DISPLAY"};
  }
  // Names of X's displays have a colon. Wayland alone does not let a program place its dialogs.
  if (machine.display.find(':') == std::string::npos)
    return {State::note,
            subject,
            fmt::format("Wayland ({}) without XWayland: a dialog can open over the STOP button", machine.display),
            "as root: apt-get install xwayland, and log in again",
            {{"apt-get", "install", "-y", "xwayland"}}};
  return well(subject, machine.display);
}

}  // namespace

Findings check_program(const Machine& machine, const Examination& examination) {
  Findings result = controllers(machine, examination);
  append(result, parts(machine));
  result.push_back(display(machine));
  return result;
}

}  // namespace skein::app::detail
