#include "ui/plots/plot_rows.h"

#include <algorithm>

#include "core/geometry/pose.h"
#include "ui/base/modes.h"
#include "ui/base/tr.h"

namespace skein::ui {
namespace {

/// Both ways, of every robot that has other limits than those before it.
template <typename Limit>
std::vector<double> limits_of(const app::Experiment& experiment, Limit&& limit) {
  std::vector<double> all;
  for (std::size_t i = 0; i < experiment.robots.size(); ++i) {
    const double most = limit(app::make_limits(experiment, i));
    if (std::find(all.begin(), all.end(), most) == all.end()) all.insert(all.end(), {-most, most});
  }
  return all;
}

using app::TickRecord;
constexpr double ms = 1e3;
constexpr double oldest = 1e6;           // no pose yet, beyond it [s]
constexpr double settled = 0.01;         // what the results call settled [m]
constexpr std::size_t most_coupled = 6;  // robots whose 15 pairs can be told apart in one plot

/// Of robot i, unless it is lost.
template <typename Value>
auto known(Value value) {
  return [value](const TickRecord& record, std::size_t i) {
    if (i >= record.robots.size() || record.robots[i].is(app::lost)) return app::none;
    return static_cast<double>(value(record.robots[i]));
  };
}

}  // namespace

QColor colour_of(PlotRow::Of of, std::size_t curve, const Colours& colours) {
  switch (of) {
    case PlotRow::Of::robot:
    case PlotRow::Of::couple:
    case PlotRow::Of::stage:
      return colours.robot(curve);
    case PlotRow::Of::pair:
      return colours.pair(curve);
    case PlotRow::Of::group:
      return colours.text;
  }
  return colours.text;
}

std::optional<std::pair<std::size_t, std::size_t>> robots_of(PlotRow::Of of, std::size_t curve, std::size_t robots) {
  switch (of) {
    case PlotRow::Of::robot:
      return std::pair(curve, curve);
    case PlotRow::Of::pair:
      return std::pair(curve, curve + 1);
    case PlotRow::Of::couple: {
      std::size_t i = 0;
      for (; i + 1 < robots && curve >= robots - 1 - i; ++i) curve -= robots - 1 - i;
      return std::pair(i, i + 1 + curve);
    }
    case PlotRow::Of::stage:
    case PlotRow::Of::group:
      return std::nullopt;
  }
  return std::nullopt;
}

namespace {

std::vector<QString> curve_names(PlotRow::Of of, std::size_t n) {
  const auto names = [](std::size_t i, std::size_t j) { return QStringLiteral("%1,%2").arg(i + 1).arg(j + 1); };
  std::vector<QString> curves;
  switch (of) {
    case PlotRow::Of::robot:
      for (std::size_t i = 0; i < n; ++i) curves.push_back(QString::number(i + 1));
      break;
    case PlotRow::Of::pair:
      for (std::size_t i = 0; i + 1 < n; ++i) curves.push_back(names(i, i + 1));
      break;
    case PlotRow::Of::couple:
      for (std::size_t i = 0; i < n; ++i)
        for (std::size_t j = i + 1; j < n; ++j) curves.push_back(names(i, j));
      break;
    case PlotRow::Of::stage:
      for (const char* stage : {"capture", "dequeue", "detect", "hand over", "estimate", "law", "write", "answer"})
        curves.push_back(tr(stage));
      break;
    case PlotRow::Of::group:
      curves.emplace_back();
      break;
  }
  return curves;
}

}  // namespace

namespace {

/// Of robot i, lost or not.
template <typename Value>
auto always(Value value) {
  return [value](const TickRecord& record, std::size_t i) {
    return i < record.robots.size() ? static_cast<double>(value(record.robots[i])) : app::none;
  };
}

/// What the table of robots shows: from there it is dragged onto a plot.
void add_of_table(std::vector<PlotRow>& rows) {
  rows.push_back({
      .name = "pose_age",
      .symbol = "T",
      .index = "age",
      .unit = tr("[ms]"),
      .what = tr("Age of the pose in use, and when it counts as old"),
      .least = 10.0,
      .from_zero = true,
      .limits = {ms * old_pose},
      .value = always([](const app::RobotRecord& r) { return r.pose_age < oldest ? ms * r.pose_age : app::none; }),
  });
  rows.push_back({
      .name = "wheel_left",
      .symbol = "w",
      .index = "left",
      .unit = tr("[steps/s]"),
      .what = tr("Commanded speed of the left wheel"),
      .least = 50.0,
      .value = always([](const app::RobotRecord& r) { return r.wheels.left; }),
  });
  rows.push_back({
      .name = "wheel_right",
      .symbol = "w",
      .index = "right",
      .unit = tr("[steps/s]"),
      .what = tr("Commanded speed of the right wheel"),
      .least = 50.0,
      .value = always([](const app::RobotRecord& r) { return r.wheels.right; }),
  });
  rows.push_back({
      .name = "link_rtt",
      .symbol = "T",
      .index = "reply",
      .unit = tr("[ms]"),
      .what = tr("Round trip from a command to the robot's answer, median"),
      .least = 5.0,
      .from_zero = true,
      .value = always([](const app::RobotRecord& r) { return ms * r.link.round_trip; }),
  });
  rows.push_back({
      .name = "battery",
      .symbol = "U",
      .unit = tr("[V]"),
      .what = tr("Voltage of the robot's battery"),
      .least = 5.0,
      .from_zero = true,
      .value = always([](const app::RobotRecord& r) { return r.link.battery; }),
  });
}

}  // namespace

std::vector<PlotRow> plot_rows(const app::Experiment& experiment) {
  using Of = PlotRow::Of;
  const app::ControllerSpec& law = experiment.controller;
  std::vector<PlotRow> rows;
  const auto add = [&rows](PlotRow row) { rows.push_back(std::move(row)); };

  add({
      .name = "e_x",
      .symbol = "e",
      .index = "x",
      .unit = tr("[m]"),
      .what = tr("Tracking error along x, in the world frame"),
      .least = 0.02,
      .usual = true,
      .band = settled,
      .value = known([](const app::RobotRecord& r) { return r.nominal.pose.x - r.pose.x; }),
  });
  add({
      .name = "e_y",
      .symbol = "e",
      .index = "y",
      .unit = tr("[m]"),
      .what = tr("Tracking error along y, in the world frame"),
      .least = 0.02,
      .usual = true,
      .band = settled,
      .value = known([](const app::RobotRecord& r) { return r.nominal.pose.y - r.pose.y; }),
  });
  add({
      .name = "e_theta",
      .symbol = "e",
      .index = "θ",
      .unit = tr("[rad]"),
      .what = tr("Tracking error of the heading"),
      .least = 0.1,
      .usual = true,
      .value = known([](const app::RobotRecord& r) { return core::wrap_angle(r.nominal.pose.theta - r.pose.theta); }),
  });
  add({
      .name = "e",
      .symbol = "|e|",
      .unit = tr("[m]"),
      .what = tr("Distance from the place in the formation"),
      .least = 0.02,
      .from_zero = true,
      .band = settled,
      .value = known([](const app::RobotRecord& r) { return core::distance(r.pose, r.nominal.pose); }),
  });
  add({
      .name = "delta",
      .symbol = "δ",
      .index = "i,j",
      .unit = tr("[m]"),
      .what = tr("Formation error of neighbours: how much too close"),
      .of = Of::pair,
      .least = 0.02,
      .usual = true,
      .band = settled,
      .value = [](const TickRecord& record,
                  std::size_t i) { return i < record.delta.size() ? record.delta[i] : app::none; },
  });
  add({
      .name = "V",
      .symbol = "V",
      .unit = tr("[–]"),
      .what = tr("Lyapunov function"),
      .of = Of::group,
      .least = 0.002,
      .from_zero = true,
      .usual = true,
      .value = [](const TickRecord& record, std::size_t) { return record.V; },
  });
  add({
      .name = "V_dot",
      .symbol = "V̇",
      .unit = tr("[1/s]"),
      .what = tr("dV/dt if the law's commands were executed exactly"),
      .of = Of::group,
      .least = 0.001,
      .value = [](const TickRecord& record, std::size_t) { return record.V_dot; },
  });
  add({
      .name = "v",
      .symbol = "v",
      .unit = tr("[m/s]"),
      .what = tr("Commanded speed, and its limits"),
      .least = 0.02,
      .limits = limits_of(experiment, [](const core::CommandLimits& c) { return c.v_max; }),
      .value = known([](const app::RobotRecord& r) { return r.command.v; }),
  });
  add({
      .name = "omega",
      .symbol = "ω",
      .unit = tr("[rad/s]"),
      .what = tr("Commanded turning rate, and its limits"),
      .least = 0.2,
      .limits = limits_of(experiment, [](const core::CommandLimits& c) { return c.omega_max; }),
      .value = known([](const app::RobotRecord& r) { return r.command.omega; }),
  });
  std::vector<double> least;
  if (experiment.shield.enabled) least.push_back(experiment.shield.distance);
  if (experiment.expect.min_distance) least.push_back(*experiment.expect.min_distance);
  add({
      .name = "min_distance",
      .symbol = "d",
      .index = "min",
      .unit = tr("[m]"),
      .what = experiment.expect.min_distance
                  ? tr("Distance of the closest pair, the shield's distance, and that of [expect]")
                  : tr("Distance of the closest pair, and the shield's distance"),
      .of = Of::group,
      .least = 0.1,
      .from_zero = true,
      .limits = std::move(least),
      .value = [](const TickRecord& record, std::size_t) { return record.min_distance; },
  });
  add({
      .name = "period",
      .symbol = "T",
      .unit = tr("[ms]"),
      .what = tr("Time since the previous tick, and its nominal value"),
      .of = Of::group,
      .least = 60.0,
      .from_zero = true,
      .limits = {ms * experiment.period()},
      .value = [](const TickRecord& record, std::size_t) { return ms * record.period; },
  });
  add({
      .name = "compute_time",
      .symbol = "T",
      .index = "tick",
      .unit = tr("[ms]"),
      .what = tr("Duration of the tick"),
      .of = Of::group,
      .least = 0.01,
      .from_zero = true,
      .value = [](const TickRecord& record, std::size_t) { return ms * record.compute_time; },
  });

  const std::size_t n = experiment.robots.size();
  for (const core::GainName gain : core::gain_names) {
    const bool xx = gain == core::GainName::k_xx, tt = gain == core::GainName::k_tt;
    add({
        .name = core::word(gain).data(),
        .symbol = "k",
        .index = xx   ? "xx"
                 : tt ? "θθ"
                      : "yy",
        .unit = xx ? tr("[m/s]") : tr("[rad/s]"),
        .what = n > most_coupled ? tr("Coupling gain, the largest of all pairs") : tr("Coupling gain of each pair"),
        .of = n > most_coupled ? Of::group : Of::couple,
        .least = 0.1 * (xx ? law.v_max : law.omega_max),
        .from_zero = true,
        .value =
            [gain, n](const TickRecord& record, std::size_t curve) {
              if (n > most_coupled) return record.gain(gain);
              const auto [i, j] = *robots_of(Of::couple, curve, n);
              return record.pair_gain(gain, i, j);
            },
    });
  }
  add({
      .name = "latency",
      .symbol = "T",
      .index = "stage",
      .unit = tr("[ms]"),
      .what = tr("Duration of each stage from frame to answer"),
      .of = Of::stage,
      .least = 0.2,
      .from_zero = true,
      .value = [](const TickRecord& record, std::size_t stage) { return ms * record.latency.of[stage]; },
  });

  add_of_table(rows);

  std::size_t next = 0;
  for (PlotRow& row : rows) {
    row.first = next;
    row.curves = curve_names(row.of, n);
    next += row.curves.size();
  }
  return rows;
}

std::size_t curve_count(const std::vector<PlotRow>& rows) {
  return rows.empty() ? 0 : rows.back().first + rows.back().curves.size();
}

bool is_sample(const app::TickRecord& record) {
  return record.phase != app::Phase::ready && record.phase != app::Phase::staging;
}

void sample(const std::vector<PlotRow>& rows, const app::TickRecord& record, std::vector<double>& values) {
  values.clear();
  for (const PlotRow& row : rows)
    for (std::size_t i = 0; i < row.curves.size(); ++i) values.push_back(row.value(record, i));
}

}  // namespace skein::ui
