#pragma once

#include <string>

namespace skein::comms {

/// A non-blocking RFCOMM socket, bound to one of the PC's adapters ("hci1" or its address; empty: any) and a channel (0
/// for one that connects). Returns its descriptor, which the caller closes; -1: errno has the reason, ENODEV or
/// EADDRNOTAVAIL if there is no such adapter.
int open_rfcomm_socket(const std::string& adapter, int channel);

/// Connects such a socket to a robot; false: errno has the reason, EINPROGRESS or EAGAIN while connecting.
bool connect_rfcomm(int descriptor, const std::string& robot, int channel);

/// The Bluetooth address that a socket is bound to, "00:1A:7D:DA:71:13".
std::string local_rfcomm_address(int descriptor);

}  // namespace skein::comms
