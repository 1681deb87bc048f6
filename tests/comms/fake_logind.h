#pragma once

#include <systemd/sd-bus.h>

#include <mutex>
#include <string>
#include <vector>

#include "tests/comms/fake_service.h"

namespace skein::test {

/// org.freedesktop.login1 on a bus, as far as Skein speaks with it: inhibitors, each a descriptor that whoever asked
/// keeps open. On a thread of its own.
class FakeLogind : public FakeService {
 public:
  /// `refusal`: what it says to whoever asks for `what`, empty: for anything; empty: it grants.
  explicit FakeLogind(const PrivateBus& bus, std::string refusal = {}, std::string what = {});
  ~FakeLogind();

  int inhibitors() const;                   ///< of the mode "block", held now
  int delays() const;                       ///< of the mode "delay", held now
  int asked() const;                        ///< times that somebody asked for the mode "block"
  std::vector<std::string> newest() const;  ///< what, who, why and mode of the newest "block"
  /// The signal `name`, PrepareForSleep or PrepareForShutdown: the machine is about to (true), or has done it.
  void announce(const char* name, bool begins);

 private:
  static int on_message(sd_bus_message* m, void* self, sd_bus_error* error);
  int inhibit(sd_bus_message* m, sd_bus_error* error);

  const PrivateBus& whole_bus_;
  const std::string refusal_, refused_;
  mutable std::mutex mutex_;
  std::vector<std::string> newest_;  // guarded by mutex_
  std::vector<int> locks_, delays_;  // guarded by mutex_; reading ends: at their end once they are let go
  int asked_ = 0;                    // guarded by mutex_
};

}  // namespace skein::test
