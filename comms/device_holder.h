#pragma once

#include <string>

namespace skein::comms {

/// Which other program uses a serial device, as "minicom (process 8849)"; empty: none that is known. Programs that
/// respect no lock are not found. Each call reads a few small files of the kernel; none blocks on a device.

/// By a lock file in /var/lock (UUCP's, as minicom and other programs make them). Files whose process has ended, or has
/// another device open, mean nothing.
std::string holder_by_lock_file(const std::string& device);
/// By flock(), as picocom and Skein do. `descriptor`: the device.
std::string holder_by_flock(int descriptor);
/// Any other process that has it open, among those into which this user may look.
std::string holder_by_opening(const std::string& device);

}  // namespace skein::comms
