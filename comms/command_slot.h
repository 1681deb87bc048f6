#pragma once

#include <atomic>
#include <cstdint>

#include "comms/asercom.h"

namespace skein::comms {

/// The newest command for one robot, passed from the control thread to the link thread in one atomic word: a reader
/// gets a complete command and never an older one again. One writer at a time, any readers; all calls are wait-free.
/// Its accesses are sequentially consistent, as are those of the flag that wakes the link thread: who takes the flag
/// back and then looks sees each command that was put before the flag was set.
class CommandSlot {
 public:
  struct Content {
    WheelCommand command;
    std::uint16_t ticket = 0;  ///< counts the commands put here; 0 before the first; wraps past 0
    std::uint16_t epoch = 0;   ///< the emergency epoch (see LinkSupervisor) that the command was given in
  };

  void put(WheelCommand command, std::uint16_t epoch) noexcept {
    const std::uint16_t last = content().ticket;
    const auto ticket = static_cast<std::uint16_t>(last == 0xFFFF ? 1 : last + 1);
    word_.store(std::uint64_t{static_cast<std::uint16_t>(command.left)} |
                std::uint64_t{static_cast<std::uint16_t>(command.right)} << 16 | std::uint64_t{ticket} << 32 |
                std::uint64_t{epoch} << 48);
  }

  Content content() const noexcept {
    const std::uint64_t word = word_.load();
    return {.command = {.left = static_cast<std::int16_t>(word), .right = static_cast<std::int16_t>(word >> 16)},
            .ticket = static_cast<std::uint16_t>(word >> 32),
            .epoch = static_cast<std::uint16_t>(word >> 48)};
  }

 private:
  static_assert(std::atomic<std::uint64_t>::is_always_lock_free);
  std::atomic<std::uint64_t> word_{0};
};

}  // namespace skein::comms
