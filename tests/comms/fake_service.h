#pragma once

#include <sys/types.h>
#include <systemd/sd-bus.h>

#include <atomic>
#include <string>
#include <thread>

namespace skein::test {

/// A message bus of its own, from the dbus-daemon program, that stands for the system's as long as this lives.
class PrivateBus {
 public:
  PrivateBus();  ///< see running()
  ~PrivateBus();
  PrivateBus(const PrivateBus&) = delete;
  PrivateBus& operator=(const PrivateBus&) = delete;
  bool running() const noexcept { return !address_.empty(); }  ///< false: there is no dbus-daemon on this machine
  const std::string& address() const noexcept { return address_; }

 private:
  pid_t daemon_ = -1;
  std::string address_;
};

/// What the services of tests share: a connection to the bus, and a thread that answers.
class FakeService {
 public:
  FakeService(const FakeService&) = delete;
  FakeService& operator=(const FakeService&) = delete;

 protected:
  explicit FakeService(const PrivateBus& bus);
  ~FakeService();
  /// Last in the constructor: from now on callbacks are called, on the thread.
  void serve(const char* name);
  /// First in the destructor: no callback is called any more.
  void end();

  sd_bus* bus_ = nullptr;

 private:
  std::atomic<bool> ending_{false};
  std::thread thread_;
};

}  // namespace skein::test
