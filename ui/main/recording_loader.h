#pragma once

#include "app/replay/replay.h"
#include "ui/base/aside.h"

namespace skein::ui {

/// Half an hour of a recorded run is a hundred megabytes of numbers.
class RecordingLoader : public Aside<tl::expected<app::RecordedRun, std::string>> {
 public:
  void load(const std::string& file) {
    run([file](const std::stop_token&) { return app::load_run(file); });
  }
};

}  // namespace skein::ui
