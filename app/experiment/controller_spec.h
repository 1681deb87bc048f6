#pragma once

#include <cstdint>
#include <optional>
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
  /// Whether it is the law of the gains of [controller], for which (18) to (20) hold.
  bool of_the_paper() const noexcept { return !own() && kind == core::ControllerKind::kostic; }
  std::vector<std::pair<std::string, double>> own_parameters;  ///< as the file has them
  std::vector<std::string> log;                                ///< the logged values that the CSV contains

  /// What drives a robot at a tick without a valid answer of its own controller.
  enum class Failure {
    hold,      ///< nothing: it stops
    built_in,  ///< the law `kind`
  };
  Failure failure = Failure::hold;
  /// Deadline from question to answer [s, wall clock]; empty: a quarter of a period, or half a second if the
  /// experiment's clock waits for it.
  std::optional<double> deadline;
  std::int64_t memory = 2048;   ///< limit of each of its processes [MB]
  std::int64_t processes = 16;  ///< that it may start itself; 0: none

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

/// The values that the law in force logs for every robot, in the order of TickRecord::logged.
std::vector<std::string> log_names(const LawSpec& law);

}  // namespace skein::app
