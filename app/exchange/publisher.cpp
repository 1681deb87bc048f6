#include "app/exchange/publisher.h"

#include <fmt/format.h>
#include <netdb.h>
#include <poll.h>
#include <sys/socket.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <charconv>
#include <chrono>
#include <cstring>
#include <optional>
#include <utility>

namespace skein::app {
namespace {

struct Address {
  std::string host, port;
};

std::optional<Address> parse(std::string_view where) {
  constexpr std::string_view scheme = "udp:";
  if (!where.starts_with(scheme)) return std::nullopt;
  where.remove_prefix(scheme.size());
  const std::size_t colon = where.rfind(':');
  if (colon == std::string_view::npos) return std::nullopt;
  std::string_view host = where.substr(0, colon);
  const std::string_view port = where.substr(colon + 1);
  const bool bracketed = host.size() > 2 && host.front() == '[' && host.back() == ']';
  if (bracketed) host = host.substr(1, host.size() - 2);
  int number = 0;
  const auto [stop, error] = std::from_chars(port.data(), port.data() + port.size(), number);
  const bool whole = error == std::errc{} && stop == port.data() + port.size() && number > 0 && number < 65536;
  const bool named = !host.empty() && (bracketed || host.find(':') == std::string_view::npos);
  if (!whole || !named) return std::nullopt;
  return Address{std::string(host), std::string(port)};
}

/// A connected UDP socket.
class Socket {
 public:
  explicit Socket(int descriptor) : descriptor_(descriptor) {}
  Socket(const Socket&) = delete;
  Socket& operator=(const Socket&) = delete;
  ~Socket() { ::close(descriptor_); }

  /// Sends all, or fewer if the network takes nothing for 0.1 s. A missing receiver is no failure: one may come later.
  bool send(const std::vector<std::string>& datagrams) const {
    constexpr int patience_ms = 100;
    for (const std::string& datagram : datagrams) {
      for (int attempt = 0;; ++attempt) {
        const ssize_t sent = ::send(descriptor_, datagram.data(), datagram.size(), MSG_DONTWAIT | MSG_NOSIGNAL);
        if (sent >= 0) break;
        if (attempt > 2) return false;
        if (errno == ECONNREFUSED || errno == EINTR) continue;  // the first: of a datagram before this one
        if (errno != EAGAIN && errno != ENOBUFS) return false;
        pollfd writable{descriptor_, POLLOUT, 0};
        if (::poll(&writable, 1, patience_ms) <= 0) return false;
      }
    }
    return true;
  }

 private:
  int descriptor_;
};

}  // namespace

tl::expected<void, std::string> check_publish_address(const std::string& where) {
  if (parse(where)) return {};
  return tl::unexpected(
      fmt::format("--publish: found {}, allowed: udp:HOST:PORT, as in udp:localhost:9870 or udp:[::1]:9870", where));
}

tl::expected<std::unique_ptr<Publisher>, std::string> Publisher::open(const std::string& where,
                                                                      const Experiment& experiment) {
  if (auto possible = check_publish_address(where); !possible) return tl::unexpected(possible.error());
  const Address address = *parse(where);
  addrinfo hints{};
  hints.ai_family = AF_UNSPEC;
  hints.ai_socktype = SOCK_DGRAM;
  addrinfo* found = nullptr;
  if (const int failed = ::getaddrinfo(address.host.c_str(), address.port.c_str(), &hints, &found); failed != 0)
    return tl::unexpected(fmt::format("--publish {}: {}", where, ::gai_strerror(failed)));
  int descriptor = -1;
  // Of a name that has addresses of both protocols, such as localhost, an IPv4 one: that reaches also who listens to
  // both.
  for (const bool of_ipv4 : {true, false})
    for (const addrinfo* one = found; one && descriptor < 0; one = one->ai_next) {
      if ((one->ai_family == AF_INET) != of_ipv4) continue;
      descriptor = ::socket(one->ai_family, one->ai_socktype | SOCK_CLOEXEC, one->ai_protocol);
      if (descriptor >= 0 && ::connect(descriptor, one->ai_addr, one->ai_addrlen) != 0)
        ::close(std::exchange(descriptor, -1));
    }
  const int error = errno;
  ::freeaddrinfo(found);
  if (descriptor < 0) return tl::unexpected(fmt::format("--publish {}: {}", where, std::strerror(error)));
  auto socket = std::make_shared<Socket>(descriptor);
  return std::make_unique<Publisher>(
      experiment, [socket](const std::vector<std::string>& datagrams) { return socket->send(datagrams); });
}

Publisher::Publisher(const Experiment& experiment, Send send)
    : datagrams_(experiment), send_(std::move(send)), ring_(capacity) {
  thread_ = std::jthread([this](const std::stop_token& token) { publish(token); });
}

Publisher::~Publisher() {
  finish();
}

void Publisher::record(const TickRecord& record) {
  {
    const std::lock_guard lock(mutex_);
    if (size_ == capacity) {
      first_ = (first_ + 1) % capacity;
      --size_;
      ++counts_.dropped;
    }
    ring_[(first_ + size_++) % capacity] = record;
  }
  filled_.notify_one();
}

void Publisher::publish(const std::stop_token& token) {
  TickRecord row;
  while (true) {
    {
      std::unique_lock lock(mutex_);
      busy_ = false;
      emptied_.notify_all();
      if (!filled_.wait(lock, token, [this] { return size_ > 0; })) return;
      std::swap(row, ring_[first_]);  // the slot keeps memory to copy into
      first_ = (first_ + 1) % capacity;
      --size_;
      busy_ = true;
    }
    const bool sent = send_(datagrams_.of(row));
    const std::lock_guard lock(mutex_);
    ++(sent ? counts_.sent : counts_.dropped);
  }
}

Publisher::Counts Publisher::finish() {
  constexpr auto patience = std::chrono::seconds(1);
  {
    std::unique_lock lock(mutex_);
    if (!emptied_.wait_for(lock, patience, [this] { return size_ == 0 && !busy_; }))
      counts_.dropped += static_cast<std::int64_t>(std::exchange(size_, 0));
  }
  if (thread_.joinable()) {
    thread_.request_stop();
    thread_.join();
  }
  return counts();
}

Publisher::Counts Publisher::counts() const {
  const std::lock_guard lock(mutex_);
  return counts_;
}

}  // namespace skein::app
