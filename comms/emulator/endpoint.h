#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <string_view>
#include <tl/expected.hpp>

#include "comms/emulator/pty.h"
#include "comms/link_address.h"

namespace skein::comms {

/// The robot's end of the connection to one emulated robot. No call blocks. Not thread-safe.
class Endpoint {
 public:
  virtual ~Endpoint() = default;

  /// The robot as an experiment file names it: "serial:/tmp/robots/robot1", "rfcomm:00:AA:01:04:00:04/1".
  virtual std::string address() const = 0;
  /// To be polled for reading; -1: no input is possible.
  virtual int descriptor() const noexcept = 0;
  struct Arrival {
    std::size_t bytes = 0;  ///< from the host
    bool host = false;      ///< a host has connected; false and no bytes: the host has gone
  };
  /// When the descriptor is readable.
  virtual Arrival read(std::span<std::uint8_t> into) = 0;
  /// Sends to the host. Bytes are lost if there is no room or no host, since a robot does not wait.
  virtual void write(std::span<const std::uint8_t> bytes) noexcept = 0;
  /// Breaks the connection; a host may come again.
  virtual void hang_up() = 0;
  /// Whether new hosts may connect; connected ones stay. Cheap, may be called repeatedly.
  virtual void admit(bool hosts) = 0;
};

/// A pseudo-terminal behind a constant name; after a hang-up a new one replaces it at once. `names` must outlive it.
/// Throws std::system_error.
std::unique_ptr<Endpoint> make_pty_endpoint(DeviceNames& names, std::size_t robot);

/// Where a robot listens on a socket.
struct ListenAddress {
  LinkKind kind = LinkKind::rfcomm;  ///< or tcp, udp
  std::string here;  ///< rfcomm: a Bluetooth adapter, "hci4" or its address; tcp: "127.0.0.1", "0.0.0.0"
  int channel = 0;   ///< RFCOMM channel, 1 to 30; TCP or UDP port, 0: one that is free

  friend bool operator==(const ListenAddress&, const ListenAddress&) = default;
};

/// Reads "rfcomm:hci4/1", "rfcomm:00:AA:01:04:00:04/1", "tcp:127.0.0.1:1000" or "udp:127.0.0.1:2626".
/// The error names what was found and what is allowed.
tl::expected<ListenAddress, std::string> parse_listen_address(std::string_view text);

/// A server for one host at a time, as the robots are: while one is connected, others are refused; over UDP the answers
/// go to the host that sent last. Throws std::system_error.
std::unique_ptr<Endpoint> make_socket_endpoint(const ListenAddress& address);

}  // namespace skein::comms
