#pragma once

#include <arv.h>

#include <memory>
#include <string>

namespace skein::vision::detail {

struct Unref {
  void operator()(void* object) const { g_object_unref(object); }
};
struct Free {
  void operator()(const void* memory) const { g_free(const_cast<void*>(memory)); }
};
template <typename T>
using Object = std::unique_ptr<T, Unref>;

/// The error of an Aravis call: pass its address to the call, read it afterwards.
class Failure {
 public:
  Failure() = default;
  ~Failure() { g_clear_error(&error_); }
  Failure(const Failure&) = delete;
  Failure& operator=(const Failure&) = delete;

  /// For the next call; forgets the last failure.
  GError** operator&() {
    g_clear_error(&error_);
    return &error_;
  }
  explicit operator bool() const { return error_ != nullptr; }
  std::string text() const { return error_ == nullptr ? std::string() : error_->message; }

 private:
  GError* error_ = nullptr;
};

/// Detects a camera that does not answer: pass its address to calls, as with Failure; it keeps the first call that got
/// no answer. A feature that the camera lacks does not count.
class Silence {
 public:
  Silence() = default;
  ~Silence() { g_clear_error(&error_); }
  Silence(const Silence&) = delete;
  Silence& operator=(const Silence&) = delete;

  GError** operator&() {
    keep();
    return &error_;
  }
  /// Empty, or why the first call had no answer.
  std::string text() {
    keep();
    return first_;
  }

 private:
  void keep() {
    const bool silent = g_error_matches(error_, ARV_DEVICE_ERROR, ARV_DEVICE_ERROR_TIMEOUT) ||
                        g_error_matches(error_, ARV_DEVICE_ERROR, ARV_DEVICE_ERROR_NOT_CONNECTED) ||
                        g_error_matches(error_, ARV_DEVICE_ERROR, ARV_DEVICE_ERROR_TRANSFER_ERROR);
    if (silent && first_.empty()) first_ = error_->message;
    g_clear_error(&error_);
  }

  GError* error_ = nullptr;
  std::string first_;
};

/// A text that may be null.
inline std::string text(const char* letters) {
  return letters == nullptr ? std::string() : letters;
}

}  // namespace skein::vision::detail
