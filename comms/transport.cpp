#include "comms/transport.h"

#include <arpa/inet.h>
#include <fcntl.h>
#include <fmt/format.h>
#include <linux/sockios.h>
#include <netinet/in.h>
#include <netinet/tcp.h>
#include <sys/epoll.h>
#include <sys/file.h>
#include <sys/ioctl.h>
#include <sys/socket.h>
#include <termios.h>
#include <unistd.h>

#include <cerrno>
#include <system_error>
#include <utility>

#include "comms/device_holder.h"
#include "comms/protocol.h"
#include "comms/rfcomm.h"

namespace skein::comms {
namespace {

tl::unexpected<TransportError> fail(int error, const LinkAddress& address) {
  return tl::unexpected(describe_transport_error(error, address));
}

tl::unexpected<TransportError> held_by(const std::string& holder) {
  return tl::unexpected(TransportError{
      fmt::format("{} is using the device", holder.empty() ? std::string("another program") : holder), false});
}

bool nothing_now(int error) {
  return error == EAGAIN || error == EWOULDBLOCK || error == EINTR;
}

// Raw bytes at 115200 baud, 8 data bits, no parity, 1 stop bit, no flow control of either kind.
bool make_raw(int descriptor) {
  termios settings{};
  if (::tcgetattr(descriptor, &settings) != 0) return false;
  ::cfmakeraw(&settings);
  ::cfsetispeed(&settings, B115200);
  ::cfsetospeed(&settings, B115200);
  settings.c_cflag |= CLOCAL | CREAD;
  settings.c_cflag &= ~static_cast<tcflag_t>(CRTSCTS | CSTOPB | PARENB);
  settings.c_cc[VMIN] = 1;  // with 0 a read of an empty line would look like a hang-up
  settings.c_cc[VTIME] = 0;
  return ::tcsetattr(descriptor, TCSANOW, &settings) == 0 && ::tcflush(descriptor, TCIOFLUSH) == 0;
}

/// Whether a program has it for itself (TIOCEXCL, as ModemManager does). The superuser may open it all the same.
bool is_exclusive(int terminal) noexcept {
  int exclusive = 0;
  return ::ioctl(terminal, TIOCGEXCL, &exclusive) == 0 && exclusive != 0;
}

/// Asked whether it has input, a terminal that has none waits until a kernel thread of ordinary priority has passed on
/// what its driver may have received: on a busy machine a second, in which no other robot is served. An epoll that is
/// told of input does not ask.
int told_of_input(int terminal) noexcept {
  const int input = ::epoll_create1(EPOLL_CLOEXEC);
  epoll_event wanted{};
  wanted.events = EPOLLIN | EPOLLET;
  if (input < 0 || ::epoll_ctl(input, EPOLL_CTL_ADD, terminal, &wanted) == 0) return input;
  ::close(input);
  return -1;
}

int bytes_waiting(int descriptor) noexcept {
  int bytes = 0;
  return ::ioctl(descriptor, FIONREAD, &bytes) == 0 ? bytes : -1;
}

/// Otherwise its descriptor is a terminal.
bool is_socket(LinkKind kind) noexcept {
  switch (kind) {
    case LinkKind::serial:
      return false;
    case LinkKind::rfcomm:
    case LinkKind::tcp:
    case LinkKind::udp:
      return true;
  }
  return false;
}

int ip_socket(LinkKind kind) noexcept {
  constexpr int flags = SOCK_NONBLOCK | SOCK_CLOEXEC;
  switch (kind) {
    case LinkKind::tcp:
      return ::socket(AF_INET, SOCK_STREAM | flags, 0);
    case LinkKind::udp:
      return ::socket(AF_INET, SOCK_DGRAM | flags, 0);
    case LinkKind::serial:
    case LinkKind::rfcomm:
      break;
  }
  errno = EPROTONOSUPPORT;
  return -1;
}

/// What is sent while a robot is out of reach, its stop above all, TCP sends again at intervals that double, so that a
/// robot may drive on for as long again as it was out of reach. Linux 6.15 and later repeat it every second if they are
/// asked to. Then TCP must not give the connection up after its usual 15 repetitions, which would be 15 s: an e-puck2
/// has about ten connections and never closes one.
void send_again_every_second(int socket) noexcept {
  constexpr int tcp_rto_max_ms = 44;                  // not in the headers of Debian 12
  constexpr int interval = 1000, patience = 120'000;  // [ms]
  if (::setsockopt(socket, IPPROTO_TCP, tcp_rto_max_ms, &interval, sizeof interval) == 0)
    ::setsockopt(socket, IPPROTO_TCP, TCP_USER_TIMEOUT, &patience, sizeof patience);
}

}  // namespace

TransportError describe_transport_error(int error, const LinkAddress& address) {
  const bool rfcomm = address.kind == LinkKind::rfcomm;
  const bool udp = address.kind == LinkKind::udp;
  const bool tcp = address.kind == LinkKind::tcp || udp;
  switch (error) {
    case ECONNREFUSED:
      if (udp) return {fmt::format("nothing listens on port {}: is the robot's program running?", address.channel)};
      if (tcp)
        return {fmt::format("nothing listens on port {}: is the selector at 15 and the WiFi firmware on the robot?",
                            address.channel)};
      return {
          fmt::format("the robot refuses channel {}: is its selector at 3? An e-puck1 listens on 1, an e-puck2 on 2",
                      address.channel)};
    case EHOSTDOWN:
      return {"the robot does not answer: is it switched on, in range, and the address right?"};
    case EBUSY:
      if (rfcomm) return {"the robot or its channel is busy: another connection to it is still open"};
      return {"another program is using the device"};
    case EWOULDBLOCK:  // what flock says of a device that is locked
      return {"another program is using the device"};
    case EHOSTUNREACH:
    case ENETDOWN:
    case ENETUNREACH:
    case ENODEV:
    case ENXIO:
      if (tcp) return {"there is no route to the robot: is it switched on, and in the same network as this machine?"};
      if (rfcomm) return {"no Bluetooth adapter is on: plug one in, or switch it on with \"bluetoothctl power on\""};
      return {"the device is gone"};
    case EADDRNOTAVAIL:
      return {fmt::format("this machine has no Bluetooth adapter {}", address.adapter), true};
    case EAFNOSUPPORT:
    case EPROTONOSUPPORT:
    case ESOCKTNOSUPPORT:
      return {"this machine's kernel does not support Bluetooth serial connections (RFCOMM)", true};
    case ETIMEDOUT:
      return {"the robot did not answer in time"};
    case ECONNRESET:
    case EPIPE:
      return {"the robot closed the connection"};
    case ECONNABORTED:
      return {"the Bluetooth adapter was unplugged or reset"};
    case EIO:
      return {rfcomm || tcp ? "the connection failed" : "the line hung up"};
    case EACCES:
    case EPERM:
      if (rfcomm) return {"the robot or the system refuses the connection: has the robot been paired?", true};
      return {fmt::format("no permission for {}: is the user in the group dialout?", address.device), true};
    case ENOENT:
    case ENOTDIR:
    case ENAMETOOLONG:
      return {fmt::format("there is no device {}", address.device), true};
    case ENOTTY:
    case EISDIR:
    case ELOOP:
      return {fmt::format("{} is not a serial line", address.device), true};
    default:
      return {std::generic_category().message(error)};
  }
}

tl::expected<Transport, TransportError> Transport::open(const LinkAddress& address, bool name_holder) {
  switch (address.kind) {
    case LinkKind::serial:
      return open_serial(address, name_holder);
    case LinkKind::rfcomm:
      return open_rfcomm(address);
    case LinkKind::tcp:
    case LinkKind::udp:
      return open_ip(address);
  }
  return fail(EINVAL, address);
}

tl::expected<Transport, TransportError> Transport::open_serial(const LinkAddress& address, bool name_holder) {
  const auto held_alone = [&] { return held_by(name_holder ? holder_by_opening(address.device) : std::string()); };
  // Before it is opened: two readers of one line would each take some of its bytes.
  if (const std::string holder = holder_by_lock_file(address.device); !holder.empty()) return held_by(holder);
  const int descriptor = ::open(address.device.c_str(), O_RDWR | O_NOCTTY | O_NONBLOCK | O_CLOEXEC);
  if (descriptor < 0 && errno == EBUSY) return held_alone();
  if (descriptor < 0) return fail(errno, address);
  Transport transport(descriptor, /*connecting=*/false, address);  // closes the descriptor on the ways out below
  if (::isatty(descriptor) == 0) return fail(ENOTTY, address);
  if (is_exclusive(descriptor)) return held_alone();
  if (::flock(descriptor, LOCK_EX | LOCK_NB) != 0)
    return nothing_now(errno) ? held_by(holder_by_flock(descriptor)) : fail(errno, address);
  if (!make_raw(descriptor)) return fail(errno, address);
  transport.input_ = told_of_input(descriptor);
  transport.connected();
  return transport;
}

tl::expected<Transport, TransportError> Transport::open_rfcomm(const LinkAddress& address) {
  if (const auto adapter = check_adapter(address.adapter); !adapter)
    return tl::unexpected(TransportError{adapter.error(), true});
  const int descriptor = open_rfcomm_socket(address.adapter, 0);
  if (descriptor < 0) {
    const bool absent = errno == ENODEV || errno == EADDRNOTAVAIL;
    return fail(absent ? EADDRNOTAVAIL : errno, address);
  }
  Transport transport(descriptor, /*connecting=*/true, address);
  if (connect_rfcomm(descriptor, address.device, address.channel))
    transport.connected();
  else if (errno != EINPROGRESS && errno != EAGAIN)
    return fail(errno, address);
  return transport;
}

tl::expected<Transport, TransportError> Transport::open_ip(const LinkAddress& address) {
  sockaddr_in robot{};
  robot.sin_family = AF_INET;
  robot.sin_port = htons(static_cast<std::uint16_t>(address.channel));
  if (::inet_pton(AF_INET, address.device.c_str(), &robot.sin_addr) != 1)
    return tl::unexpected(TransportError{fmt::format("{} is not an IPv4 address", address.device), true});
  const int descriptor = ip_socket(address.kind);
  if (descriptor < 0) return fail(errno, address);
  Transport transport(descriptor, /*connecting=*/true, address);
  const int on = 1;  // 21 bytes wait for no others
  if (address.kind == LinkKind::tcp) {
    ::setsockopt(descriptor, IPPROTO_TCP, TCP_NODELAY, &on, sizeof on);
    send_again_every_second(descriptor);
  }
  if (::connect(descriptor, reinterpret_cast<const sockaddr*>(&robot), sizeof robot) == 0)
    transport.connected();
  else if (errno != EINPROGRESS)
    return fail(errno, address);
  return transport;
}

Transport::Transport(int descriptor, bool connecting, LinkAddress address)
    : descriptor_(descriptor), connecting_(connecting), address_(std::move(address)) {}

Transport::Transport(Transport&& other) noexcept
    : descriptor_(std::exchange(other.descriptor_, -1)),
      input_(std::exchange(other.input_, -1)),
      connecting_(other.connecting_),
      address_(std::move(other.address_)),
      crash_entry_(std::move(other.crash_entry_)),
      guarded_line_(std::move(other.guarded_line_)) {}

Transport& Transport::operator=(Transport&& other) noexcept {
  std::swap(descriptor_, other.descriptor_);
  std::swap(input_, other.input_);
  std::swap(connecting_, other.connecting_);
  std::swap(address_, other.address_);
  std::swap(crash_entry_, other.crash_entry_);
  std::swap(guarded_line_, other.guarded_line_);
  return *this;
}

Transport::~Transport() {
  guarded_line_ = GuardedLine();
  crash_entry_ = CrashEntry();  // before the descriptor may be somebody else's
  if (input_ >= 0) ::close(input_);
  if (descriptor_ < 0) return;
  // The guard has a duplicate, and closes it a moment later: the connection and the lock must not last until then.
  if (address_.kind == LinkKind::serial)
    ::flock(descriptor_, LOCK_UN);
  else
    ::shutdown(descriptor_, SHUT_RDWR);
  ::close(descriptor_);
}

void Transport::connected() noexcept {
  connecting_ = false;
  const Protocol& protocol = protocol_of(address_);
  crash_entry_ = CrashEntry(descriptor_, protocol);
  guarded_line_ = GuardedLine(descriptor_, protocol.stop_bytes(), to_text(address_));
}

tl::expected<void, TransportError> Transport::finish_connecting() {
  int error = 0;
  socklen_t size = sizeof error;
  if (::getsockopt(descriptor_, SOL_SOCKET, SO_ERROR, &error, &size) != 0) error = errno;
  if (error != 0) return fail(error, address_);
  connected();
  return {};
}

pollfd Transport::wanted(bool to_write) const noexcept {
  if (input_ >= 0 && !to_write && bytes_waiting(descriptor_) == 0)
    return {.fd = input_, .events = POLLIN, .revents = 0};
  return {.fd = descriptor_, .events = static_cast<short>(to_write ? POLLIN | POLLOUT : POLLIN), .revents = 0};
}

/// Not so of a line that has hung up: read() says that.
bool Transport::nothing_came() const noexcept {
  epoll_event told{};
  const bool ended = ::epoll_wait(input_, &told, 1, 0) == 1 && (told.events & (EPOLLHUP | EPOLLERR)) != 0;
  return !ended && bytes_waiting(descriptor_) == 0;
}

tl::expected<std::size_t, TransportError> Transport::read(std::span<std::uint8_t> into) {
  if (input_ >= 0 && nothing_came()) return 0;
  const ssize_t count = ::read(descriptor_, into.data(), into.size());
  if (count > 0) return static_cast<std::size_t>(count);
  if (count < 0 && nothing_now(errno)) return 0;
  if (count < 0) return fail(errno, address_);
  if (address_.kind == LinkKind::udp) return 0;                        // an empty datagram
  return fail(is_socket(address_.kind) ? ECONNRESET : EIO, address_);  // end of file: hung up
}

tl::expected<std::size_t, TransportError> Transport::write(std::span<const std::uint8_t> bytes) {
  // A socket whose other end is gone would raise SIGPIPE, a terminal cannot and knows no flags.
  const ssize_t count = is_socket(address_.kind) ? ::send(descriptor_, bytes.data(), bytes.size(), MSG_NOSIGNAL)
                                                 : ::write(descriptor_, bytes.data(), bytes.size());
  if (count >= 0) return static_cast<std::size_t>(count);
  if (nothing_now(errno)) return 0;
  return fail(errno, address_);
}

std::size_t Transport::undelivered() const noexcept {
  int bytes = 0;
  const bool known = address_.kind == LinkKind::tcp && ::ioctl(descriptor_, SIOCOUTQ, &bytes) == 0 && bytes > 0;
  return known ? static_cast<std::size_t>(bytes) : 0;
}

}  // namespace skein::comms
