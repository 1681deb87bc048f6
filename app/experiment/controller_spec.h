#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "core/controllers/controller_kind.h"

namespace skein::app {

/// The law that drives the group: a built-in one, or a controller of the user's own (docs/controllers.md).
struct LawSpec {
  core::ControllerKind kind = core::ControllerKind::kostic;
  std::vector<double> parameters;  ///< of the kind, in the order in which it declares them

  /// A controller of the user's own, instead of the kind: a program, or a library that a process of Skein's loads.
  /// At most one of the two; both empty: the kind drives.
  std::string command;  ///< split into words as by a shell, without other shell features
  std::string library;  ///< path, relative to the experiment file
  bool own() const noexcept { return !command.empty() || !library.empty(); }
  /// Whether the gains of [controller] have any effect: their law drives, or stands in for a controller that fails.
  bool uses_gains() const noexcept {
    return kind == core::ControllerKind::kostic && (!own() || failure == Failure::built_in);
  }
  /// Whether it is the law of the gains of [controller], for which (18) to (20) hold.
  bool of_the_paper() const noexcept { return !own() && kind == core::ControllerKind::kostic; }
  std::vector<std::pair<std::string, double>> own_parameters;  ///< as the file has them
  std::vector<std::string> log;                                ///< the logged values that the CSV contains

  /// What drives a robot at a tick without a valid answer from the user's controller.
  enum class Failure {
    hold,      ///< nothing: it stops
    built_in,  ///< the law `kind`
  };
  Failure failure = Failure::hold;
  /// Deadline from question to answer [s, wall clock]; empty: a quarter of a period, or half a second if the
  /// experiment's clock waits for it.
  std::optional<double> deadline;
  std::int64_t memory = 2048;   ///< limit of each of its processes [MB]
  std::int64_t processes = 16;  ///< how many it may start itself; 0: none
  bool preview = false;         ///< a second process of it may be started, for previews

  friend bool operator==(const LawSpec&, const LawSpec&) = default;
};

/// As files call it (core/words.h).
constexpr std::string_view word(LawSpec::Failure failure) noexcept {
  switch (failure) {
    case LawSpec::Failure::hold:
      return "hold";
    case LawSpec::Failure::built_in:
      return "built_in";
  }
  return {};
}

/// A parameter of a law, as the law declares it.
struct LawParameter {
  std::string name, unit, help;
  double low = 0.0, high = 0.0;  ///< both allowed; infinite where the law declares no range
  double value = 0.0;

  friend bool operator==(const LawParameter&, const LawParameter&) = default;
};

/// What the law declares, with the file's values. A controller of the user's own declares its parameters only when it
/// is started: for it, these are the parameters that the file sets, without a range.
std::vector<LawParameter> declared_parameters(const LawSpec& law);

/// What is allowed for this parameter during a run; empty: the value is allowed.
std::string wrong_parameter(std::span<const LawParameter> declared, std::string_view name, double value);

/// The values that the law in force logs for every robot, in the order of TickRecord::logged.
std::vector<std::string> log_names(const LawSpec& law);

}  // namespace skein::app
