#include "comms/power_down_delay.h"

#include <fcntl.h>
#include <systemd/sd-bus.h>
#include <unistd.h>

#include <utility>

namespace skein::comms {
namespace {

constexpr const char *service = "org.freedesktop.login1", *object = "/org/freedesktop/login1",
                     *manager = "org.freedesktop.login1.Manager";

}  // namespace

struct PowerDownDelay::Bus {
  ~Bus() {
    sd_bus_close_unref(bus);
    if (lock >= 0) ::close(lock);
  }
  static int on_suspend(sd_bus_message* m, void* self, sd_bus_error*) {
    return static_cast<Bus*>(self)->hear(m, Announced::suspend);
  }
  static int on_shutdown(sd_bus_message* m, void* self, sd_bus_error*) {
    return static_cast<Bus*>(self)->hear(m, Announced::shutdown);
  }
  int hear(sd_bus_message* m, Announced what) {
    int begins = 0;  // 0: it is over, or was cancelled
    if (sd_bus_message_read(m, "b", &begins) >= 0 && begins != 0) announced = what;
    return 0;
  }
  static int on_lock(sd_bus_message* m, void* self, sd_bus_error*) {
    int number = -1;  // the message's own
    if (sd_bus_message_read(m, "h", &number) >= 0) static_cast<Bus*>(self)->lock = ::fcntl(number, F_DUPFD_CLOEXEC, 3);
    return 0;
  }

  sd_bus* bus = nullptr;
  int lock = -1;  // delays as long as it is open; -1: not granted yet
  Announced announced = Announced::nothing;
};

PowerDownDelay::PowerDownDelay(const std::string& what) : bus_(std::make_unique<Bus>()) {
  if (sd_bus_open_system(&bus_->bus) < 0) return;
  Bus* const self = bus_.get();
  sd_bus_match_signal_async(self->bus, nullptr, service, object, manager, "PrepareForSleep", Bus::on_suspend, nullptr,
                            self);
  sd_bus_match_signal_async(self->bus, nullptr, service, object, manager, "PrepareForShutdown", Bus::on_shutdown,
                            nullptr, self);
  sd_bus_call_method_async(self->bus, nullptr, service, object, manager, "Inhibit", Bus::on_lock, self, "ssss",
                           "shutdown:sleep", "skein", what.c_str(), "delay");
}

PowerDownDelay::~PowerDownDelay() = default;

PowerDownDelay::Announced PowerDownDelay::turn() noexcept {
  while (bus_->bus != nullptr) {
    const int more = sd_bus_process(bus_->bus, nullptr);
    if (more < 0) bus_->bus = sd_bus_close_unref(bus_->bus);  // the bus has gone
    if (more <= 0) break;
  }
  return std::exchange(bus_->announced, Announced::nothing);
}

}  // namespace skein::comms
