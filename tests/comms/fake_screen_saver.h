#pragma once

#include <systemd/sd-bus.h>

#include <mutex>
#include <set>
#include <string>
#include <vector>

#include "tests/comms/fake_service.h"

namespace skein::test {

/// org.freedesktop.ScreenSaver on a bus, as desktops have it: an inhibitor ends with the connection of whoever asked.
/// On a thread of its own.
class FakeScreenSaver : public FakeService {
 public:
  explicit FakeScreenSaver(const PrivateBus& bus);
  ~FakeScreenSaver();

  int inhibitors() const;                   ///< held now
  std::vector<std::string> newest() const;  ///< who and why

 private:
  static int on_message(sd_bus_message* m, void* self, sd_bus_error* error);
  static int on_name(sd_bus_message* m, void* self, sd_bus_error* error);

  mutable std::mutex mutex_;
  std::vector<std::string> newest_;  // guarded by mutex_
  std::set<std::string> holders_;    // guarded by mutex_; names on the bus
};

}  // namespace skein::test
