#include "app/tick/law_parameters.h"

#include <algorithm>
#include <limits>

#include "core/controllers/controller_types.h"

namespace skein::app {
namespace {

constexpr double most = std::numeric_limits<double>::max();

}  // namespace

LawParameters::LawParameters(const LawSpec& law) : of_kind_(law.parameters), own_(law.own()) {
  known_.reserve(most_parameters);
  if (own_)
    for (const auto& [name, value] : law.own_parameters)
      known_.push_back({ParameterName(name), -most, most, value, value});
  const auto declared = core::controller_type(law.kind).parameters;
  for (std::size_t k = 0; !own_ && k < declared.size(); ++k)
    known_.push_back({ParameterName(declared[k].name), declared[k].low, declared[k].high, of_kind_[k], of_kind_[k]});
}

void LawParameters::set(const commands::SetParameter& command, EventList& events) noexcept {
  auto found = std::find_if(known_.begin(), known_.end(), [&](const Known& p) { return p.name == command.name; });
  if (found == known_.end()) {
    // Of a controller of the user's own the file need not know all.
    if (!own_ || known_.size() == most_parameters) return;
    found = known_.insert(known_.end(), {command.name, -most, most, command.from, command.from});
  }
  if (!(command.value >= found->low && command.value <= found->high) || command.value == found->now) return;
  events.add(events::Parameter{command.name, found->now, command.value});
  found->now = command.value;
  if (!own_) of_kind_[static_cast<std::size_t>(found - known_.begin())] = command.value;
}

void LawParameters::note_changes_before_start(EventList& events) const noexcept {
  for (const Known& p : known_) {
    const auto told = [&](const Event& event) {
      const auto* const change = std::get_if<events::Parameter>(&event);
      return change && change->name == p.name;
    };
    if (p.now != p.first && std::none_of(events.begin(), events.end(), told))
      events.add(events::Parameter{p.name, p.first, p.now});
  }
}

}  // namespace skein::app
