#include "comms/crash_stop.h"

#include <sys/syscall.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <cerrno>
#include <csignal>
#include <cstdint>
#include <ctime>
#include <utility>

namespace skein::comms {
namespace {

struct Entry {
  std::atomic<bool> taken{false};
  std::atomic<int> descriptor{-1};
  std::atomic<const Protocol*> protocol{nullptr};  // set before the descriptor
  std::atomic<bool> stands{false};
  StopHeard heard;  // the handler's
};
struct Thread {
  std::atomic<bool> taken{false};
  std::atomic<void (*)(void*) noexcept> stop{nullptr};
  std::atomic<void*> who{nullptr};
  std::atomic<long> id{0};
};
std::array<Entry, 128> entries;
std::array<Thread, 16> threads;
static_assert(std::atomic<void*>::is_always_lock_free && std::atomic<int>::is_always_lock_free);

constexpr std::array<int, 7> crashes{SIGSEGV, SIGBUS, SIGFPE, SIGILL, SIGABRT, SIGQUIT, SIGSYS};
std::array<struct sigaction, crashes.size()> before;
std::atomic<bool> handling{false};

constexpr long look_every = 2'000'000;                 // [ns]
constexpr int looks_a_stop = 50, looks_at_most = 500;  // 100 ms, 1 s

long this_thread() noexcept {
  return ::syscall(SYS_gettid);
}

template <class Places>
int claim(Places& places) noexcept {
  for (std::size_t i = 0; i < places.size(); ++i)
    if (!places[i].taken.exchange(true)) return static_cast<int>(i);
  return -1;
}

void write_stop(const Entry& entry, int descriptor) noexcept {
  const std::span<const std::uint8_t> stop = entry.protocol.load()->stop_bytes();
  [[maybe_unused]] const auto written = ::write(descriptor, stop.data(), stop.size());
}

/// Reads the answer where the thread that would have is this one, and gone.
bool answered(Entry& entry, int descriptor) noexcept {
  std::array<std::uint8_t, 256> bytes;
  const ssize_t count = ::read(descriptor, bytes.data(), bytes.size());
  return count > 0 &&
         entry.heard.acknowledged(*entry.protocol.load(), std::span(bytes).first(static_cast<std::size_t>(count)));
}

void stop_all() noexcept {
  bool link_thread_gone = false;
  for (Thread& thread : threads) {
    if (!thread.taken.load()) continue;
    if (thread.id.load() == this_thread()) link_thread_gone = true;
    if (const auto stop = thread.stop.load()) stop(thread.who.load());
  }
  for (int look = 0; look < looks_at_most; ++look) {
    bool all_stand = true;
    for (Entry& entry : entries) {
      const int descriptor = entry.descriptor.load();
      if (descriptor < 0) continue;
      if (link_thread_gone && look > 0 && answered(entry, descriptor)) entry.stands.store(true);
      // Once to every robot: one that stands may have a command on its way.
      if (look == 0 || (!entry.stands.load() && look % looks_a_stop == 0)) write_stop(entry, descriptor);
      if (look == 0) entry.stands.store(false), entry.heard.forget();
      all_stand = all_stand && entry.stands.load();
    }
    if (all_stand) return;
    const timespec pause{0, look_every};
    ::nanosleep(&pause, nullptr);
  }
}

extern "C" void on_crash(int signal) {
  const int kept = errno;
  const bool first = !handling.exchange(true);
  if (first) stop_all();
  for (std::size_t i = 0; i < crashes.size(); ++i)
    if (crashes[i] == signal) ::sigaction(signal, &before[i], nullptr);
  errno = kept;
  ::raise(signal);  // held back until this handler is left
}

std::atomic<void (*)() noexcept> suspended{nullptr};

extern "C" void on_suspend(int) {
  const int kept = errno;
  if (std::any_of(entries.begin(), entries.end(), [](const Entry& e) { return e.descriptor.load() >= 0; })) {
    stop_all();
    if (const auto stopped = suspended.load()) stopped();
  }
  ::raise(SIGSTOP);
  errno = kept;
}

}  // namespace

void stop_robots_on_suspend(void (*stopped)() noexcept) {
  suspended.store(stopped);
  struct sigaction action {};
  action.sa_handler = on_suspend;
  ::sigaction(SIGTSTP, &action, nullptr);
}

void stop_robots_on_crash() {
  for (const Protocol& protocol : protocols()) protocol.stop_bytes();  // what is made at first use is made here
  static std::array<char, 32 * 1024> stack;                            // for an overflow of this thread's own
  stack_t alternative{};
  if (::sigaltstack(nullptr, &alternative) == 0 && (alternative.ss_flags & SS_DISABLE) != 0) {
    alternative = {};
    alternative.ss_sp = stack.data();
    alternative.ss_size = stack.size();
    ::sigaltstack(&alternative, nullptr);
  }
  struct sigaction action {};
  action.sa_handler = on_crash;
  action.sa_flags = SA_ONSTACK;
  sigemptyset(&action.sa_mask);
  for (std::size_t i = 0; i < crashes.size(); ++i) {
    ::sigaction(crashes[i], &action, &before[i]);
    // A script's background ignores SIGQUIT: the program ends by it all the same once its robots stand.
    if (before[i].sa_handler == SIG_IGN) before[i].sa_handler = SIG_DFL;
  }
}

CrashEntry::CrashEntry(int descriptor, const Protocol& protocol) noexcept : place_(claim(entries)) {
  if (place_ < 0) return;
  Entry& entry = entries[static_cast<std::size_t>(place_)];
  entry.protocol.store(&protocol);
  entry.stands.store(false);
  entry.descriptor.store(descriptor);
}
CrashEntry::CrashEntry(CrashEntry&& other) noexcept : place_(std::exchange(other.place_, -1)) {}
CrashEntry& CrashEntry::operator=(CrashEntry&& other) noexcept {
  std::swap(place_, other.place_);
  return *this;
}
CrashEntry::~CrashEntry() {
  if (place_ < 0) return;
  Entry& entry = entries[static_cast<std::size_t>(place_)];
  entry.descriptor.store(-1);
  entry.taken.store(false);
}
void CrashEntry::set_stands(bool stands) noexcept {
  if (place_ >= 0) entries[static_cast<std::size_t>(place_)].stands.store(stands);
}

CrashThread::CrashThread(void (*stop)(void* who) noexcept, void* who) noexcept : place_(claim(threads)) {
  if (place_ < 0) return;
  Thread& thread = threads[static_cast<std::size_t>(place_)];
  thread.id.store(0);
  thread.who.store(who);
  thread.stop.store(stop);
}
CrashThread::~CrashThread() {
  if (place_ < 0) return;
  Thread& thread = threads[static_cast<std::size_t>(place_)];
  thread.stop.store(nullptr);
  thread.taken.store(false);
}
void CrashThread::runs_here() noexcept {
  if (place_ >= 0) threads[static_cast<std::size_t>(place_)].id.store(this_thread());
}

}  // namespace skein::comms
