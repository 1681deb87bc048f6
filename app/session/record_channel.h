#pragma once

#include <atomic>
#include <boost/lockfree/spsc_queue.hpp>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "app/run/tick_record.h"

namespace skein::app {

/// Carries records from the control thread to one other thread. Bounded, lock-free, allocates only in the constructor:
/// records are copied into its own pool. When the reader is too slow, new records are dropped and counted; the control
/// thread never waits.
class RecordChannel {
 public:
  /// `prototype`: a record of the run's size.
  RecordChannel(std::size_t capacity, const TickRecord& prototype)
      : pool_(capacity, prototype), free_(capacity), filled_(capacity) {
    for (TickRecord& record : pool_) {
      record.events.reserve(prototype.events.limit());
      free_.push(&record);
    }
  }

  /// The control thread's side.
  void push(const TickRecord& record) noexcept {
    TickRecord* slot = nullptr;
    if (!free_.pop(slot)) {
      dropped_.fetch_add(1, std::memory_order_relaxed);
      return;
    }
    *slot = record;  // same sizes: no allocation
    filled_.push(slot);
  }

  /// The control thread's side: whether the next record would be dropped.
  bool full() const noexcept { return free_.read_available() == 0; }

  /// The reader's side: all waiting records, oldest first.
  template <typename Take>
  std::size_t drain(Take&& take) {
    std::size_t count = 0;
    for (TickRecord* slot = nullptr; filled_.pop(slot); ++count) {
      take(const_cast<const TickRecord&>(*slot));
      free_.push(slot);
    }
    return count;
  }

  std::uint64_t dropped() const noexcept { return dropped_.load(std::memory_order_relaxed); }

 private:
  std::vector<TickRecord> pool_;
  boost::lockfree::spsc_queue<TickRecord*> free_, filled_;
  std::atomic<std::uint64_t> dropped_{0};
};

}  // namespace skein::app
