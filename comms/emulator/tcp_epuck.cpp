#include "comms/emulator/tcp_epuck.h"

#include <arpa/inet.h>
#include <netinet/in.h>
#include <netinet/tcp.h>
#include <poll.h>
#include <sys/eventfd.h>
#include <sys/socket.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cmath>
#include <mutex>
#include <system_error>
#include <thread>
#include <utility>

namespace skein::comms {
namespace {

constexpr double longest_wait = 3600.0;  // [s]

[[noreturn]] void refused(const char* what) {
  throw std::system_error(errno, std::generic_category(), what);
}

/// A descriptor that closes itself.
class Descriptor {
 public:
  explicit Descriptor(int descriptor = -1) noexcept : descriptor_(descriptor) {}
  Descriptor(Descriptor&& other) noexcept : descriptor_(std::exchange(other.descriptor_, -1)) {}
  Descriptor& operator=(Descriptor&& other) noexcept {
    std::swap(descriptor_, other.descriptor_);
    return *this;
  }
  ~Descriptor() {
    if (descriptor_ >= 0) ::close(descriptor_);
  }
  int get() const noexcept { return descriptor_; }
  explicit operator bool() const noexcept { return descriptor_ >= 0; }

 private:
  int descriptor_;
};

Descriptor listen_on(int port, bool every_address) {
  Descriptor listener(::socket(AF_INET, SOCK_STREAM | SOCK_NONBLOCK | SOCK_CLOEXEC, 0));
  if (!listener) refused("socket");
  const int on = 1;
  ::setsockopt(listener.get(), SOL_SOCKET, SO_REUSEADDR, &on, sizeof on);
  sockaddr_in here{};
  here.sin_family = AF_INET;
  here.sin_port = htons(static_cast<std::uint16_t>(port));
  here.sin_addr.s_addr = htonl(every_address ? INADDR_ANY : INADDR_LOOPBACK);
  if (::bind(listener.get(), reinterpret_cast<const sockaddr*>(&here), sizeof here) != 0) refused("the TCP port");
  if (::listen(listener.get(), 1) != 0) refused("listen");
  return listener;
}

int port_of(const Descriptor& listener) {
  sockaddr_in here{};
  socklen_t size = sizeof here;
  if (::getsockname(listener.get(), reinterpret_cast<sockaddr*>(&here), &size) != 0) refused("getsockname");
  return ntohs(here.sin_port);
}

}  // namespace

class TcpEpuck::Loop {
 public:
  Loop(std::function<double()> clock, int port, WheelsChanged on_wheels, std::vector<Fault> faults, std::uint64_t seed,
       bool every_address)
      : clock_(std::move(clock)),
        on_wheels_(std::move(on_wheels)),
        robot_(core::MotorModel::epuck2, clock_(), std::move(faults), seed, Protocol::wifi),
        listener_(listen_on(port, every_address)),
        port_(port_of(listener_)),
        wake_(::eventfd(0, EFD_NONBLOCK | EFD_CLOEXEC)) {
    if (!wake_) refused("eventfd");
    thread_ = std::thread([this] { run(); });
  }
  ~Loop() {
    ask([this] { ending_ = true; });
    thread_.join();
  }
  Loop(const Loop&) = delete;
  Loop& operator=(const Loop&) = delete;

  int port() const noexcept { return port_; }
  core::WheelSpeeds wheels() const {
    const std::lock_guard lock(mutex_);
    return robot_.wheels();
  }
  /// Does something between two turns of the thread, which then looks around.
  template <class What>
  void ask(const What& what) {
    {
      const std::lock_guard lock(mutex_);
      what();
    }
    const std::uint64_t one = 1;
    [[maybe_unused]] const auto written = ::write(wake_.get(), &one, sizeof one);
  }

  void hang_up() {
    ask([this] { connection_ = Descriptor(); });
  }
  void silence(bool silent) {
    ask([this, silent] { silent_ = silent; });
  }
  void say(const std::vector<std::uint8_t>& bytes) {
    ask([this, &bytes] { write(bytes); });
  }

 private:
  void run() {
    std::unique_lock lock(mutex_);
    while (!ending_) {
      std::array<pollfd, 3> polled{{{wake_.get(), POLLIN, 0},
                                    {connection_ || !robot_.connected() ? -1 : listener_.get(), POLLIN, 0},
                                    {connection_.get(), POLLIN, 0}}};
      const double seconds = std::clamp(robot_.deadline() - clock_(), 0.0, longest_wait);
      const timespec wait{static_cast<time_t>(seconds), static_cast<long>((seconds - std::floor(seconds)) * 1e9)};
      lock.unlock();
      const int events = ::ppoll(polled.data(), polled.size(), &wait, nullptr);
      std::uint64_t rings = 0;
      [[maybe_unused]] const auto rung = ::read(wake_.get(), &rings, sizeof rings);
      lock.lock();
      if (events > 0 && polled[1].revents != 0) accept();
      if (events > 0 && polled[2].revents != 0) serve();
      let_time_pass();
    }
  }

  void accept() {
    Descriptor fresh(::accept4(listener_.get(), nullptr, nullptr, SOCK_NONBLOCK | SOCK_CLOEXEC));
    if (!fresh) return;
    const int on = 1;
    ::setsockopt(fresh.get(), IPPROTO_TCP, TCP_NODELAY, &on, sizeof on);
    connection_ = std::move(fresh);
    robot_.accept();
  }

  void serve() {
    if (!connection_) return;
    std::array<std::uint8_t, 512> bytes;
    const ssize_t count = ::read(connection_.get(), bytes.data(), bytes.size());
    if (count < 0 && (errno == EAGAIN || errno == EINTR)) return;
    if (count <= 0) {
      connection_ = Descriptor();  // the host has gone; the wheels go on
      return;
    }
    if (!silent_) robot_.receive(std::span(bytes).first(static_cast<std::size_t>(count)), clock_());
  }

  void let_time_pass() {
    robot_.advance(clock_());
    if (std::exchange(breaks_, robot_.breaks()) != robot_.breaks()) connection_ = Descriptor();
    const core::WheelSpeeds actual = robot_.wheels();
    if (std::exchange(known_, actual) != actual && on_wheels_) on_wheels_(actual);
    const std::vector<std::uint8_t> answer = robot_.take();
    if (!silent_) write(answer);
  }

  // A robot does not wait for a host that does not read: what finds no room is lost.
  void write(const std::vector<std::uint8_t>& bytes) {
    if (connection_ && !bytes.empty()) [[maybe_unused]]
      const auto sent = ::send(connection_.get(), bytes.data(), bytes.size(), MSG_NOSIGNAL);
  }

  std::function<double()> clock_;
  WheelsChanged on_wheels_;
  mutable std::mutex mutex_;
  EmulatedEpuck robot_;  // guarded by mutex_, as all below
  Descriptor listener_;
  int port_;
  Descriptor wake_;
  Descriptor connection_;
  std::uint64_t breaks_ = 0;
  core::WheelSpeeds known_;
  bool silent_ = false;
  bool ending_ = false;
  std::thread thread_;
};

TcpEpuck::TcpEpuck(std::function<double()> clock, int port, WheelsChanged on_wheels, std::vector<Fault> faults,
                   std::uint64_t seed, bool every_address)
    : loop_(std::make_unique<Loop>(std::move(clock), port, std::move(on_wheels), std::move(faults), seed,
                                   every_address)) {}
TcpEpuck::~TcpEpuck() = default;
int TcpEpuck::port() const noexcept {
  return loop_->port();
}
core::WheelSpeeds TcpEpuck::wheels() const {
  return loop_->wheels();
}
void TcpEpuck::hang_up() {
  loop_->hang_up();
}
void TcpEpuck::silence(bool silent) {
  loop_->silence(silent);
}
void TcpEpuck::say(const std::vector<std::uint8_t>& bytes) {
  loop_->say(bytes);
}

}  // namespace skein::comms
