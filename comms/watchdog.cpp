#include "comms/watchdog.h"

#include <fcntl.h>
#include <sys/socket.h>
#include <unistd.h>

#include <algorithm>
#include <cstring>
#include <ctime>
#include <mutex>
#include <utility>

namespace skein::comms {
namespace {

/// A line as it is announced to the guard; all open lines are announced to a new guard.
struct Line {
  int descriptor = -1;
  GuardMessage message;
};

HeartbeatPage unshared;  // beats where no guard listens
std::atomic<HeartbeatPage*> page{&unshared};
std::array<std::atomic<bool>, most_hearts> taken;

std::mutex lines_mutex;
std::array<Line, most_lines> lines;  // guarded by lines_mutex
int guard_socket = -1;               // guarded by lines_mutex

}  // namespace

std::int64_t monotonic_ns() noexcept {
  timespec now{};
  ::clock_gettime(CLOCK_MONOTONIC, &now);
  return std::int64_t{now.tv_sec} * 1'000'000'000 + now.tv_nsec;
}

bool send_to_guard(int socket, const GuardMessage& message, int descriptor) noexcept {
  iovec bytes{const_cast<GuardMessage*>(&message), sizeof message};
  alignas(cmsghdr) std::array<char, CMSG_SPACE(sizeof(int))> control{};
  msghdr header{};
  header.msg_iov = &bytes;
  header.msg_iovlen = 1;
  if (descriptor >= 0) {
    header.msg_control = control.data();
    header.msg_controllen = control.size();
    cmsghdr* const rights = CMSG_FIRSTHDR(&header);
    rights->cmsg_level = SOL_SOCKET;
    rights->cmsg_type = SCM_RIGHTS;
    rights->cmsg_len = CMSG_LEN(sizeof(int));
    std::memcpy(CMSG_DATA(rights), &descriptor, sizeof descriptor);
  }
  return ::sendmsg(socket, &header, MSG_DONTWAIT | MSG_NOSIGNAL) == static_cast<ssize_t>(sizeof message);
}

Heart::Heart(double longest_silence_s) noexcept {
  for (std::size_t i = 0; i < taken.size() && place_ < 0; ++i)
    if (!taken[i].exchange(true)) place_ = static_cast<int>(i);
  if (place_ < 0) return;
  const auto limit = static_cast<std::int64_t>(1e9 * longest_silence_s);
  for (HeartbeatPage* each : {&unshared, page.load()})
    each->hearts[static_cast<std::size_t>(place_)].limit.store(limit);
  beat();
}

Heart::~Heart() {
  if (place_ < 0) return;
  const auto place = static_cast<std::size_t>(place_);
  for (HeartbeatPage* each : {&unshared, page.load()}) each->hearts[place].beat.store(0);
  taken[place].store(false);
}

void Heart::beat() noexcept {
  if (place_ < 0) return;
  page.load(std::memory_order_acquire)
      ->hearts[static_cast<std::size_t>(place_)]
      .beat.store(monotonic_ns(), std::memory_order_release);
}

void attach_guard(int socket, HeartbeatPage& shared) {
  HeartbeatPage* const before = page.load();
  for (std::size_t i = 0; i < most_hearts && before != &shared; ++i) {
    shared.hearts[i].limit.store(before->hearts[i].limit.load());
    // From now on: the thread whose beats were moved here was not silent.
    shared.hearts[i].beat.store(before->hearts[i].beat.load() == 0 ? 0 : monotonic_ns());
  }
  page.store(&shared, std::memory_order_release);
  const std::lock_guard lock(lines_mutex);
  guard_socket = socket;
  for (const Line& line : lines)
    if (line.descriptor >= 0) send_to_guard(socket, line.message, line.descriptor);
}

void detach_guard(int socket) noexcept {
  const std::lock_guard lock(lines_mutex);
  if (guard_socket != socket) return;
  guard_socket = -1;
  HeartbeatPage* const shared = page.load();
  for (std::size_t i = 0; i < most_hearts && shared != &unshared; ++i) {
    unshared.hearts[i].limit.store(shared->hearts[i].limit.load());
    unshared.hearts[i].beat.store(shared->hearts[i].beat.load());
  }
  page.store(&unshared, std::memory_order_release);
}

GuardedLine::GuardedLine(int descriptor, std::span<const std::uint8_t> stop, std::string_view address) noexcept {
  if (stop.size() > longest_stop) return;
  const std::lock_guard lock(lines_mutex);
  const auto free = std::find_if(lines.begin(), lines.end(), [](const Line& line) { return line.descriptor < 0; });
  if (free == lines.end()) return;
  place_ = static_cast<int>(free - lines.begin());
  *free = {descriptor, {}};
  GuardMessage& message = free->message;
  message.kind = GuardMessage::Kind::line_opened;
  message.place = static_cast<std::uint8_t>(place_);
  message.size = static_cast<std::uint8_t>(stop.size());
  std::copy(stop.begin(), stop.end(), message.stop.begin());
  std::copy_n(address.begin(), std::min(address.size(), message.address.size() - 1), message.address.begin());
  if (guard_socket >= 0) send_to_guard(guard_socket, message, descriptor);
}

GuardedLine::GuardedLine(GuardedLine&& other) noexcept : place_(std::exchange(other.place_, -1)) {}
GuardedLine& GuardedLine::operator=(GuardedLine&& other) noexcept {
  std::swap(place_, other.place_);
  return *this;
}
GuardedLine::~GuardedLine() {
  if (place_ < 0) return;
  const std::lock_guard lock(lines_mutex);
  lines[static_cast<std::size_t>(place_)].descriptor = -1;
  GuardMessage message;
  message.kind = GuardMessage::Kind::line_closed;
  message.place = static_cast<std::uint8_t>(place_);
  if (guard_socket >= 0) send_to_guard(guard_socket, message, -1);
}

}  // namespace skein::comms
