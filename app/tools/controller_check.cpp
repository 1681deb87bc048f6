#include "app/tools/controller_check.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "app/controllers/own_controller.h"
#include "app/record/statistics.h"
#include "app/session/session.h"
#include "app/tools/sweep.h"

namespace skein::app {
namespace {

/// Counts what came after the law.
class Interventions final : public RecordSink {
 public:
  explicit Interventions(ControllerCheck& check) : check_(check) {}
  void record(const TickRecord& record) override {
    if (record.phase != Phase::running) return;
    ++check_.ticks;
    for (const RobotRecord& robot : record.robots) {
      ++check_.commands;
      check_.no_number += std::isnan(robot.law.v) && !robot.is(lost);
      check_.limited += robot.is(limited);
      check_.shielded += robot.is(shielded);
    }
  }

 private:
  ControllerCheck& check_;
};

Experiment simulated(Experiment experiment) {
  for (RobotSpec& robot : experiment.robots) {
    robot.link = RobotSpec::Link::sim;
    robot.address.clear();
  }
  experiment.camera = {};
  return experiment;
}

std::string share_text(std::int64_t part, std::int64_t whole) {
  return fmt::format("{} of {} ({:.2f} %)", part, whole,
                     whole > 0 ? 100.0 * static_cast<double>(part) / static_cast<double>(whole) : 0.0);
}

}  // namespace

bool ControllerCheck::fit() const noexcept {
  const bool in_time = !own || (wait_p999 <= deadline && 1000 * late <= ticks);
  return in_time && failure.empty() && no_number == 0 && collisions == 0 && outside <= 0.0;
}

tl::expected<ControllerCheck, std::string> check_controller(const Experiment& experiment, const std::string& program) {
  const Experiment here = simulated(experiment);
  ControllerCheck check;
  Statistics statistics(here);
  Interventions interventions(check);
  SessionOptions options;
  options.sinks = {&statistics, &interventions};
  options.program = program;
  auto session = Session::open(here, Session::Clock::virtual_, options);
  if (!session) return tl::unexpected(session.error());
  (*session)->run();
  (*session)->close();

  const Statistics::Summary summary = statistics.summary();
  check.collisions = summary.collisions;
  check.min_distance = summary.min_distance;
  check.outside = std::max(0.0, summary.outside);
  check.final_error = summary.final_error;
  check.failure = (*session)->failure().value_or("");
  if (const OwnController* const own = (*session)->controller()) {
    const ControllerReport& report = own->report();
    check.own = true;
    // On the wall clock it will have what the file gives it, or its share of a period.
    check.deadline = experiment.controller.law.deadline.value_or(default_deadline(experiment));
    check.wait_p50 = quantile(report.waits, 0.5);
    check.wait_p99 = quantile(report.waits, 0.99);
    check.wait_p999 = quantile(report.waits, 0.999);
    check.wait_max = quantile(report.waits, 1.0);
    check.late = report.late + std::count_if(report.waits.begin(), report.waits.end(),
                                             [&](double wait) { return wait > check.deadline; });
  }
  return check;
}

std::string as_lines(const ControllerCheck& c) {
  std::string text;
  text += fmt::format("ticks: {}\n", c.ticks);
  if (c.own) {
    text += fmt::format("deadline: {:.3g} ms\n", 1e3 * c.deadline);
    text +=
        fmt::format("answer_p50: {:.3g} ms\nanswer_p99: {:.3g} ms\nanswer_p99.9: {:.3g} ms\nanswer_max: {:.3g} ms\n",
                    1e3 * c.wait_p50, 1e3 * c.wait_p99, 1e3 * c.wait_p999, 1e3 * c.wait_max);
    text += fmt::format("late: {}\n", share_text(c.late, c.ticks));
  }
  text += fmt::format("no_number: {}\n", share_text(c.no_number, c.commands));
  text += fmt::format("limited: {}\n", share_text(c.limited, c.commands));
  text += fmt::format("shielded: {}\n", share_text(c.shielded, c.commands));
  text += fmt::format("collisions: {}\n", c.collisions);
  text += fmt::format("min_distance: {:.4g} m\n", c.min_distance);
  text += fmt::format("outside: {:.4g} m\n", c.outside);
  text += fmt::format("final_error: {:.4g} m\n", c.final_error);
  if (!c.failure.empty()) text += fmt::format("failure: {}\n", c.failure);
  text +=
      fmt::format("verdict: {}\n",
                  c.fit() ? "fit to drive: every answer was in time and a number, and with limits and shield no robot "
                            "collided or left the arena"
                          : "NOT fit to drive real robots: see above");
  return text;
}

}  // namespace skein::app
