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

}  // namespace skein::comms
