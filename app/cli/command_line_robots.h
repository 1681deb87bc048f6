#pragma once

#include <optional>

#include <CLI/CLI.hpp>

#include "app/cli/commands.h"

namespace skein::app {

/// The options of `skein robots`.
class RobotCommands {
 public:
  void add_to(CLI::App& program);
  /// Executes the given command and returns its ExitStatus; none: another command was given.
  std::optional<int> run();

 private:
  CLI::App *list_ = nullptr, *test_ = nullptr, *stop_ = nullptr, *forget_ = nullptr, *ping_ = nullptr;
  CLI::App *scan_ = nullptr, *pair_ = nullptr;
  RobotsRequest request_;
};

}  // namespace skein::app
