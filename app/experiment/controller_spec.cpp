#include "app/experiment/controller_spec.h"

#include <fmt/format.h>

#include <cmath>
#include <limits>

#include "core/controllers/controller_types.h"

namespace skein::app {

std::vector<std::string> log_names(const LawSpec& law) {
  if (law.own()) return law.log;
  const auto names = core::controller_type(law.kind).logs;
  return {names.begin(), names.end()};
}

std::vector<LawParameter> declared_parameters(const LawSpec& law) {
  constexpr double any = std::numeric_limits<double>::infinity();
  std::vector<LawParameter> all;
  if (law.own()) {
    for (const auto& [name, value] : law.own_parameters) all.push_back({name, {}, {}, -any, any, value});
    return all;
  }
  const auto declared = core::controller_type(law.kind).parameters;
  for (std::size_t k = 0; k < declared.size(); ++k) {
    const core::ControllerParameter& p = declared[k];
    all.push_back({std::string(p.name), std::string(p.unit), std::string(p.help), p.low, p.high, law.parameters[k]});
  }
  return all;
}

std::string wrong_parameter(std::span<const LawParameter> declared, std::string_view name, double value) {
  std::string names;
  for (const LawParameter& p : declared) {
    names += (names.empty() ? "" : ", ") + p.name;
    if (p.name != name) continue;
    if (std::isfinite(value) && value >= p.low && value <= p.high) return {};
    if (!std::isfinite(p.high - p.low)) return "a finite number";
    return fmt::format("{} to {}{}{}", p.low, p.high, p.unit.empty() ? "" : " ", p.unit);
  }
  return names.empty() ? "none: the law declares no parameters" : names;
}

}  // namespace skein::app
