#include "app/run/output.h"

#include <fcntl.h>
#include <poll.h>
#include <unistd.h>

#include <atomic>
#include <cerrno>
#include <chrono>
#include <condition_variable>
#include <cstdio>
#include <mutex>
#include <string>
#include <thread>

#include "app/run/output_error.h"
#include "app/run/terminal_text.h"

namespace skein::app {
namespace {

constexpr std::size_t most_waiting = 64 * 1024;

/// One of the two, with a thread that alone may be held up by it.
class Stream {
 public:
  explicit Stream(int descriptor) noexcept : descriptor_(descriptor) {}

  void print(std::string_view text, double patience) noexcept {
    try {
      std::unique_lock lock(mutex_);
      if (!started_) {
        std::thread([this] { run(); }).detach();
        started_ = true;
      }
      // What is asked to be waited for may be long; the rest must not fill the memory behind a reader that sleeps.
      const bool is_behind = !waiting_.empty() || writing_;
      if (patience <= short_patience && is_behind && waiting_.size() + text.size() > most_waiting) return;
      waiting_ += text;
      added_.notify_one();
      if (stuck_ && patience <= short_patience) return;  // many short waits are a long one
      stuck_ = !all_is_written(lock, patience);
    } catch (...) {  // no memory, no thread: there is no way left to report it
    }
  }

  void finish(double patience) noexcept {
    try {
      std::unique_lock lock(mutex_);
      all_is_written(lock, patience);
    } catch (...) {
    }
  }

  int error() const noexcept { return error_; }

 private:
  /// Waits for it, at most `patience`. [s]
  bool all_is_written(std::unique_lock<std::mutex>& lock, double patience) {
    return written_.wait_for(lock, std::chrono::duration<double>(patience),
                             [this] { return waiting_.empty() && !writing_; });
  }

  void run() noexcept {
    try {
      std::unique_lock lock(mutex_);
      for (std::string text;;) {
        added_.wait(lock, [this] { return !waiting_.empty(); });
        text.swap(waiting_);
        waiting_.clear();
        writing_ = true;
        lock.unlock();
        for (std::string_view rest = text; !rest.empty();) {
          const ssize_t count = ::write(descriptor_, rest.data(), rest.size());
          if (count < 0 && errno == EAGAIN) {  // another program has made it non-blocking
            std::this_thread::sleep_for(std::chrono::milliseconds(5));
            continue;
          }
          if (count < 0 && errno != EINTR) {  // it is gone, or full
            error_ = errno;
            break;
          }
          if (count > 0) rest.remove_prefix(static_cast<std::size_t>(count));
        }
        lock.lock();
        writing_ = stuck_ = false;
        written_.notify_all();
      }
    } catch (...) {
    }
  }

  const int descriptor_;
  std::atomic<int> error_{0};
  std::mutex mutex_;
  std::condition_variable added_, written_;
  std::string waiting_;
  bool started_ = false, writing_ = false, stuck_ = false;
};

/// Never destroyed: its thread may be in a write that does not end. A program without memory for it ends here.
Stream& stream(int descriptor) noexcept {
  static Stream* const out = new Stream(STDOUT_FILENO);    // NOLINT(bugprone-unhandled-exception-at-new)
  static Stream* const error = new Stream(STDERR_FILENO);  // NOLINT(bugprone-unhandled-exception-at-new)
  return descriptor == STDOUT_FILENO ? *out : *error;
}

void print_shown(int descriptor, std::string_view text, double patience) noexcept {
  try {
    stream(descriptor).print(shown_lines(text), patience);
  } catch (...) {  // no memory
  }
}

}  // namespace

void print_out(std::string_view text, double patience) noexcept {
  if (::isatty(STDOUT_FILENO) != 0) return print_shown(STDOUT_FILENO, text, patience);
  stream(STDOUT_FILENO).print(text, patience);
}

void print_error(std::string_view text, double patience) noexcept {
  print_shown(STDERR_FILENO, text, patience);
}

void print_error_as_is(std::string_view text, double patience) noexcept {
  stream(STDERR_FILENO).print(text, patience);
}

int output_error() noexcept {
  int error = stream(STDOUT_FILENO).error();
  if (error == 0 && std::fflush(stdout) != 0) error = errno;  // some is printed through the C library
  if (error == 0 && std::ferror(stdout) != 0) {
    // An earlier one, whose reason nobody kept; but a reader that has gone is still gone.
    pollfd out{STDOUT_FILENO, 0, 0};
    error = ::poll(&out, 1, 0) > 0 && (out.revents & POLLERR) != 0 ? EPIPE : EIO;
  }
  return error == EPIPE ? 0 : error;
}

void complain(std::string_view sentence) noexcept {
  try {
    complain_lines(shown(sentence));
  } catch (...) {  // no memory
  }
}

void complain_lines(std::string_view sentences) noexcept {
  try {
    print_error("skein: " + std::string(sentences) + "\n");
  } catch (...) {
  }
}

void finish_output(double patience) noexcept {
  const auto until = std::chrono::steady_clock::now() + std::chrono::duration<double>(patience);
  for (const int descriptor : {STDOUT_FILENO, STDERR_FILENO})
    stream(descriptor).finish(std::chrono::duration<double>(until - std::chrono::steady_clock::now()).count());
}

void fill_standard_descriptors() noexcept {
  for (int descriptor = 0; descriptor <= 2; ++descriptor)
    if (::fcntl(descriptor, F_GETFD) < 0 && errno == EBADF)
      if (::open("/dev/null", descriptor == 0 ? O_RDONLY : O_WRONLY) < 0) return;
}

}  // namespace skein::app
