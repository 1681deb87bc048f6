#include "ui/base/compositor.h"

#include <wayland-client-core.h>

#include <cstdlib>

namespace skein::ui {
namespace {

/// Without the variable the library would try "wayland-0": some session's, which may not show this window.
wl_display* connect() {
  return std::getenv("WAYLAND_DISPLAY") != nullptr ? wl_display_connect(nullptr) : nullptr;
}

}  // namespace

void Compositor::Disconnect::operator()(wl_display* display) const {
  wl_display_disconnect(display);
}

Compositor::Compositor() : connection_(connect()) {}

void Compositor::ask() {
  if (connection_ && wl_display_roundtrip(connection_.get()) < 0) connection_.reset();
}

}  // namespace skein::ui
