#pragma once

#include <sys/types.h>

namespace skein::ui {

/// Something for a window to be drawn on while it is measured. Where there is no display, an Xvfb of its own, which
/// draws in software and which nobody sees; where there is no Xvfb either, Qt's platform "offscreen". Before the
/// application.
class BenchDisplay {
 public:
  BenchDisplay();
  ~BenchDisplay();  ///< ends the Xvfb
  BenchDisplay(const BenchDisplay&) = delete;
  BenchDisplay& operator=(const BenchDisplay&) = delete;

 private:
  pid_t server_ = 0;
};

}  // namespace skein::ui
