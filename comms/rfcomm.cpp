#include "comms/rfcomm.h"

#include <bluetooth/bluetooth.h>
#include <bluetooth/hci.h>
#include <bluetooth/hci_lib.h>
#include <bluetooth/rfcomm.h>
#include <sys/socket.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <cstdlib>

namespace skein::comms {
namespace {

bool bind_to(int descriptor, const std::string& adapter, int channel) {
  sockaddr_rc local{};  // all zeros: any adapter
  local.rc_family = AF_BLUETOOTH;
  local.rc_channel = static_cast<std::uint8_t>(channel);
  if (adapter.starts_with("hci")) {
    if (::hci_devba(std::atoi(adapter.c_str() + 3), &local.rc_bdaddr) != 0) return false;
  } else if (!adapter.empty()) {
    ::str2ba(adapter.c_str(), &local.rc_bdaddr);
  }
  return ::bind(descriptor, reinterpret_cast<const sockaddr*>(&local), sizeof local) == 0;
}

}  // namespace

int open_rfcomm_socket(const std::string& adapter, int channel) {
  const int descriptor = ::socket(AF_BLUETOOTH, SOCK_STREAM | SOCK_NONBLOCK | SOCK_CLOEXEC, BTPROTO_RFCOMM);
  if (descriptor < 0) return -1;
  if ((adapter.empty() && channel == 0) || bind_to(descriptor, adapter, channel)) return descriptor;
  const int error = errno;
  ::close(descriptor);
  errno = error;
  return -1;
}

bool connect_rfcomm(int descriptor, const std::string& robot, int channel) {
  sockaddr_rc remote{};
  remote.rc_family = AF_BLUETOOTH;
  remote.rc_channel = static_cast<std::uint8_t>(channel);
  ::str2ba(robot.c_str(), &remote.rc_bdaddr);
  return ::connect(descriptor, reinterpret_cast<const sockaddr*>(&remote), sizeof remote) == 0;
}

std::string local_rfcomm_address(int descriptor) {
  sockaddr_rc local{};
  socklen_t size = sizeof local;
  if (::getsockname(descriptor, reinterpret_cast<sockaddr*>(&local), &size) != 0) return {};
  std::array<char, 18> text{};
  ::ba2str(&local.rc_bdaddr, text.data());
  return text.data();
}

}  // namespace skein::comms
