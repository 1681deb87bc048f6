#include "tests/comms/fake_bluez.h"

#include <algorithm>
#include <string_view>
#include <utility>

namespace skein::test {
namespace {

void add_text(sd_bus_message* m, const char* key, const char* type, const std::string& value) {
  sd_bus_message_append(m, "{sv}", key, type, value.c_str());
}
void add_flag(sd_bus_message* m, const char* key, bool value) {
  sd_bus_message_append(m, "{sv}", key, "b", value ? 1 : 0);
}

// One object with one interface; `properties` appends them.
template <typename Properties>
void add_object(sd_bus_message* m, const std::string& path, const char* interface, Properties properties) {
  sd_bus_message_open_container(m, 'e', "oa{sa{sv}}");
  sd_bus_message_append(m, "o", path.c_str());
  sd_bus_message_open_container(m, 'a', "{sa{sv}}");
  sd_bus_message_append(m, "{sa{sv}}", "org.freedesktop.DBus.Introspectable", 0);
  sd_bus_message_open_container(m, 'e', "sa{sv}");
  sd_bus_message_append(m, "s", interface);
  sd_bus_message_open_container(m, 'a', "{sv}");
  properties();
  for (int open = 0; open < 4; ++open) sd_bus_message_close_container(m);
}

std::string path_of(const FakeAdapter& adapter) {
  return "/org/bluez/" + adapter.name;
}
std::string path_of(const FakeDevice& device) {
  std::string path = "/org/bluez/" + device.adapter + "/dev_" + device.address;
  std::replace(path.begin(), path.end(), ':', '_');
  return path;
}

}  // namespace

FakeBluez::FakeBluez(const PrivateBus& bus, std::vector<FakeAdapter> adapters, std::vector<FakeDevice> devices)
    : FakeService(bus), adapters_(std::move(adapters)), devices_(std::move(devices)) {
  sd_bus_add_fallback(bus_, nullptr, "/", on_message, this);
  serve("org.bluez");
}

FakeBluez::~FakeBluez() {
  end();
  sd_bus_message_unref(pairing_);
}

int FakeBluez::on_message(sd_bus_message* m, void* self, sd_bus_error*) {
  return static_cast<FakeBluez*>(self)->answer(m);
}

int FakeBluez::answer(sd_bus_message* m) {
  const std::string_view member = sd_bus_message_get_member(m);
  if (member == "GetManagedObjects") return describe(m);
  if (member == "Pair") return pair(m);
  if (member == "StartDiscovery") ++discoveries_;
  if (member == "StopDiscovery") --discoveries_;
  if (member == "UnregisterAgent") --agents_;
  if (member == "RegisterAgent") {
    ++agents_;
    const char* path = nullptr;
    sd_bus_message_read(m, "o", &path);
    agent_path_ = path;
  }
  return sd_bus_reply_method_return(m, "");
}

bool FakeBluez::visible(const FakeDevice& device) const {
  return device.known || device.paired || discoveries_ > 0;
}

int FakeBluez::describe(sd_bus_message* m) {
  sd_bus_message* reply = nullptr;
  sd_bus_message_new_method_return(m, &reply);
  sd_bus_message_open_container(reply, 'a', "{oa{sa{sv}}}");
  for (const FakeAdapter& adapter : adapters_)
    add_object(reply, path_of(adapter), "org.bluez.Adapter1", [&] {
      add_text(reply, "Address", "s", adapter.address);
      add_flag(reply, "Powered", adapter.powered);
      add_flag(reply, "Discovering", discoveries_ > 0);
    });
  for (const FakeDevice& device : devices_)
    if (visible(device))
      add_object(reply, path_of(device), "org.bluez.Device1", [&] {
        add_text(reply, "Address", "s", device.address);
        if (!device.name.empty()) add_text(reply, "Name", "s", device.name);
        add_text(reply, "Adapter", "o", "/org/bluez/" + device.adapter);
        add_flag(reply, "Paired", device.paired);
        if (discoveries_ > 0) sd_bus_message_append(reply, "{sv}", "RSSI", "n", -40);
        sd_bus_message_append(reply, "{sv}", "UUIDs", "as", 1, "00001101-0000-1000-8000-00805f9b34fb");
      });
  sd_bus_message_close_container(reply);
  const int sent = sd_bus_send(nullptr, reply, nullptr);
  sd_bus_message_unref(reply);
  return sent;
}

int FakeBluez::pair(sd_bus_message* m) {
  const auto device = std::find_if(devices_.begin(), devices_.end(),
                                   [m](const FakeDevice& d) { return path_of(d) == sd_bus_message_get_path(m); });
  if (device == devices_.end()) return sd_bus_reply_method_errorf(m, "org.bluez.Error.DoesNotExist", "no such device");
  if (!device->answers) return sd_bus_reply_method_errorf(m, "org.bluez.Error.ConnectionAttemptFailed", "Page Timeout");
  if (device->refuses)
    return sd_bus_reply_method_errorf(m, "org.bluez.Error.AuthenticationFailed", "Authentication Failed");
  pairing_ = sd_bus_message_ref(m);
  paired_with_ = &*device;
  return sd_bus_call_method_async(bus_, nullptr, sd_bus_message_get_sender(m), agent_path_.c_str(), "org.bluez.Agent1",
                                  device->pin.empty() ? "RequestAuthorization" : "RequestPinCode", on_agent_reply, this,
                                  "o", path_of(*device).c_str());
}

int FakeBluez::on_agent_reply(sd_bus_message* m, void* self, sd_bus_error*) {
  auto& bluez = *static_cast<FakeBluez*>(self);
  sd_bus_message* const call = std::exchange(bluez.pairing_, nullptr);
  FakeDevice& device = *bluez.paired_with_;
  const char* said = "";
  if (!device.pin.empty()) sd_bus_message_read(m, "s", &said);
  if (sd_bus_message_is_method_error(m, nullptr) == 0 && device.pin == said) {
    device.paired = true;
    sd_bus_reply_method_return(call, "");
  } else {
    sd_bus_reply_method_errorf(call, "org.bluez.Error.AuthenticationFailed", "Authentication Failed");
  }
  sd_bus_message_unref(call);
  return 1;
}

}  // namespace skein::test
