#include "tests/comms/fake_logind.h"

#include <fcntl.h>
#include <poll.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <string_view>
#include <utility>

namespace skein::test {
namespace {

/// Whoever held the other end has let it go.
bool let_go(int lock) {
  pollfd ready{lock, POLLIN, 0};
  return ::poll(&ready, 1, 0) > 0 && (ready.revents & POLLHUP) != 0;
}

int held(const std::vector<int>& locks) {
  return static_cast<int>(std::count_if(locks.begin(), locks.end(), [](int one) { return !let_go(one); }));
}

}  // namespace

FakeLogind::FakeLogind(const PrivateBus& bus, std::string refusal, std::string what)
    : FakeService(bus), whole_bus_(bus), refusal_(std::move(refusal)), refused_(std::move(what)) {
  sd_bus_add_object(bus_, nullptr, "/org/freedesktop/login1", on_message, this);
  serve("org.freedesktop.login1");
}

FakeLogind::~FakeLogind() {
  end();
  for (const auto* const locks : {&locks_, &delays_})
    for (const int lock : *locks) ::close(lock);
}

int FakeLogind::on_message(sd_bus_message* m, void* self, sd_bus_error* error) {
  if (sd_bus_message_is_method_call(m, "org.freedesktop.login1.Manager", "Announce") > 0) {
    const char* name = nullptr;
    int begins = 0;
    sd_bus_message_read(m, "sb", &name, &begins);
    sd_bus_emit_signal(sd_bus_message_get_bus(m), "/org/freedesktop/login1", "org.freedesktop.login1.Manager", name,
                       "b", begins);
    return sd_bus_reply_method_return(m, "");
  }
  if (sd_bus_message_is_method_call(m, "org.freedesktop.login1.Manager", "Inhibit") <= 0) return 0;
  return static_cast<FakeLogind*>(self)->inhibit(m, error);
}

int FakeLogind::inhibit(sd_bus_message* m, sd_bus_error* error) {
  std::array<const char*, 4> words{};
  sd_bus_message_read(m, "ssss", &words[0], &words[1], &words[2], &words[3]);
  const std::lock_guard lock(mutex_);
  const bool delays = std::string_view(words[3]) == "delay";
  if (!delays) {
    ++asked_;
    newest_.assign(words.begin(), words.end());
  }
  if (!delays && !refusal_.empty() && newest_[0].find(refused_) != std::string::npos)
    return sd_bus_error_set(error, SD_BUS_ERROR_ACCESS_DENIED, refusal_.c_str());
  std::array<int, 2> ends{};
  if (::pipe2(ends.data(), O_CLOEXEC) != 0) return -1;
  (delays ? delays_ : locks_).push_back(ends[0]);
  const int sent = sd_bus_reply_method_return(m, "h", ends[1]);
  ::close(ends[1]);
  return sent;
}

int FakeLogind::inhibitors() const {
  const std::lock_guard lock(mutex_);
  return held(locks_);
}

int FakeLogind::delays() const {
  const std::lock_guard lock(mutex_);
  return held(delays_);
}

void FakeLogind::announce(const char* name, bool begins) {
  sd_bus* caller = nullptr;  // the bus of the service belongs to its thread
  if (sd_bus_new(&caller) >= 0 && sd_bus_set_address(caller, whole_bus_.address().c_str()) >= 0 &&
      sd_bus_set_bus_client(caller, 1) >= 0 && sd_bus_start(caller) >= 0)
    sd_bus_call_method(caller, "org.freedesktop.login1", "/org/freedesktop/login1", "org.freedesktop.login1.Manager",
                       "Announce", nullptr, nullptr, "sb", name, static_cast<int>(begins));
  sd_bus_flush_close_unref(caller);
}

int FakeLogind::asked() const {
  const std::lock_guard lock(mutex_);
  return asked_;
}

std::vector<std::string> FakeLogind::newest() const {
  const std::lock_guard lock(mutex_);
  return newest_;
}

}  // namespace skein::test
