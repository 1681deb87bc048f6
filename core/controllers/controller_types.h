#pragma once

#include <memory>
#include <span>
#include <string_view>

#include "core/controllers/controller.h"
#include "core/controllers/controller_kind.h"

namespace skein::core {

/// A built-in law: one row of the table. A new one needs a class, an enumerator with its word, and a row.
struct ControllerType {
  ControllerKind kind;
  std::string_view help;
  std::span<const ControllerParameter> parameters;
  std::span<const std::string_view> logs;  ///< names of the values that it logs for each robot
  std::unique_ptr<Controller> (*make)(std::size_t robots);
};
const ControllerType& controller_type(ControllerKind kind) noexcept;

}  // namespace skein::core
