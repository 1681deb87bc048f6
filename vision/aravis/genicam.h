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

/// What a call of Aravis says when it fails: given to the call by address, asked afterwards.
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

/// A text that may be null.
inline std::string text(const char* letters) {
  return letters == nullptr ? std::string() : letters;
}

}  // namespace skein::vision::detail
