#pragma once

#include <chrono>
#include <future>
#include <optional>

#include "app/replay/replay.h"

namespace skein::ui {

/// Reads a recorded run on a thread of its own: half an hour is a hundred megabytes of numbers.
class RecordingLoader {
 public:
  using Loaded = tl::expected<app::RecordedRun, std::string>;

  bool is_busy() const { return run_.valid(); }
  void load(const std::string& file) {
    run_ = std::async(std::launch::async, [file] { return app::load_run(file); });
  }
  /// The run, once, as soon as it is read.
  std::optional<Loaded> take() {
    if (!run_.valid() || run_.wait_for(std::chrono::seconds(0)) != std::future_status::ready) return {};
    return run_.get();
  }

 private:
  std::future<Loaded> run_;
};

}  // namespace skein::ui
