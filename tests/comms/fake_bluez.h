#pragma once

#include <systemd/sd-bus.h>

#include <atomic>
#include <string>
#include <vector>

#include "tests/comms/fake_service.h"

namespace skein::test {

struct FakeAdapter {
  std::string name = "hci0", address = "00:1A:7D:DA:71:13";
  bool powered = true;
};
struct FakeDevice {
  std::string name, address, adapter = "hci0";
  std::string pin = {};  ///< what it wants to hear; empty: it pairs by itself
  bool paired = false;
  bool known = false;    ///< from before; otherwise it must be looked for
  bool answers = true;   ///< when it is to be paired
  bool refuses = false;  // to pair, before anybody is asked for a PIN
};

/// org.bluez on a bus, as far as Skein speaks with it: adapters, discovery, devices, agents, pairing. On a thread of
/// its own; adapters and devices are looked at when it ends.
class FakeBluez : public FakeService {
 public:
  FakeBluez(const PrivateBus& bus, std::vector<FakeAdapter> adapters, std::vector<FakeDevice> devices);
  ~FakeBluez();

  int discoveries() const noexcept { return discoveries_.load(); }  ///< going on now
  int agents() const noexcept { return agents_.load(); }            ///< registered now

 private:
  static int on_message(sd_bus_message* m, void* self, sd_bus_error*);
  static int on_agent_reply(sd_bus_message* m, void* self, sd_bus_error*);
  int answer(sd_bus_message* m);
  int describe(sd_bus_message* m);
  int pair(sd_bus_message* m);
  bool visible(const FakeDevice& device) const;

  std::vector<FakeAdapter> adapters_;
  std::vector<FakeDevice> devices_;
  std::atomic<int> discoveries_{0}, agents_{0};
  std::string agent_path_;
  sd_bus_message* pairing_ = nullptr;  // the call that waits for its agent
  FakeDevice* paired_with_ = nullptr;
};

}  // namespace skein::test
