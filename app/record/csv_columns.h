#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <string_view>

#include "app/run/tick_record.h"

namespace skein::app {

/// The columns of a run's CSV in their order, for the writer and the reader alike; docs/csv.md says what they mean.

/// A column of numbers: the place of its value in a Record.
template <typename Record>
struct NumberColumn {
  /// `where` is a generic lambda that takes a record, const or not, and returns a reference to the value.
  template <typename Where>
  constexpr NumberColumn(const char* column_name, Where where) : name(column_name), get(where), at(where) {}

  const char* name;
  const double& (*get)(const Record&);
  double& (*at)(Record&);
};

// Before the columns of delta: t, tick, and then
inline constexpr std::array<NumberColumn<TickRecord>, 5> gain_columns{{
    {"k_xx", [](auto& r) -> decltype(auto) { return (r.k_xx); }},
    {"k_tt", [](auto& r) -> decltype(auto) { return (r.k_tt); }},
    {"k_yy", [](auto& r) -> decltype(auto) { return (r.k_yy); }},
    {"V", [](auto& r) -> decltype(auto) { return (r.V); }},
    {"V_dot", [](auto& r) -> decltype(auto) { return (r.V_dot); }},
}};
// After them, and before `event`.
inline constexpr std::array<NumberColumn<TickRecord>, 3> group_columns{{
    {"min_distance", [](auto& r) -> decltype(auto) { return (r.min_distance); }},
    {"period", [](auto& r) -> decltype(auto) { return (r.period); }},
    {"compute_time", [](auto& r) -> decltype(auto) { return (r.compute_time); }},
}};
// At the end of the row, before `now`: of the previous tick.
inline constexpr std::array<NumberColumn<TickRecord>, stages + 1> latency_columns{{
    {"latency_capture", [](auto& r) -> decltype(auto) { return (r.latency.of[0]); }},
    {"latency_dequeue", [](auto& r) -> decltype(auto) { return (r.latency.of[1]); }},
    {"latency_detect", [](auto& r) -> decltype(auto) { return (r.latency.of[2]); }},
    {"latency_hand_over", [](auto& r) -> decltype(auto) { return (r.latency.of[3]); }},
    {"latency_estimate", [](auto& r) -> decltype(auto) { return (r.latency.of[4]); }},
    {"latency_law", [](auto& r) -> decltype(auto) { return (r.latency.of[5]); }},
    {"latency_write", [](auto& r) -> decltype(auto) { return (r.latency.of[6]); }},
    {"latency_acknowledge", [](auto& r) -> decltype(auto) { return (r.latency.of[7]); }},
    {"latency_total", [](auto& r) -> decltype(auto) { return (r.latency.total); }},
}};
// Of robot i, prefix r<i>_; before `mode`.
inline constexpr std::array<NumberColumn<RobotRecord>, 25> robot_columns{{
    {"x", [](auto& r) -> decltype(auto) { return (r.pose.x); }},
    {"y", [](auto& r) -> decltype(auto) { return (r.pose.y); }},
    {"theta", [](auto& r) -> decltype(auto) { return (r.pose.theta); }},
    {"x_true", [](auto& r) -> decltype(auto) { return (r.truth.x); }},
    {"y_true", [](auto& r) -> decltype(auto) { return (r.truth.y); }},
    {"theta_true", [](auto& r) -> decltype(auto) { return (r.truth.theta); }},
    {"x_nom", [](auto& r) -> decltype(auto) { return (r.nominal.pose.x); }},
    {"y_nom", [](auto& r) -> decltype(auto) { return (r.nominal.pose.y); }},
    {"theta_nom", [](auto& r) -> decltype(auto) { return (r.nominal.pose.theta); }},
    {"v_nom", [](auto& r) -> decltype(auto) { return (r.nominal.twist.v); }},
    {"omega_nom", [](auto& r) -> decltype(auto) { return (r.nominal.twist.omega); }},
    {"x_ref", [](auto& r) -> decltype(auto) { return (r.reference.pose.x); }},
    {"y_ref", [](auto& r) -> decltype(auto) { return (r.reference.pose.y); }},
    {"theta_ref", [](auto& r) -> decltype(auto) { return (r.reference.pose.theta); }},
    {"v_ref", [](auto& r) -> decltype(auto) { return (r.reference.twist.v); }},
    {"omega_ref", [](auto& r) -> decltype(auto) { return (r.reference.twist.omega); }},
    {"x_e", [](auto& r) -> decltype(auto) { return (r.error.x); }},
    {"y_e", [](auto& r) -> decltype(auto) { return (r.error.y); }},
    {"theta_e", [](auto& r) -> decltype(auto) { return (r.error.theta); }},
    {"v_law", [](auto& r) -> decltype(auto) { return (r.law.v); }},
    {"omega_law", [](auto& r) -> decltype(auto) { return (r.law.omega); }},
    {"v", [](auto& r) -> decltype(auto) { return (r.command.v); }},
    {"omega", [](auto& r) -> decltype(auto) { return (r.command.omega); }},
    {"wheel_left", [](auto& r) -> decltype(auto) { return (r.wheels.left); }},
    {"wheel_right", [](auto& r) -> decltype(auto) { return (r.wheels.right); }},
}};
// After `mode`. All empty for a robot that was never seen. The newest measurement and `now`, the last column of a row,
// are inputs of a replay.
inline constexpr std::array<NumberColumn<RobotRecord>, 8> measurement_columns{{
    {"pose_age", [](auto& r) -> decltype(auto) { return (r.pose_age); }},
    {"x_meas", [](auto& r) -> decltype(auto) { return (r.measurement.pose.x); }},
    {"y_meas", [](auto& r) -> decltype(auto) { return (r.measurement.pose.y); }},
    {"theta_meas", [](auto& r) -> decltype(auto) { return (r.measurement.pose.theta); }},
    {"t_meas", [](auto& r) -> decltype(auto) { return (r.measurement.captured_at); }},
    {"sigma_xy", [](auto& r) -> decltype(auto) { return (r.measurement.sigma_xy); }},
    {"sigma_theta", [](auto& r) -> decltype(auto) { return (r.measurement.sigma_theta); }},
    {"actuation_delay", [](auto& r) -> decltype(auto) { return (r.actuation_delay); }},
}};

// After them: r<i>_link, a word, and then
inline constexpr std::array<NumberColumn<RobotRecord>, 4> link_columns{{
    {"link_rtt", [](auto& r) -> decltype(auto) { return (r.link.round_trip); }},
    {"battery", [](auto& r) -> decltype(auto) { return (r.link.battery); }},
    {"left_steps", [](auto& r) -> decltype(auto) { return (r.link.left_steps); }},
    {"right_steps", [](auto& r) -> decltype(auto) { return (r.link.right_steps); }},
}};

// After `limit`, at the end of a robot's block.
inline constexpr std::array<NumberColumn<RobotRecord>, 4> link_health_columns{{
    {"link_rtt_p99", [](auto& r) -> decltype(auto) { return (r.link.round_trip_p99); }},
    {"link_bytes", [](auto& r) -> decltype(auto) { return (r.link.bytes); }},
    {"link_losses", [](auto& r) -> decltype(auto) { return (r.link.losses); }},
    {"link_reconnects", [](auto& r) -> decltype(auto) { return (r.link.reconnects); }},
}};

// After them, if the experiment has a robot with a link: inputs of a replay.
inline constexpr std::array<NumberColumn<RobotRecord>, 4> link_input_columns{{
    {"sent_left", [](auto& r) -> decltype(auto) { return (r.link.input.sent.left); }},
    {"sent_right", [](auto& r) -> decltype(auto) { return (r.link.input.sent.right); }},
    {"sent_at", [](auto& r) -> decltype(auto) { return (r.link.input.sent_at); }},
    {"blind_way", [](auto& r) -> decltype(auto) { return (r.link.input.blind_way); }},
}};

// At the end of a robot's block where there are several cameras, of each, prefix c<k>_: inputs of a replay. All empty
// for a robot that this camera has never seen.
inline constexpr std::array<NumberColumn<core::Measurement>, 6> camera_columns{{
    {"x_meas", [](auto& m) -> decltype(auto) { return (m.pose.x); }},
    {"y_meas", [](auto& m) -> decltype(auto) { return (m.pose.y); }},
    {"theta_meas", [](auto& m) -> decltype(auto) { return (m.pose.theta); }},
    {"t_meas", [](auto& m) -> decltype(auto) { return (m.captured_at); }},
    {"sigma_xy", [](auto& m) -> decltype(auto) { return (m.sigma_xy); }},
    {"sigma_theta", [](auto& m) -> decltype(auto) { return (m.sigma_theta); }},
}};

/// Where columns for gains of pairs are, in the order of core::gain_names, robots from 1: "k_xx_1_2".
inline std::string pair_column(core::GainName gain, std::size_t i, std::size_t j) {
  return std::string(word(gain)) + '_' + std::to_string(i) + '_' + std::to_string(j);
}

/// Whether a column holds words rather than a number: `event`, and of each robot mode, how, link and limit.
constexpr bool holds_words(std::string_view column) noexcept {
  if (column == "event") return true;
  if (!column.starts_with('r') || column.find('_') == std::string_view::npos) return false;
  const std::string_view name = column.substr(column.find('_') + 1);
  return name == "mode" || name == "how" || name == "link" || name == "limit";
}

/// The lines before the header row.
inline constexpr std::string_view version_line = "# skein ";
inline constexpr std::string_view experiment_line = "# experiment: ";
inline constexpr std::string_view hash_line = "# hash: ";
inline constexpr std::string_view seed_line = "# seed: ";
inline constexpr std::string_view source_line = "#| ";  ///< a line of the experiment file

/// FNV-1a, 64 bit: only distinguishes experiments.
constexpr std::uint64_t fnv1a(std::string_view text) noexcept {
  std::uint64_t hash = 0xcbf29ce484222325u;
  for (const char c : text) hash = (hash ^ static_cast<unsigned char>(c)) * 0x100000001b3u;
  return hash;
}

}  // namespace skein::app
