#include "comms/bluez_bus.h"

#include <fmt/format.h>
#include <systemd/sd-bus.h>

#include <algorithm>
#include <cctype>
#include <chrono>
#include <cstdlib>
#include <cstring>
#include <string_view>
#include <thread>

namespace skein::comms {
namespace {

using Clock = std::chrono::steady_clock;

constexpr const char* daemon = "org.bluez";
constexpr const char* agent_path = "/skein/agent";
constexpr std::uint64_t slice_us = 50'000;  // between two questions whether to go on

/// sd_bus_error that is freed.
struct Error {
  sd_bus_error value = SD_BUS_ERROR_NULL;
  Error() = default;
  ~Error() { sd_bus_error_free(&value); }
  Error(const Error&) = delete;
  Error& operator=(const Error&) = delete;
};

struct Unref {
  void operator()(sd_bus_message* message) const noexcept { sd_bus_message_unref(message); }
  void operator()(sd_bus_slot* slot) const noexcept { sd_bus_slot_unref(slot); }
};
using Message = std::unique_ptr<sd_bus_message, Unref>;
using Slot = std::unique_ptr<sd_bus_slot, Unref>;

/// What the bus or the daemon said, for the operator.
std::string sentence(const sd_bus_error& error, int result) {
  const std::string_view name = error.name == nullptr ? "" : error.name;
  const auto is = [name](std::string_view end) { return name.ends_with(end); };
  if (is(".ServiceUnknown") || is(".NameHasNoOwner") || name.find(".Spawn.") != name.npos)
    return "no Bluetooth daemon on the system bus: start it with \"systemctl start bluetooth\"";
  if (name == "org.freedesktop.DBus.Error.AccessDenied")
    return "the system bus refuses access to the Bluetooth daemon: is the user in the group bluetooth?";
  if (is(".NotReady")) return "the adapter is off: \"bluetoothctl power on\" switches it on";
  if (is(".AuthenticationFailed") || is(".AuthenticationRejected")) return "the robot refuses to pair";
  if (is(".AuthenticationTimeout") || is(".NoReply") || is(".Timeout")) return "the robot did not answer in time";
  if (is(".AuthenticationCanceled")) return "pairing was cancelled";
  if (is(".ConnectionAttemptFailed"))
    return "the robot does not answer: is it switched on and in range? An e-puck2 pairs only when its button is held "
           "while it is switched on";
  const std::string_view what = error.message == nullptr ? std::strerror(-result) : error.message;
  return name.empty() ? std::string(what) : fmt::format("{} ({})", what, name);
}

/// Reads the value of one property, a variant, if it is of that type; passes over it otherwise.
void read(sd_bus_message* m, std::string& into) {
  const char* text = nullptr;
  char type = 0;
  const char* contents = nullptr;
  sd_bus_message_peek_type(m, &type, &contents);
  if (contents == nullptr || (std::strcmp(contents, "s") != 0 && std::strcmp(contents, "o") != 0)) {
    sd_bus_message_skip(m, "v");
    return;
  }
  const std::string signature = contents;
  sd_bus_message_enter_container(m, SD_BUS_TYPE_VARIANT, signature.c_str());
  if (sd_bus_message_read_basic(m, signature[0], &text) > 0) into = text;
  sd_bus_message_exit_container(m);
}
void read(sd_bus_message* m, bool& into) {
  int value = 0;
  if (sd_bus_message_read(m, "v", "b", &value) > 0) into = value != 0;
}

/// The properties {sv}* of one interface, each handed to `take_property` with the message at its value.
template <typename TakeProperty>
void read_properties(sd_bus_message* m, TakeProperty take_property) {
  sd_bus_message_enter_container(m, SD_BUS_TYPE_ARRAY, "{sv}");
  while (sd_bus_message_enter_container(m, SD_BUS_TYPE_DICT_ENTRY, "sv") > 0) {
    const char* key = nullptr;
    sd_bus_message_read_basic(m, SD_BUS_TYPE_STRING, &key);
    take_property(std::string_view(key));
    sd_bus_message_exit_container(m);
  }
  sd_bus_message_exit_container(m);
}

BluezAdapter read_adapter(sd_bus_message* m, const char* path) {
  BluezAdapter adapter{.path = path, .address = {}};
  read_properties(m, [&](std::string_view key) {
    if (key == "Address")
      read(m, adapter.address);
    else if (key == "Powered")
      read(m, adapter.powered);
    else
      sd_bus_message_skip(m, "v");
  });
  return adapter;
}

BluezDevice read_device(sd_bus_message* m, const char* path) {
  BluezDevice device;
  device.path = path;
  read_properties(m, [&](std::string_view key) {
    if (key == "Address")
      read(m, device.address);
    else if (key == "Name")
      read(m, device.name);
    else if (key == "Adapter")
      read(m, device.adapter_path);
    else if (key == "Paired")
      read(m, device.paired);
    else {
      if (key == "RSSI") device.heard = true;
      sd_bus_message_skip(m, "v");
    }
  });
  return device;
}

/// a{oa{sa{sv}}}, the answer of GetManagedObjects.
BluezObjects read_objects(sd_bus_message* m) {
  BluezObjects all;
  sd_bus_message_enter_container(m, SD_BUS_TYPE_ARRAY, "{oa{sa{sv}}}");
  while (sd_bus_message_enter_container(m, SD_BUS_TYPE_DICT_ENTRY, "oa{sa{sv}}") > 0) {
    const char* path = nullptr;
    sd_bus_message_read_basic(m, SD_BUS_TYPE_OBJECT_PATH, &path);
    sd_bus_message_enter_container(m, SD_BUS_TYPE_ARRAY, "{sa{sv}}");
    while (sd_bus_message_enter_container(m, SD_BUS_TYPE_DICT_ENTRY, "sa{sv}") > 0) {
      const char* interface = nullptr;
      sd_bus_message_read_basic(m, SD_BUS_TYPE_STRING, &interface);
      if (std::strcmp(interface, "org.bluez.Adapter1") == 0)
        all.adapters.push_back(read_adapter(m, path));
      else if (std::strcmp(interface, "org.bluez.Device1") == 0)
        all.devices.push_back(read_device(m, path));
      else
        sd_bus_message_skip(m, "a{sv}");
      sd_bus_message_exit_container(m);
    }
    sd_bus_message_exit_container(m);
    sd_bus_message_exit_container(m);
  }
  sd_bus_message_exit_container(m);
  return all;
}

/// Answers what the daemon asks while it pairs with one device.
struct Agent {
  std::string device_path, pin;
  bool was_asked = false;  // for the PIN

  static int on_message(sd_bus_message* m, void* self, sd_bus_error*) {
    auto& agent = *static_cast<Agent*>(self);
    const char* const interface = sd_bus_message_get_interface(m);
    if (interface == nullptr || std::strcmp(interface, "org.bluez.Agent1") != 0) return 0;
    const std::string_view member = sd_bus_message_get_member(m);
    if (member == "Release" || member == "Cancel") return sd_bus_reply_method_return(m, "");
    const char* device = nullptr;
    if (sd_bus_message_read(m, "o", &device) < 0 || agent.device_path != device)
      return sd_bus_reply_method_errorf(m, "org.bluez.Error.Rejected", "not the robot that is being paired");
    agent.was_asked = agent.was_asked || member == "RequestPinCode" || member == "RequestPasskey";
    if (member == "RequestPinCode") return sd_bus_reply_method_return(m, "s", agent.pin.c_str());
    if (member == "RequestPasskey")
      return sd_bus_reply_method_return(m, "u", static_cast<std::uint32_t>(std::atoi(agent.pin.c_str())));
    return sd_bus_reply_method_return(m, "");  // shown, confirmed or authorised: yes
  }
};

/// What became of a call that is waited for while the agent answers.
struct Outcome {
  bool over = false;
  std::string error_name, error;  // empty: it went well

  static int on_reply(sd_bus_message* m, void* self, sd_bus_error*) {
    auto& outcome = *static_cast<Outcome*>(self);
    outcome.over = true;
    if (const sd_bus_error* error = sd_bus_message_get_error(m)) {
      outcome.error_name = error->name;
      outcome.error = sentence(*error, -sd_bus_message_get_errno(m));
    }
    return 0;
  }
};

}  // namespace

void BluezBus::Close::operator()(sd_bus* bus) const noexcept {
  sd_bus_flush_close_unref(bus);
}

tl::expected<BluezBus, std::string> BluezBus::open() {
  sd_bus* bus = nullptr;
  if (const int result = sd_bus_open_system(&bus); result < 0)
    return tl::unexpected(
        fmt::format("there is no D-Bus system bus ({}): is dbus-daemon running?", std::strerror(-result)));
  return BluezBus(bus);
}

tl::expected<BluezObjects, std::string> BluezBus::objects() {
  Error error;
  sd_bus_message* reply = nullptr;
  const int result = sd_bus_call_method(bus_.get(), daemon, "/", "org.freedesktop.DBus.ObjectManager",
                                        "GetManagedObjects", &error.value, &reply, "");
  const Message keeper(reply);
  if (result < 0) return tl::unexpected(sentence(error.value, result));
  return read_objects(reply);
}

tl::expected<std::vector<BluezAdapter>, std::string> BluezBus::adapters(const std::string& wanted) {
  const auto known = objects();
  if (!known) return tl::unexpected(known.error());
  if (known->adapters.empty()) return tl::unexpected(std::string("this machine has no Bluetooth adapter: plug one in"));
  const auto is_wanted = [&](const BluezAdapter& adapter) {
    const bool same_address =
        std::equal(wanted.begin(), wanted.end(), adapter.address.begin(), adapter.address.end(),
                   [](unsigned char a, unsigned char b) { return std::toupper(a) == std::toupper(b); });
    return wanted.empty() || adapter.name() == wanted || same_address;
  };
  std::vector<BluezAdapter> on;
  std::string there_are, off;
  for (const BluezAdapter& adapter : known->adapters) {
    there_are += (there_are.empty() ? "" : ", ") + adapter.name();
    if (!is_wanted(adapter)) continue;
    if (adapter.powered)
      on.push_back(adapter);
    else
      off = adapter.name();
  }
  if (!on.empty()) return on;
  if (!off.empty())
    return tl::unexpected(fmt::format("adapter {} is off: \"bluetoothctl power on\" switches it on", off));
  return tl::unexpected(fmt::format("there is no adapter {}; there are: {}", wanted, there_are));
}

tl::expected<void, std::string> BluezBus::start_discovery(const BluezAdapter& adapter) {
  Error ignored, error;
  // Robots are classic Bluetooth; a daemon too old for filters finds them without.
  sd_bus_call_method(bus_.get(), daemon, adapter.path.c_str(), "org.bluez.Adapter1", "SetDiscoveryFilter",
                     &ignored.value, nullptr, "a{sv}", 1, "Transport", "s", "bredr");
  const int result = sd_bus_call_method(bus_.get(), daemon, adapter.path.c_str(), "org.bluez.Adapter1",
                                        "StartDiscovery", &error.value, nullptr, "");
  if (result >= 0 || sd_bus_error_has_name(&error.value, "org.bluez.Error.InProgress")) return {};
  return tl::unexpected(fmt::format("{}: {}", adapter.name(), sentence(error.value, result)));
}

void BluezBus::stop_discovery(const BluezAdapter& adapter) {
  Error ignored;  // it ends with this connection at the latest
  sd_bus_call_method(bus_.get(), daemon, adapter.path.c_str(), "org.bluez.Adapter1", "StopDiscovery", &ignored.value,
                     nullptr, "");
}

bool BluezBus::serve(double timeout_s, const std::function<bool()>& keep_on, const std::function<bool()>& until) {
  const auto end = Clock::now() + std::chrono::duration_cast<Clock::duration>(std::chrono::duration<double>(timeout_s));
  while (!until()) {
    if (Clock::now() >= end || (keep_on && !keep_on())) return false;
    const int result = sd_bus_process(bus_.get(), nullptr);
    if (result == 0) sd_bus_wait(bus_.get(), slice_us);
    if (result < 0) std::this_thread::sleep_for(std::chrono::microseconds(slice_us));  // the bus is gone
  }
  return true;
}

tl::expected<void, std::string> BluezBus::pair(const BluezDevice& device, const std::string& pin, bool can_type,
                                               double timeout_s, const std::function<bool()>& keep_on) {
  Agent agent{device.path, pin};
  sd_bus_slot* slot = nullptr;
  int result = sd_bus_add_object(bus_.get(), &slot, agent_path, Agent::on_message, &agent);
  const Slot agent_slot(slot);
  if (result < 0) return tl::unexpected(sentence(SD_BUS_ERROR_NULL, result));
  Error error;
  result =
      sd_bus_call_method(bus_.get(), daemon, "/org/bluez", "org.bluez.AgentManager1", "RegisterAgent", &error.value,
                         nullptr, "os", agent_path, can_type ? "KeyboardDisplay" : "NoInputNoOutput");
  if (result < 0) return tl::unexpected(sentence(error.value, result));

  Outcome outcome;
  slot = nullptr;
  result = sd_bus_call_method_async(bus_.get(), &slot, daemon, device.path.c_str(), "org.bluez.Device1", "Pair",
                                    Outcome::on_reply, &outcome, "");
  const Slot call_slot(slot);
  if (result < 0) return tl::unexpected(sentence(SD_BUS_ERROR_NULL, result));
  Error ignored;
  if (!serve(timeout_s, keep_on, [&outcome] { return outcome.over; })) {
    sd_bus_call_method(bus_.get(), daemon, device.path.c_str(), "org.bluez.Device1", "CancelPairing", &ignored.value,
                       nullptr, "");
    outcome.error = fmt::format("not paired within {:g} s", timeout_s);
  }
  sd_bus_call_method(bus_.get(), daemon, "/org/bluez", "org.bluez.AgentManager1", "UnregisterAgent", nullptr, nullptr,
                     "o", agent_path);
  if (outcome.error.empty() || outcome.error_name.ends_with(".AlreadyExists")) return {};
  const bool refused =
      outcome.error_name.ends_with(".AuthenticationFailed") || outcome.error_name.ends_with(".AuthenticationRejected");
  if (!refused) return tl::unexpected(outcome.error);
  if (agent.was_asked)
    return tl::unexpected(std::string("the robot refuses the PIN: is the number in its name its PIN?"));
  return tl::unexpected(
      outcome.error +
      ": it requested no PIN. It may be paired with another computer, or have an older pairing with this one");
}

}  // namespace skein::comms
