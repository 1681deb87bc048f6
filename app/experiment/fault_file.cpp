#include "app/experiment/fault_file.h"

#include <limits>
#include <optional>

#include "app/experiment/text_file.h"
#include "app/experiment/toml_table.h"

namespace skein::app {
namespace {

using comms::Fault;
using comms::FaultKind;

constexpr double longest_time = 1e6;  // [s]

/// What a kind needs besides `kind`, `robot`, `at` and `for`.
void read_amounts(TomlTable& table, Fault& fault) {
  switch (fault.kind) {
    case FaultKind::latency:
      table.require("median", above(0.0, 10.0, "s").text());
      table.number("median", fault.median, above(0.0, 10.0, "s"));
      fault.p99 = fault.median;
      table.number("p99", fault.p99, between(fault.median, 100.0, "s, not below the median"));
      break;
    case FaultKind::loss:
    case FaultKind::corruption:
      table.require("share", above(0.0, 1.0).text());
      table.number("share", fault.share, above(0.0, 1.0));
      break;
    case FaultKind::battery:
      table.number("volts", fault.volts, between(0.0, 5.0, "V"));
      table.number("sag", fault.sag, between(0.0, 10.0, "V/min"));
      break;
    case FaultKind::burst:
    case FaultKind::disconnect:
    case FaultKind::reboot:
    case FaultKind::stuck:
    case FaultKind::ring:
    case FaultKind::swapped_wheels:
    case FaultKind::silent_encoders:
    case FaultKind::stall:
      break;
  }
}

std::optional<Fault> read_fault(TomlTable& table, std::size_t robots) {
  Fault fault;
  std::optional<std::int64_t> robot;
  std::string kinds;
  for (const FaultKind each : core::all_of<FaultKind>()) kinds += (kinds.empty() ? "" : ", ") + std::string(word(each));
  table.require("kind", kinds);
  if (!table.has("kind")) return {};
  std::optional<FaultKind> kind;
  table.choice("kind", kind);
  if (!kind) return {};  // without a kind its keys are not known
  fault.kind = *kind;
  table.integer("robot", robot, 1, static_cast<std::int64_t>(robots));
  if (robot) fault.robot = static_cast<std::size_t>(*robot - 1);
  table.number("at", fault.at, between(0.0, longest_time, "s"));
  if (fault.kind == FaultKind::stuck)
    fault.duration = 0.0;  // an instant
  else
    table.number("for", fault.duration, above(0.0, longest_time, "s"));
  read_amounts(table, fault);
  table.finish();
  return fault;
}

}  // namespace

tl::expected<std::vector<Fault>, std::vector<Problem>> parse_faults(std::string_view text, const std::string& file,
                                                                    std::size_t robots) {
  auto parsed = parse_toml(text, file, FileKind::faults);
  if (!parsed) return tl::unexpected(parsed.error());
  toml::table& document = *parsed;
  Problems problems(document, file);
  TomlTable root(&document, "", problems);
  std::vector<Fault> faults;
  for (TomlTable& table : root.tables("fault"))
    if (const auto fault = read_fault(table, robots)) faults.push_back(*fault);
  root.finish();
  if (!problems.empty()) return tl::unexpected(std::move(problems).sorted());
  return faults;
}

tl::expected<std::vector<Fault>, std::vector<Problem>> load_faults(const std::string& path, std::size_t robots) {
  const auto text = read_text(path);
  if (!text) return tl::unexpected(text.error());
  return parse_faults(*text, path, robots);
}

}  // namespace skein::app
