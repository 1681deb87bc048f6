#include "app/record/csv_writer.h"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <cmath>

#include "app/record/csv_columns.h"

namespace skein::app {

/// One row or head at a time, in a buffer that grows once and is then reused.
struct CsvWriter::Impl {
  std::ostream& out;
  bool pair_gains;
  std::string row = {};
  bool links = false;                  // some robot has one
  bool waits = false;                  // the formation, for its robots
  std::vector<std::string> logs = {};  // by the law
  std::size_t cameras = 0;             // of several

  void number(double value) {
    if (!std::isnan(value)) {
      char text[32];  // the longest double has 24 characters
      row.append(text, std::to_chars(text, text + sizeof text, value).ptr);
    }
    row += ',';
  }
  /// The words of the bits, joined by +.
  template <typename Bit>
  void words(std::uint8_t bits) {
    const char* joint = "";
    for (const Bit bit : core::all_bits_of<Bit>())
      if (bits & bit) row.append(joint).append(word(bit)), joint = "+";
    row += ',';
  }
  void robot(const RobotRecord& record) {
    for (const auto& column : robot_columns) number(column.get(record));
    words<Mode>(record.mode);
    const bool seen = record.measurement.ever_seen();
    for (const auto& column : measurement_columns) number(seen ? column.get(record) : none);
    row.append(word(record.measurement.how)) += ',';
    if (record.link.state) row += word(*record.link.state);
    row += ',';
    for (const auto& column : link_columns) number(column.get(record));
    words<Limit>(record.limits);
    for (const auto& column : link_health_columns) number(column.get(record));
    for (const auto& column : link_input_columns)
      if (links) number(column.get(record));
  }
  void by_camera(const TickRecord& record, std::size_t robot) {
    for (std::size_t k = 0; k < cameras; ++k) {
      const core::Measurement& seen = record.by_camera[k * record.robots.size() + robot];
      const bool ever = seen.ever_seen();
      for (const auto& column : camera_columns) number(ever ? column.get(seen) : none);
    }
  }
  void logged(const TickRecord& record, std::size_t robot) {
    for (std::size_t k = logs.size() * robot; k < logs.size() * (robot + 1); ++k)
      number(k < record.logged.size() ? record.logged[k] : none);
  }

  /// Empty where the pair has what the group's column says.
  void pairs(const TickRecord& record) {
    for (const core::GainName gain : core::gain_names)
      for (std::size_t i = 0; i < record.robots.size(); ++i)
        for (std::size_t j = i + 1; j < record.robots.size(); ++j) {
          const double value = record.pair_gain(gain, i, j);
          number(value == record.gain(gain) ? none : value);
        }
  }

  void head(const Experiment& experiment) {
    waits = experiment.avoidance.formation_waits;
    logs = log_names(experiment.controller.law);
    cameras = experiment.cameras() > 1 ? experiment.cameras() : 0;
    links = std::any_of(experiment.robots.begin(), experiment.robots.end(),
                        [](const RobotSpec& robot) { return robot.has_link(); });
    row = fmt::format("{}{}\n{}{}\n{}{:016x}\n{}{}\n", version_line, SKEIN_VERSION, experiment_line, experiment.name,
                      hash_line, fnv1a(experiment.source), seed_line, experiment.seed);
    std::string_view rest = experiment.source;
    while (!rest.empty()) {
      const std::size_t end = std::min(rest.find('\n'), rest.size());
      row.append(source_line).append(rest.substr(0, end)) += '\n';
      rest.remove_prefix(std::min(end + 1, rest.size()));
    }
  }
  void header(std::size_t robots) {
    row += "t,tick,";
    for (const auto& column : gain_columns) row.append(column.name) += ',';
    for (std::size_t i = 1; i < robots; ++i) row += fmt::format("delta_{}_{},", i, i + 1);
    for (const auto& column : group_columns) row.append(column.name) += ',';
    row += "event,";
    for (std::size_t i = 1; i <= robots; ++i) {
      for (const auto& column : robot_columns) row += fmt::format("r{}_{},", i, column.name);
      row += fmt::format("r{}_mode,", i);
      for (const auto& column : measurement_columns) row += fmt::format("r{}_{},", i, column.name);
      row += fmt::format("r{}_how,", i);
      row += fmt::format("r{}_link,", i);
      for (const auto& column : link_columns) row += fmt::format("r{}_{},", i, column.name);
      row += fmt::format("r{}_limit,", i);
      for (const auto& column : link_health_columns) row += fmt::format("r{}_{},", i, column.name);
      for (const auto& column : link_input_columns)
        if (links) row += fmt::format("r{}_{},", i, column.name);
      for (const std::string& name : logs) row += fmt::format("r{}_log_{},", i, name);
      for (std::size_t k = 1; k <= cameras; ++k)
        for (const auto& column : camera_columns) row += fmt::format("r{}_c{}_{},", i, k, column.name);
    }
    for (const auto& column : latency_columns) row.append(column.name) += ',';
    for (const core::GainName gain : core::gain_names)
      for (std::size_t i = 1; pair_gains && i <= robots; ++i)
        for (std::size_t j = i + 1; j <= robots; ++j) row += pair_column(gain, i, j) + ',';
    if (waits) row += "lag,";
    row += "now\n";
  }
  void write() {
    out.write(row.data(), static_cast<std::streamsize>(row.size()));
    row.clear();
  }
};

bool pairs_differ(const Experiment& experiment) {
  const auto differ = [](const core::PairTable& table) {
    for (std::size_t i = 0; i < table.robots(); ++i)
      for (std::size_t j = i + 1; j < table.robots(); ++j)
        if (table(i, j) != table.largest()) return true;
    return false;
  };
  // A robot on a planned route is not coupled to any other.
  const bool planned = experiment.avoidance.enabled && experiment.avoidance.kind == core::AvoidanceKind::plan;
  const auto may_differ = [&](const core::PairTable& table) { return planned ? !table.none() : differ(table); };
  for (const core::GainName gain : core::gain_names) {
    if (may_differ(core::table(experiment.controller.gains, gain))) return true;
    for (const GainChange& change : experiment.gain_changes)
      if (change[gain] && may_differ(*change[gain])) return true;
  }
  return std::any_of(experiment.actions.begin(), experiment.actions.end(), [&](const OperatorAction& action) {
    return is<events::PairGain, events::Uncouple>(action.event) || (planned && is<events::Gain>(action.event));
  });
}

bool pairs_differ(const TickRecord& record) noexcept {
  for (const core::GainName gain : core::gain_names)
    for (std::size_t i = 0; i < record.robots.size(); ++i)
      for (std::size_t j = i + 1; j < record.robots.size(); ++j)
        if (record.pair_gain(gain, i, j) != record.gain(gain)) return true;
  return false;
}

CsvWriter::CsvWriter(std::ostream& out, const Experiment& experiment, bool pair_gains)
    : impl_(new Impl{out, pair_gains, {}}) {
  impl_->head(experiment);
  impl_->header(experiment.robots.size());
  impl_->write();
}

CsvWriter::~CsvWriter() = default;

void CsvWriter::record(const TickRecord& record) {
  Impl& csv = *impl_;
  csv.number(record.t);
  csv.row.append(fmt::format_int(record.tick).c_str()) += ',';
  for (const auto& column : gain_columns) csv.number(column.get(record));
  for (const double delta : record.delta) csv.number(delta);
  for (const auto& column : group_columns) csv.number(column.get(record));
  if (!record.events.empty()) csv.row += describe(record.events);
  csv.row += ',';
  for (std::size_t i = 0; i < record.robots.size(); ++i) {
    csv.robot(record.robots[i]);
    csv.logged(record, i);
    csv.by_camera(record, i);
  }
  for (const auto& column : latency_columns) csv.number(column.get(record));
  if (csv.pair_gains) csv.pairs(record);
  if (csv.waits) csv.number(record.lag);
  csv.number(record.now);
  csv.row.back() = '\n';
  csv.write();
}

}  // namespace skein::app
