#include "tests/comms/fake_screen_saver.h"

#include <array>

namespace skein::test {

FakeScreenSaver::FakeScreenSaver(const PrivateBus& bus) : FakeService(bus) {
  sd_bus_add_object(bus_, nullptr, "/org/freedesktop/ScreenSaver", on_message, this);
  sd_bus_match_signal(bus_, nullptr, "org.freedesktop.DBus", "/org/freedesktop/DBus", "org.freedesktop.DBus",
                      "NameOwnerChanged", on_name, this);
  serve("org.freedesktop.ScreenSaver");
}

FakeScreenSaver::~FakeScreenSaver() {
  end();
}

int FakeScreenSaver::on_message(sd_bus_message* m, void* self, sd_bus_error* /*error*/) {
  if (sd_bus_message_is_method_call(m, "org.freedesktop.ScreenSaver", "Inhibit") <= 0) return 0;
  auto& saver = *static_cast<FakeScreenSaver*>(self);
  std::array<const char*, 2> words{};
  sd_bus_message_read(m, "ss", &words[0], &words[1]);
  {
    const std::lock_guard lock(saver.mutex_);
    saver.newest_.assign(words.begin(), words.end());
    saver.holders_.insert(sd_bus_message_get_sender(m));
  }
  constexpr std::uint32_t cookie = 7;
  return sd_bus_reply_method_return(m, "u", cookie);
}

int FakeScreenSaver::on_name(sd_bus_message* m, void* self, sd_bus_error* /*error*/) {
  std::array<const char*, 3> words{};  // name, its owner before and now
  sd_bus_message_read(m, "sss", &words[0], &words[1], &words[2]);
  auto& saver = *static_cast<FakeScreenSaver*>(self);
  const std::lock_guard lock(saver.mutex_);
  if (std::string(words[2]).empty()) saver.holders_.erase(words[0]);
  return 0;
}

int FakeScreenSaver::inhibitors() const {
  const std::lock_guard lock(mutex_);
  return static_cast<int>(holders_.size());
}

std::vector<std::string> FakeScreenSaver::newest() const {
  const std::lock_guard lock(mutex_);
  return newest_;
}

}  // namespace skein::test
