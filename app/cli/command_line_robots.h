#pragma once

#include <optional>

#include <CLI/CLI.hpp>

#include "app/cli/commands.h"

namespace skein::app {

/// The words of `skein robots` on the command line.
class RobotCommands {
 public:
  void add_to(CLI::App& program);
  /// Does what was asked for and returns its ExitStatus; none: another command was.
  std::optional<int> run();

 private:
  CLI::App *list_ = nullptr, *test_ = nullptr, *stop_ = nullptr, *ping_ = nullptr, *scan_ = nullptr, *pair_ = nullptr;
  RobotsRequest request_;
};

}  // namespace skein::app
