#include "comms/system_services.h"

#include <fmt/format.h>

#include <fcntl.h>
#include <systemd/sd-bus.h>
#include <unistd.h>

#include <cstdint>
#include <cstdlib>
#include <cstring>
#include <memory>
#include <utility>

namespace skein::comms {
namespace {

constexpr std::uint64_t patience_us = 2'000'000;

// The lid of a laptop is not subject to "sleep" (LidSwitchIgnoreInhibited, on as a rule), but to a lock of its own,
// which logind may grant to fewer people. It holds unless the program's session is in the background
// (manager_handle_action and manager_is_inhibited in systemd's src/login).
constexpr const char* sleep_and_lid = "sleep:handle-lid-switch";
constexpr const char* sleep_alone = "sleep";

/// A connection to a bus, and what a call over it came to.
struct Call {
  explicit Call(int (*open)(sd_bus**)) : result(open(&bus)) {
    if (result >= 0) sd_bus_set_method_call_timeout(bus, patience_us);
  }
  ~Call() {
    sd_bus_error_free(&error);
    sd_bus_message_unref(reply);
    sd_bus_flush_close_unref(bus);
  }
  Call(const Call&) = delete;
  Call& operator=(const Call&) = delete;

  /// Why it failed. `name`, `otherwise`: of the bus, and its address if `variable` names none.
  std::string problem(const char* name, const char* variable, const char* otherwise) const {
    const char* const address = std::getenv(variable);
    const std::string where = bus != nullptr ? "" : fmt::format("{}, {}: ", name, address ? address : otherwise);
    return where + (error.message != nullptr ? error.message : std::strerror(result < 0 ? -result : 0));
  }

  sd_bus* bus = nullptr;
  sd_bus_message* reply = nullptr;
  sd_bus_error error = SD_BUS_ERROR_NULL;
  int result;
};

struct LogindLock {
  explicit LogindLock(int number) : number(number) {}
  ~LogindLock() { ::close(number); }
  LogindLock(const LogindLock&) = delete;
  LogindLock& operator=(const LogindLock&) = delete;
  int number;
};

/// The machine does not do `which` as long as what is returned exists.
Inhibitor::Answer ask_logind(const char* which, const std::string& what) {
  Call call(sd_bus_open_system);
  int lock = -1;
  if (call.result >= 0)
    call.result = sd_bus_call_method(call.bus, "org.freedesktop.login1", "/org/freedesktop/login1",
                                     "org.freedesktop.login1.Manager", "Inhibit", &call.error, &call.reply, "ssss",
                                     which, "skein", what.c_str(), "block");
  if (call.result >= 0) call.result = sd_bus_message_read(call.reply, "h", &lock);
  if (call.result >= 0) call.result = lock = ::fcntl(lock, F_DUPFD_CLOEXEC, 3);  // the message's own goes with it
  if (call.result < 0)
    return {nullptr, call.problem("the system bus", "DBUS_SYSTEM_BUS_ADDRESS", "/run/dbus/system_bus_socket")};
  return {std::make_shared<LogindLock>(lock), {}};
}

}  // namespace

Inhibitor::Answer inhibit_sleep(const std::string& what) {
  Inhibitor::Answer both = ask_logind(sleep_and_lid, what);
  if (both.held) return both;
  Inhibitor::Answer alone = ask_logind(sleep_alone, what);
  if (alone.held) alone.problem = "when its lid is closed: " + both.problem;
  return alone;
}

Inhibitor::Answer inhibit_screen_lock(const std::string& what) {
  Call call(sd_bus_open_user);
  if (call.result >= 0)
    call.result = sd_bus_call_method(call.bus, "org.freedesktop.ScreenSaver", "/org/freedesktop/ScreenSaver",
                                     "org.freedesktop.ScreenSaver", "Inhibit", &call.error, &call.reply, "ss", "skein",
                                     what.c_str());
  if (call.result < 0) return {nullptr, call.problem("the session bus", "DBUS_SESSION_BUS_ADDRESS", "none")};
  // It ends with the connection.
  return {std::shared_ptr<sd_bus>(std::exchange(call.bus, nullptr), sd_bus_flush_close_unref), {}};
}

bool move_to_own_scope(pid_t process, const char* name, const char* description) {
  const std::string unit = fmt::format("{}-{}.scope", name, process);
  for (int (*const open)(sd_bus**) : {sd_bus_open_user, sd_bus_open_system}) {
    Call call(open);
    if (call.result >= 0)
      call.result =
          sd_bus_call_method(call.bus, "org.freedesktop.systemd1", "/org/freedesktop/systemd1",
                             "org.freedesktop.systemd1.Manager", "StartTransientUnit", &call.error, &call.reply,
                             "ssa(sv)a(sa(sv))", unit.c_str(), "fail", 3, "Description", "s", description, "PIDs", "au",
                             1, static_cast<std::uint32_t>(process), "CollectMode", "s", "inactive-or-failed", 0);
    if (call.result >= 0) return true;
  }
  return false;
}

}  // namespace skein::comms
