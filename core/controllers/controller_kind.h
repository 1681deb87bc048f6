#pragma once

#include <string_view>

namespace skein::core {

/// The built-in laws.
enum class ControllerKind {
  kostic,             ///< (15): saturated tracking, mutual coupling
  virtual_structure,  ///< van den Broek, van de Wouw, Nijmeijer 2009
  leader_follower,    ///< l-phi: Desai, Ostrowski, Kumar 2001
  independent,        ///< every robot on its own: (15) without any coupling
};

/// As files call it (core/words.h).
constexpr std::string_view word(ControllerKind kind) noexcept {
  switch (kind) {
    case ControllerKind::kostic:
      return "kostic";
    case ControllerKind::virtual_structure:
      return "virtual_structure";
    case ControllerKind::leader_follower:
      return "leader_follower";
    case ControllerKind::independent:
      return "independent";
  }
  return {};
}

}  // namespace skein::core
