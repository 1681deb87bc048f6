#include "comms/emulator/endpoint.h"

#include <fmt/format.h>
#include <sys/socket.h>
#include <unistd.h>

#include <cerrno>
#include <charconv>
#include <system_error>
#include <utility>

#include "comms/link_address.h"
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
  std::size_t read(std::span<std::uint8_t> into) override {
    const ssize_t count = ::read(pty_.robot(), into.data(), into.size());
    return count > 0 ? static_cast<std::size_t>(count) : 0;
  }
  void write(std::span<const std::uint8_t> bytes) noexcept override {
    [[maybe_unused]] const auto written = ::write(pty_.robot(), bytes.data(), bytes.size());
  }
  void hang_up() override {
    Pty fresh;  // first: the name must lead somewhere before the old line breaks
    names_.point(robot_, fresh.path());
    pty_ = std::move(fresh);
  }
  void admit(bool) override {}  // whoever opens the line meanwhile meets a robot that does not hear him

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
  bool open() const noexcept { return value_ >= 0; }

 private:
  int value_ = -1;
};

class SocketEndpoint final : public Endpoint {
 public:
  explicit SocketEndpoint(ListenAddress address) : where_(std::move(address)) {
    if (!listen())
      throw std::system_error(errno, std::generic_category(),
                              fmt::format("rfcomm:{}/{}", where_.adapter, where_.channel));
    address_ = fmt::format("rfcomm:{}/{}", local_rfcomm_address(listener_.get()), where_.channel);
  }

  std::string address() const override { return address_; }
  int descriptor() const noexcept override { return host_.open() ? host_.get() : listener_.get(); }

  std::size_t read(std::span<std::uint8_t> into) override {
    if (!host_.open()) {
      host_.reset(::accept4(listener_.get(), nullptr, nullptr, SOCK_NONBLOCK | SOCK_CLOEXEC));
      if (host_.open()) listener_.reset();
      return 0;
    }
    const ssize_t count = ::recv(host_.get(), into.data(), into.size(), 0);
    if (count > 0) return static_cast<std::size_t>(count);
    if (count == 0 || (errno != EAGAIN && errno != EINTR)) host_.reset();
    return 0;
  }
  void write(std::span<const std::uint8_t> bytes) noexcept override {
    if (host_.open()) [[maybe_unused]]
      const auto sent = ::send(host_.get(), bytes.data(), bytes.size(), MSG_NOSIGNAL);
  }
  void hang_up() override { host_.reset(); }
  void admit(bool hosts) override {
    if (!hosts)
      listener_.reset();
    else if (!host_.open() && !listener_.open())
      listen();  // if it fails, the next call tries again
  }

 private:
  bool listen() {
    listener_.reset(open_rfcomm_socket(where_.adapter, where_.channel));
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
  const auto refuse = [&](const std::string& why) {
    return tl::unexpected(fmt::format("\"{}\": {}; allowed: \"rfcomm:hci4/1\", adapter and channel", text, why));
  };
  constexpr std::string_view rfcomm = "rfcomm:";
  const std::size_t slash = text.rfind('/');
  if (!text.starts_with(rfcomm)) return refuse("does not begin with \"rfcomm:\"");
  if (slash == std::string_view::npos) return refuse("has no channel");
  ListenAddress address{std::string(text.substr(rfcomm.size(), slash - rfcomm.size())), 0};
  if (address.adapter.empty()) return refuse("has no adapter");
  if (const auto adapter = check_adapter(address.adapter); !adapter) return refuse(adapter.error());
  const std::string_view channel = text.substr(slash + 1);
  const char* const end = channel.data() + channel.size();
  const auto [stop, error] = std::from_chars(channel.data(), end, address.channel);
  if (error != std::errc{} || stop != end || address.channel < 1 || address.channel > 30)
    return refuse(fmt::format("channel \"{}\" is not a number from 1 to 30", channel));
  return address;
}

std::unique_ptr<Endpoint> make_socket_endpoint(const ListenAddress& address) {
  return std::make_unique<SocketEndpoint>(address);
}

}  // namespace skein::comms
