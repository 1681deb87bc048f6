#pragma once

#include <array>
#include <atomic>
#include <cstdint>

namespace skein::app {

/// Passes the newest value from one thread to another; older values that were not read are overwritten. Neither side
/// waits (a triple buffer): the writer fills `draft()` and publishes it, the reader takes the value published last.
template <typename T>
class Newest {
 public:
  explicit Newest(const T& prototype = {}) : buffers_{prototype, prototype, prototype} {}

  /// The writer's own buffer. It holds an old value: overwrite all of it.
  T& draft() noexcept { return buffers_[write_]; }
  void publish() noexcept { write_ = shared_.exchange(write_ | fresh, std::memory_order_acq_rel) & index; }

  /// Takes the newest value into `value()`; false: nothing new since the last call.
  bool take() noexcept {
    if ((shared_.load(std::memory_order_relaxed) & fresh) == 0) return false;
    read_ = shared_.exchange(read_, std::memory_order_acq_rel) & index;
    return true;
  }
  /// The value of the last `take`: the reader's own.
  const T& value() const noexcept { return buffers_[read_]; }

 private:
  static constexpr std::uint8_t index = 3, fresh = 4;

  std::array<T, 3> buffers_;
  std::uint8_t write_ = 0;  // the writer's
  std::uint8_t read_ = 1;   // the reader's
  std::atomic<std::uint8_t> shared_{2};
};

}  // namespace skein::app
