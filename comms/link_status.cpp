#include "comms/link_status.h"

namespace skein::comms {

std::string_view to_text(LinkState state) noexcept {
  switch (state) {
    case LinkState::down:
      return "down";
    case LinkState::connecting:
      return "connecting";
    case LinkState::synchronising:
      return "synchronising";
    case LinkState::up:
      return "up";
    case LinkState::stale:
      return "stale";
    case LinkState::failed:
      return "failed";
    case LinkState::closed:
      return "closed";
  }
  return "?";
}

std::optional<LinkState> link_state(std::string_view word) noexcept {
  for (int state = 0; state <= static_cast<int>(LinkState::closed); ++state)
    if (word == to_text(static_cast<LinkState>(state))) return static_cast<LinkState>(state);
  return std::nullopt;
}

}  // namespace skein::comms
