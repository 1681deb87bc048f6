#pragma once

#include <memory>

struct wl_display;

namespace skein::ui {

/// The Wayland compositor that shows the window, if there is one: natively or through XWayland. While it hangs, nobody
/// sees the robots and no key arrives, but XWayland, a program of its own, goes on answering the window. So the window
/// asks the compositor over a connection of its own.
class Compositor {
 public:
  /// Connects to the one that WAYLAND_DISPLAY names; without one, `ask` does nothing.
  Compositor();
  /// Waits until it has answered. One that has ended is not asked again: Qt notices that by itself.
  void ask();

 private:
  struct Disconnect {
    void operator()(wl_display* display) const;
  };
  std::unique_ptr<wl_display, Disconnect> connection_;
};

}  // namespace skein::ui
