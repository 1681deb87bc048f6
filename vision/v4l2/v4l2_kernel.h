#pragma once

#include <poll.h>

#include <cstddef>
#include <cstdint>
#include <string>

namespace skein::vision {

/// The calls into the kernel that a camera needs, with their usual meaning: -1 (MAP_FAILED for map) and errno on
/// failure. Tests replace them to simulate cameras.
class V4l2Kernel {
 public:
  virtual ~V4l2Kernel() = default;
  virtual int open(const char* device) = 0;  // read and write, without blocking
  virtual void close(int fd) = 0;
  virtual int control(int fd, unsigned long request, void* argument) = 0;  // ioctl
  virtual int poll(pollfd* waiting, int milliseconds) = 0;                 // one descriptor
  virtual void* map(int fd, std::size_t length, std::uint32_t offset) = 0;
  virtual void unmap(void* start, std::size_t length) = 0;
  virtual std::string parameter(const std::string& module, const std::string& name) = 0;  // of a module; empty: none
};

/// The machine's own.
V4l2Kernel& system_kernel();

}  // namespace skein::vision
