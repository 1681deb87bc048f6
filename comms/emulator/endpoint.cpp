#include "comms/emulator/endpoint.h"

#include <arpa/inet.h>
#include <fmt/format.h>
#include <netinet/in.h>
#include <netinet/tcp.h>
#include <sys/socket.h>
#include <unistd.h>

#include <cerrno>
#include <charconv>
#include <system_error>
#include <utility>

#include "comms/rfcomm.h"

namespace skein::comms {
namespace {

class PtyEndpoint final : public Endpoint {
 public:
  PtyEndpoint(DeviceNames& names, std::size_t robot) : names_(names), robot_(robot) {
    names_.point(robot_, pty_.path());
  }

  std::string address() const override { return "serial:" + names_.name(robot_); }
  int descriptor() const noexcept override { return pty_.robot(); }
  Arrival read(std::span<std::uint8_t> into) override {
    const ssize_t count = ::read(pty_.robot(), into.data(), into.size());
    return {.bytes = count > 0 ? static_cast<std::size_t>(count) : 0};
  }
  void write(std::span<const std::uint8_t> bytes) noexcept override {
    [[maybe_unused]] const auto written = ::write(pty_.robot(), bytes.data(), bytes.size());
  }
  void hang_up() override {
    Pty fresh;  // first: the name must lead somewhere before the old line breaks
    names_.point(robot_, fresh.path());
    pty_ = std::move(fresh);
  }
  void admit(bool) override {}  // a host that opens the line meanwhile finds a robot that does not answer

 private:
  DeviceNames& names_;
  std::size_t robot_;
  Pty pty_;
};

/// A descriptor that is closed when it is replaced or forgotten.
class Descriptor {
 public:
  Descriptor() = default;
  ~Descriptor() { reset(); }
  Descriptor(const Descriptor&) = delete;
  Descriptor& operator=(const Descriptor&) = delete;
  void reset(int value = -1) noexcept {
    if (value_ >= 0) ::close(value_);
    value_ = value;
  }
  int get() const noexcept { return value_; }
  int release() noexcept { return std::exchange(value_, -1); }
  bool open() const noexcept { return value_ >= 0; }

 private:
  int value_ = -1;
};

// Bound to an IPv4 address of this machine; -1: errno says why not.
int open_ip_socket(const std::string& here, int port, int type) {
  sockaddr_in local{};
  local.sin_family = AF_INET;
  local.sin_port = htons(static_cast<std::uint16_t>(port));
  if (::inet_pton(AF_INET, here.c_str(), &local.sin_addr) != 1) {
    errno = EINVAL;
    return -1;
  }
  Descriptor socket;
  socket.reset(::socket(AF_INET, type | SOCK_NONBLOCK | SOCK_CLOEXEC, 0));
  const int on = 1;
  ::setsockopt(socket.get(), SOL_SOCKET, SO_REUSEADDR, &on, sizeof on);
  if (!socket.open() || ::bind(socket.get(), reinterpret_cast<const sockaddr*>(&local), sizeof local) != 0) return -1;
  return socket.release();
}

int local_port(int descriptor) {
  sockaddr_in local{};
  socklen_t size = sizeof local;
  ::getsockname(descriptor, reinterpret_cast<sockaddr*>(&local), &size);
  return ntohs(local.sin_port);
}

/// Datagrams; each that is read comes alone.
class UdpEndpoint final : public Endpoint {
 public:
  explicit UdpEndpoint(ListenAddress address) : where_(std::move(address)) {
    if (!listen())
      throw std::system_error(errno, std::generic_category(), to_text({where_.kind, where_.here, where_.channel}));
    where_.channel = local_port(socket_.get());  // to be found there again
    address_ = to_text({where_.kind, where_.here, where_.channel});
  }

  std::string address() const override { return address_; }
  int descriptor() const noexcept override { return socket_.get(); }
  Arrival read(std::span<std::uint8_t> into) override {
    sockaddr_in from{};
    socklen_t size = sizeof from;
    const ssize_t count =
        ::recvfrom(socket_.get(), into.data(), into.size(), 0, reinterpret_cast<sockaddr*>(&from), &size);
    if (count <= 0) return {};
    host_ = from;
    return {.bytes = static_cast<std::size_t>(count)};
  }
  void write(std::span<const std::uint8_t> bytes) noexcept override {
    if (!socket_.open() || host_.sin_family != AF_INET) return;
    [[maybe_unused]] const auto sent = ::sendto(socket_.get(), bytes.data(), bytes.size(), MSG_NOSIGNAL,
                                                reinterpret_cast<const sockaddr*>(&host_), sizeof host_);
  }
  void hang_up() override { host_ = {}; }  // nothing to break: it forgets whom it spoke with
  void admit(bool hosts) override {
    if (!hosts)
      socket_.reset();
    else if (!socket_.open())
      listen();  // if it fails, the next call tries again
  }

 private:
  bool listen() {
    socket_.reset(open_ip_socket(where_.here, where_.channel, SOCK_DGRAM));
    return socket_.open();
  }

  ListenAddress where_;
  std::string address_;
  Descriptor socket_;
  sockaddr_in host_{};  // that spoke last
};

class SocketEndpoint final : public Endpoint {
 public:
  explicit SocketEndpoint(ListenAddress address) : where_(std::move(address)) {
    const bool tcp = where_.kind == LinkKind::tcp;
    if (!listen())
      throw std::system_error(errno, std::generic_category(), to_text({where_.kind, where_.here, where_.channel}));
    if (tcp) where_.channel = local_port(listener_.get());  // to be found there again
    address_ = to_text({where_.kind, tcp ? where_.here : local_rfcomm_address(listener_.get()), where_.channel});
  }

  std::string address() const override { return address_; }
  int descriptor() const noexcept override { return host_.open() ? host_.get() : listener_.get(); }

  Arrival read(std::span<std::uint8_t> into) override {
    if (!host_.open()) {
      host_.reset(::accept4(listener_.get(), nullptr, nullptr, SOCK_NONBLOCK | SOCK_CLOEXEC));
      if (!host_.open()) return {};
      listener_.reset();
      const int on = 1;
      if (where_.kind == LinkKind::tcp) ::setsockopt(host_.get(), IPPROTO_TCP, TCP_NODELAY, &on, sizeof on);
      return {.host = true};
    }
    const ssize_t count = ::recv(host_.get(), into.data(), into.size(), 0);
    if (count > 0) return {.bytes = static_cast<std::size_t>(count)};
    if (count == 0 || (errno != EAGAIN && errno != EINTR)) host_.reset();
    return {};
  }
  void write(std::span<const std::uint8_t> bytes) noexcept override {
    if (!host_.open()) return;
    // The error of a broken connection is reported once: an RFCOMM socket that reported it here has only EAGAIN for
    // recv().
    if (::send(host_.get(), bytes.data(), bytes.size(), MSG_NOSIGNAL) < 0 && errno != EAGAIN && errno != EINTR)
      host_.reset();
  }
  void hang_up() override { host_.reset(); }
  void admit(bool hosts) override {
    if (!hosts)
      listener_.reset();
    else if (!host_.open() && !listener_.open())
      listen();  // if it fails, the next call tries again
  }

 private:
  int open_socket() const {
    switch (where_.kind) {
      case LinkKind::tcp:
        return open_ip_socket(where_.here, where_.channel, SOCK_STREAM);
      case LinkKind::rfcomm:
        return open_rfcomm_socket(where_.here, where_.channel);
      case LinkKind::serial:
      case LinkKind::udp:
        break;  // no host is admitted to these: they have endpoints of their own
    }
    errno = EPROTONOSUPPORT;
    return -1;
  }
  bool listen() {
    listener_.reset(open_socket());
    if (!listener_.open()) return false;
    if (::listen(listener_.get(), 1) == 0) return true;
    const int error = errno;
    listener_.reset();
    errno = error;
    return false;
  }

  ListenAddress where_;
  std::string address_;
  Descriptor listener_;  // closed while a host is there
  Descriptor host_;
};

}  // namespace

std::unique_ptr<Endpoint> make_pty_endpoint(DeviceNames& names, std::size_t robot) {
  return std::make_unique<PtyEndpoint>(names, robot);
}

tl::expected<ListenAddress, std::string> parse_listen_address(std::string_view text) {
  constexpr std::string_view rfcomm = "rfcomm:", tcp = "tcp:", udp = "udp:";
  const auto refuse = [&](const std::string& why) {
    return tl::unexpected(fmt::format(
        "\"{}\": {}; allowed: \"rfcomm:hci4/1\", adapter and channel, \"tcp:127.0.0.1:1000\" or \"udp:127.0.0.1:2626\"",
        text, why));
  };
  if (text.starts_with(tcp) || text.starts_with(udp)) {
    const auto address = parse_link_address(text);
    if (!address) return tl::unexpected(address.error());
    in_addr here{};
    if (::inet_pton(AF_INET, address->device.c_str(), &here) != 1)
      return refuse(fmt::format("\"{}\" is not an IPv4 address of this machine", address->device));
    return ListenAddress{address->kind, address->device, address->channel};
  }
  if (!text.starts_with(rfcomm)) return refuse("begins with neither \"rfcomm:\" nor \"tcp:\" nor \"udp:\"");
  const std::size_t slash = text.rfind('/');
  if (slash == std::string_view::npos) return refuse("has no channel");
  ListenAddress address{LinkKind::rfcomm, std::string(text.substr(rfcomm.size(), slash - rfcomm.size())), 0};
  if (address.here.empty()) return refuse("has no adapter");
  if (const auto adapter = check_adapter(address.here); !adapter) return refuse(adapter.error());
  const std::string_view channel = text.substr(slash + 1);
  const char* const end = channel.data() + channel.size();
  const auto [stop, error] = std::from_chars(channel.data(), end, address.channel);
  if (error != std::errc{} || stop != end || address.channel < 1 || address.channel > 30)
    return refuse(fmt::format("channel \"{}\" is not a number from 1 to 30", channel));
  return address;
}

std::unique_ptr<Endpoint> make_socket_endpoint(const ListenAddress& address) {
  if (address.kind == LinkKind::udp) return std::make_unique<UdpEndpoint>(address);
  return std::make_unique<SocketEndpoint>(address);
}

}  // namespace skein::comms
