#include "comms/sleep_inhibitor.h"

#include <fmt/format.h>

#include <fcntl.h>
#include <systemd/sd-bus.h>
#include <unistd.h>

#include <cstdlib>
#include <cstring>
#include <system_error>
#include <tl/expected.hpp>
#include <utility>

namespace skein::comms {
namespace {

constexpr std::uint64_t patience_us = 2'000'000;

// The lid of a laptop is not subject to "sleep" (LidSwitchIgnoreInhibited, on as a rule), but to a lock of its own,
// which logind may grant to fewer people. It holds unless the program's session is in the background
// (manager_handle_action and manager_is_inhibited in systemd's src/login).
constexpr const char* sleep_and_lid = "sleep:handle-lid-switch";
constexpr const char* sleep_alone = "sleep";

/// The machine does not do `which` as long as this descriptor is open.
tl::expected<int, std::string> inhibit(const char* which, const std::string& what) {
  sd_bus* bus = nullptr;
  sd_bus_message* reply = nullptr;
  sd_bus_error error = SD_BUS_ERROR_NULL;
  int lock = -1;
  int result = sd_bus_open_system(&bus);
  if (result >= 0) {
    sd_bus_set_method_call_timeout(bus, patience_us);
    result =
        sd_bus_call_method(bus, "org.freedesktop.login1", "/org/freedesktop/login1", "org.freedesktop.login1.Manager",
                           "Inhibit", &error, &reply, "ssss", which, "skein", what.c_str(), "block");
  }
  if (result >= 0) result = sd_bus_message_read(reply, "h", &lock);
  if (result >= 0) result = lock = ::fcntl(lock, F_DUPFD_CLOEXEC, 3);  // the message's own goes with it
  const char* const address = std::getenv("DBUS_SYSTEM_BUS_ADDRESS");
  const std::string where =
      bus != nullptr ? "" : fmt::format("the system bus, {}: ", address ? address : "/run/dbus/system_bus_socket");
  const std::string reason =
      where + (error.message != nullptr ? error.message : std::strerror(result < 0 ? -result : 0));
  sd_bus_error_free(&error);
  sd_bus_message_unref(reply);
  sd_bus_flush_close_unref(bus);
  if (result < 0) return tl::unexpected(reason);
  return lock;
}

}  // namespace

SleepInhibitor::SleepInhibitor(std::string what) : what_(std::move(what)) {
  try {
    thread_ = std::thread([this] { run(); });
  } catch (const std::system_error& error) {
    problem_ = error.what();
  }
}

SleepInhibitor::~SleepInhibitor() {
  {
    const std::lock_guard lock(mutex_);
    ends_ = true;
    wanted_ = false;
  }
  changed_.notify_all();
  if (thread_.joinable()) thread_.join();
}

void SleepInhibitor::hold(bool on) noexcept {
  {
    const std::lock_guard lock(mutex_);
    if (std::exchange(wanted_, on) == on) return;
    asked_ = false;
  }
  changed_.notify_all();
}

bool SleepInhibitor::held() const {
  const std::lock_guard lock(mutex_);
  return lock_ >= 0;
}

std::string SleepInhibitor::problem() const {
  const std::lock_guard lock(mutex_);
  return problem_;
}

void SleepInhibitor::run() {
  std::unique_lock lock(mutex_);
  while (true) {
    changed_.wait(lock, [this] { return ends_ || (wanted_ ? lock_ < 0 && !asked_ : lock_ >= 0); });
    if (!wanted_ && lock_ >= 0) ::close(std::exchange(lock_, -1));
    if (ends_) return;
    if (!wanted_) continue;
    asked_ = true;  // once each time that it is wanted
    lock.unlock();
    const auto both = inhibit(sleep_and_lid, what_);
    const auto got = both ? both : inhibit(sleep_alone, what_);
    lock.lock();
    if (got) lock_ = *got;
    if (!got)
      problem_ = got.error();
    else if (!both)
      problem_ = "when its lid is closed: " + both.error();
  }
}

}  // namespace skein::comms
