#pragma once

#include <chrono>
#include <future>
#include <optional>
#include <stop_token>
#include <utility>
#include <vector>

namespace skein::ui {

/// Work on a thread of its own, whose result the window's thread takes when it is there: nobody waits for it. New work
/// supersedes the one before, which is asked to end and whose result is dropped.
template <typename Result>
class Aside {
 public:
  Aside() = default;
  Aside(const Aside&) = delete;
  Aside& operator=(const Aside&) = delete;
  ~Aside() { drop(); }  ///< waits for what is under way

  /// `work` takes a stop token, which it may ignore, and returns the result.
  template <typename Work>
  void run(Work&& work) {
    drop();
    stop_ = {};
    running_ = std::async(std::launch::async, std::forward<Work>(work), stop_.get_token());
  }
  void drop() {
    stop_.request_stop();
    if (running_.valid()) dropped_.push_back(std::move(running_));  // its destructor would wait
    std::erase_if(dropped_, [](const auto& work) { return is_ready(work, std::chrono::seconds(0)); });
  }
  bool is_busy() const { return running_.valid(); }
  /// The result, once, as soon as it is there; waits for it no longer than `patience`.
  std::optional<Result> take(std::chrono::milliseconds patience = {}) {
    if (!running_.valid() || !is_ready(running_, patience)) return {};
    return running_.get();
  }

 private:
  static bool is_ready(const std::future<Result>& work, std::chrono::milliseconds patience) {
    return work.wait_for(patience) == std::future_status::ready;
  }

  std::stop_source stop_;
  std::future<Result> running_;
  std::vector<std::future<Result>> dropped_;
};

}  // namespace skein::ui
