#include "app/guard/guard.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <pthread.h>
#include <sys/file.h>
#include <sys/ioctl.h>
#include <sys/mman.h>
#include <sys/prctl.h>
#include <sys/socket.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <cerrno>
#include <csignal>
#include <cstdlib>
#include <cstring>
#include <memory>
#include <mutex>
#include <optional>
#include <string_view>
#include <system_error>
#include <thread>
#include <vector>

#include "app/guard/run_marker.h"
#include "app/guard/safety_net.h"
#include "app/guard/stop_socket.h"
#include "app/run/exit_status.h"
#include "app/run/interrupted.h"
#include "app/run/memory_lock.h"
#include "app/run/output.h"
#include "app/run/terminal_text.h"
#include "comms/protocol.h"
#include "comms/system_services.h"
#include "comms/watchdog.h"

namespace skein::app {
namespace {

using comms::GuardMessage;
using comms::HeartbeatPage;

constexpr int look_every = 20;                          // [ms]
constexpr std::int64_t stop_again = 100'000'000;        // [ns]
constexpr std::int64_t answers_within = 1'000'000'000;  // of robots whose run has died [ns]
constexpr std::int64_t tell_after = 10'000'000'000;     // that a robot has not been reached [ns]

void tell(const std::string& sentence) {
  print_error("skein guard: " + shown(sentence) + "\n");
}

/// A duplicate of a line of the run.
struct Line {
  int descriptor = -1;
  std::vector<std::uint8_t> stop;
  std::string address;
  const comms::Protocol* protocol = nullptr;  // that is spoken there
  std::int64_t stopped_at = 0;                // written last [ns]
  bool stands = false;                        // the robot has said so since
  comms::StopHeard heard{};

  /// What the robot said before does not count.
  void begin_stop() noexcept { stands = false, stopped_at = 0, heard.forget(); }
  void write_stop(std::int64_t now) {
    if (stands || (stopped_at != 0 && now - stopped_at < stop_again)) return;
    [[maybe_unused]] const auto written = ::write(descriptor, stop.data(), stop.size());
    stopped_at = now;
  }
  /// A robot that has no answer of its own to a stop is asked over a new connection.
  void read_answer() {
    std::array<std::uint8_t, comms::StopHeard::most> bytes;
    int waiting = 0;  // a terminal that has nothing is not read: see comms/transport.cpp
    // A few rounds: one robot that talks without end must not keep the others waiting.
    for (int round = 0; round < 8 && ::ioctl(descriptor, FIONREAD, &waiting) == 0 && waiting > 0; ++round) {
      const ssize_t count = ::read(descriptor, bytes.data(), bytes.size());
      if (count <= 0) return;
      stands = stands ||
               (answers() && heard.acknowledged(*protocol, std::span(bytes).first(static_cast<std::size_t>(count))));
    }
  }
  bool answers() const noexcept { return protocol && protocol->answers_stop; }
  /// Also for the run's own descriptor, which may be open in a child of it.
  void close() {
    if (descriptor < 0) return;
    ::flock(descriptor, LOCK_UN);
    ::shutdown(descriptor, SHUT_RDWR);
    ::close(std::exchange(descriptor, -1));
  }
};

/// The run's lines and beats, as its messages tell them.
class Watch {
 public:
  explicit Watch(int socket) : socket_(socket) {}

  enum class Run { lives, well, gone };
  Run hear();
  /// Longest silence of a thread beyond what it may be silent [s]; 0: none is.
  double silence(std::int64_t now) const;
  void beat(std::int64_t now) {
    if (page_) page_->guard.store(now);
  }
  std::array<Line, comms::most_lines> lines;

 private:
  void take(const GuardMessage& message, int descriptor);
  int socket_;
  HeartbeatPage* page_ = nullptr;
};

Watch::Run Watch::hear() {
  while (true) {
    GuardMessage message;
    iovec bytes{&message, sizeof message};
    alignas(cmsghdr) std::array<char, CMSG_SPACE(sizeof(int))> control{};
    msghdr header{};
    header.msg_iov = &bytes;
    header.msg_iovlen = 1;
    header.msg_control = control.data();
    header.msg_controllen = control.size();
    const ssize_t size = ::recvmsg(socket_, &header, MSG_DONTWAIT | MSG_CMSG_CLOEXEC);
    if (size < 0 && errno == EINTR) continue;
    if (size < 0 && (errno == EAGAIN || errno == EWOULDBLOCK)) return Run::lives;
    if (size != static_cast<ssize_t>(sizeof message)) return Run::gone;
    int descriptor = -1;
    if (const cmsghdr* const rights = CMSG_FIRSTHDR(&header); rights && rights->cmsg_type == SCM_RIGHTS)
      std::memcpy(&descriptor, CMSG_DATA(rights), sizeof descriptor);
    if (message.kind == GuardMessage::Kind::all_is_well) return Run::well;
    take(message, descriptor);
  }
}

void Watch::take(const GuardMessage& message, int descriptor) {
  Line& line = lines[message.place % lines.size()];
  switch (message.kind) {
    case GuardMessage::Kind::page: {
      void* const memory = ::mmap(nullptr, sizeof(HeartbeatPage), PROT_READ | PROT_WRITE, MAP_SHARED, descriptor, 0);
      if (memory != MAP_FAILED) page_ = static_cast<HeartbeatPage*>(memory);
      if (page_) page_->guard_process.store(::getpid());
      ::close(descriptor);
      return;
    }
    case GuardMessage::Kind::line_opened:
      if (line.descriptor >= 0) ::close(line.descriptor);
      line = {descriptor,
              {message.stop.begin(), message.stop.begin() + std::min(message.size, std::uint8_t{comms::longest_stop})},
              std::string(message.address.data(), ::strnlen(message.address.data(), message.address.size())),
              nullptr};
      if (const auto address = comms::parse_link_address(line.address)) line.protocol = &comms::protocol_of(*address);
      return;
    case GuardMessage::Kind::line_closed:
      if (line.descriptor >= 0) ::close(std::exchange(line.descriptor, -1));
      return;
    case GuardMessage::Kind::all_is_well:
      return;
  }
}

double Watch::silence(std::int64_t now) const {
  if (!page_) return 0.0;
  std::int64_t longest = 0;
  for (const HeartbeatPage::Heart& heart : page_->hearts)
    if (const std::int64_t beat = heart.beat.load(); beat != 0 && now - beat > heart.limit.load())
      longest = std::max(longest, now - beat);
  return 1e-9 * static_cast<double>(longest);
}

/// Leaves the run's process tree and its control group: what ends those must not end this process.
void leave_family() {
  if (::fork() > 0) ::_exit(done);  // the copy goes on, as a child of init; if it cannot be made, this process does
  ::prctl(PR_SET_NAME, guard_name);
  try {
    std::thread([] {
      comms::move_to_own_scope(::getpid(), guard_name, "Stops robots whose program is gone");
    }).detach();
  } catch (const std::system_error&) {  // it stays in the group
  }
}

/// A robot that only the guard can stop.
struct Orphan {
  comms::LinkAddress address;
  std::atomic<bool> stopped{false};
  std::mutex mutex;
  std::string reason = "not reached yet";  // guarded by mutex

  StopResult result() {
    const std::lock_guard lock(mutex);
    return {comms::to_text(address), stopped.load(), reason};
  }
};

/// A marker that the user may dismiss, also while the stop socket is not served. If the file is gone, that means
/// nothing: it may have been tidied up.
class WatchedMarker {
 public:
  explicit WatchedMarker(const std::string& path)
      : descriptor_(::open(path.c_str(), O_RDONLY | O_CLOEXEC | O_NOFOLLOW | O_NONBLOCK)) {}
  bool dismissed() const noexcept {
    std::array<char, RunMarker::dismissal.size()> begin{};
    return descriptor_ >= 0 &&
           ::pread(descriptor_, begin.data(), begin.size(), 0) == static_cast<ssize_t>(begin.size()) &&
           std::string_view(begin.data(), begin.size()) == RunMarker::dismissal;
  }

 private:
  int descriptor_;  // as long as the process lives
};

/// Reaches the robots anew, each on a thread of its own, until all are known to stand. False: the user dismissed the
/// marker.
bool reach(const RunMarker& run, const WatchedMarker& marker, const std::vector<comms::LinkAddress>& robots) {
  auto orphans = std::make_shared<std::vector<std::unique_ptr<Orphan>>>();  // threads may outlive this function
  for (const comms::LinkAddress& address : robots) {
    orphans->push_back(std::make_unique<Orphan>());
    orphans->back()->address = address;
  }
  for (std::size_t i = 0; i < robots.size(); ++i)
    std::thread([orphans, robots, i] {
      Orphan& orphan = *(*orphans)[i];
      for (std::string reason; !(reason = stop_one(robots, i)).empty();) {
        {
          const std::lock_guard lock(orphan.mutex);
          orphan.reason = reason;
        }
        std::this_thread::sleep_for(std::chrono::milliseconds(200));
      }
      orphan.stopped.store(true);
      tell(comms::to_text(orphan.address) + ": stopped");
    }).detach();

  auto socket = StopSocket::listen(run.socket());
  if (!socket) tell(socket.error());
  bool forget = false, released = false;
  const auto results = [&] {
    std::vector<StopResult> all;
    for (const auto& orphan : *orphans) all.push_back(orphan->result());
    return all;
  };
  for (std::int64_t told = comms::monotonic_ns(), since = told; !forget && !marker.dismissed();) {
    pollfd caller{socket ? socket->descriptor() : -1, POLLIN, 0};
    ::poll(&caller, 1, look_every);
    const auto all_stand = [&] {
      return std::all_of(orphans->begin(), orphans->end(), [](const auto& o) { return o->stopped.load(); });
    };
    const bool last = all_stand();
    if (last) run.forget();  // before the result is reported
    if (socket)
      socket->turn([&](std::string_view word) { forget = forget || word == "forget"; }, results, last || forget);
    if (last) return true;
    const std::int64_t now = comms::monotonic_ns();
    if (now - told < tell_after) continue;
    told = now;
    if (released) continue;
    for (const StopResult& robot : results())
      if (!robot.stopped)
        tell(fmt::format(
            "{}: NOT known to be stopped for {:.0f} s: {}; the guard keeps trying (`skein robots forget` ends it)",
            robot.address, 1e-9 * static_cast<double>(now - since), robot.reason));
    // A terminal gets repeated messages; a script that reads our end of a pipe is released.
    released = ::isatty(STDERR_FILENO) == 0;
    if (const int nowhere = ::open("/dev/null", O_WRONLY | O_CLOEXEC); released && nowhere >= 0)
      ::dup2(nowhere, STDERR_FILENO);
  }
  run.forget();
  return false;
}

}  // namespace

int guard(const std::string& marker, int descriptor) {
  if (std::getenv(marker_variable) != nullptr) leave_family();  // a run has started it, nobody by hand
  ignore_output_signals();
  for (const int signal : {SIGINT, SIGTERM, SIGHUP, SIGQUIT, SIGTSTP, SIGUSR1, SIGUSR2}) std::signal(signal, SIG_IGN);
  Watch watch(descriptor);
  Watch::Run heard = watch.hear();  // first: the run learns that this process has begun
  sched_param priority{};
  priority.sched_priority = 22;  // where the system grants it, above the threads that it watches
  ::pthread_setschedparam(::pthread_self(), SCHED_FIFO, &priority);
  const MemoryLock memory;  // where it is granted: the disk may stall when the guard is needed
  // A reader that waits for the end of the run's output must not wait for the guard.
  if (const int nowhere = ::open("/dev/null", O_WRONLY | O_CLOEXEC); nowhere >= 0) ::dup2(nowhere, STDOUT_FILENO);
  const WatchedMarker watched(marker);
  auto run = RunMarker::read(marker);  // now: it must not depend on a disk later

  bool silent = false;
  const auto look = [&] {
    const std::int64_t now = comms::monotonic_ns();
    watch.beat(now);
    const double silence = watch.silence(now);
    if (silence == 0.0) {
      silent = false;
      return;
    }
    const bool first = !std::exchange(silent, true);
    bool any = false;
    for (Line& line : watch.lines) {
      if (line.descriptor < 0) continue;
      any = true;
      if (first) line.begin_stop();
      if (!first) line.read_answer();
      line.write_stop(now);
    }
    if (first && any) tell(fmt::format("the run has stalled for {:.2f} s: its robots are being stopped", silence));
  };
  for (bool gone = false; !gone;) {
    switch (heard) {
      case Watch::Run::lives: {
        look();
        pollfd socket{descriptor, POLLIN, 0};
        ::poll(&socket, 1, look_every);
        heard = watch.hear();
        break;
      }
      case Watch::Run::well:
        return done;
      case Watch::Run::gone:
        gone = true;
        break;
    }
  }

  // The run is gone. First the lines that it left open: nothing is quicker.
  const std::int64_t ended = comms::monotonic_ns();
  for (Line& line : watch.lines) line.begin_stop();
  const auto waits = [](const Line& line) { return line.descriptor >= 0 && !line.stands; };
  for (std::int64_t now = ended;
       now - ended < answers_within && std::any_of(watch.lines.begin(), watch.lines.end(), waits);
       now = comms::monotonic_ns()) {
    for (Line& line : watch.lines) {
      if (!waits(line)) continue;
      if (line.stopped_at != 0) line.read_answer();
      line.write_stop(now);
    }
    // WiFi: TCP delivers what it was given, or the connection is dead.
    const auto answers = [&](const Line& line) { return waits(line) && line.answers(); };
    if (std::none_of(watch.lines.begin(), watch.lines.end(), answers)) break;
    std::this_thread::sleep_for(std::chrono::milliseconds(2));
  }
  std::vector<std::string> stand;
  for (Line& line : watch.lines) {
    if (line.stands) stand.push_back(line.address);
    line.close();
  }
  if (watched.dismissed()) return done;                          // `skein robots forget`
  if (auto now = RunMarker::read(marker)) run = std::move(now);  // the run may have named fewer since
  if (!run) {
    tell(run.error());
    return wrong_input;
  }
  std::vector<comms::LinkAddress> rest;
  for (const comms::LinkAddress& robot : run->robots)
    if (std::find(stand.begin(), stand.end(), comms::to_text(robot)) == stand.end()) rest.push_back(robot);
  tell(fmt::format("the run \"{}\" ended without stopping its robots: {} stopped on their lines, {} to reconnect to",
                   run->experiment, run->robots.size() - rest.size(), rest.size()));
  if (rest.empty()) {
    run->forget();
    return done;
  }
  return reach(*run, watched, rest) ? done : device_failed;
}

}  // namespace skein::app
