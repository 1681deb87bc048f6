#pragma once

#include <span>
#include <vector>

#include "app/experiment/controller_spec.h"
#include "app/run/event.h"
#include "app/run/operator_command.h"

namespace skein::app {

/// The parameters of the law in force, which the operator may change. Part of the tick: allocates in its constructor
/// only.
class LawParameters {
 public:
  explicit LawParameters(const LawSpec& law);
  /// A new value, in force at once. A name that a built-in law does not declare, and a value that it does not allow,
  /// have no effect; the caller has checked what a controller of the user's own allows.
  void set(const commands::SetParameter& command, EventList& events) noexcept;
  /// At the start: notes the values that differ from the file by then.
  void note_changes_before_start(EventList& events) const noexcept;
  /// Of the built-in law, in the order in which it declares them; a span that stays valid.
  std::span<const double> of_kind() const noexcept { return of_kind_; }

 private:
  struct Known {
    ParameterName name;
    double low, high, first, now;
  };
  std::vector<Known> known_;  // of the law in force
  std::vector<double> of_kind_;
  bool own_;
};

}  // namespace skein::app
