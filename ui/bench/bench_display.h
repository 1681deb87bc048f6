#pragma once

#include <sys/types.h>

namespace skein::ui {

/// A display for a window that is measured. If there is none, an Xvfb of its own, which draws in software and is not
/// visible; without Xvfb, Qt's platform "offscreen". Make it before the application.
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
