#pragma once

#include <memory>
#include <span>
#include <string_view>

#include "core/controllers/controller.h"
#include "core/controllers/controller_kind.h"

namespace skein::core {

/// A law that is built in: one row of the table. A new one is a class, an enumerator with its word, and a row.
struct ControllerType {
  ControllerKind kind;
  std::string_view help;
  std::span<const ControllerParameter> parameters;
  std::span<const std::string_view> logs;  ///< names of what it logs of every robot
  std::unique_ptr<Controller> (*make)(std::size_t robots);
};
const ControllerType& controller_type(ControllerKind kind) noexcept;

}  // namespace skein::core
