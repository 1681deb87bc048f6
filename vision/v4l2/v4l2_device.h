#pragma once

#include <string>
#include <string_view>
#include <utility>

#include "vision/v4l2/v4l2_kernel.h"

namespace skein::vision::detail {

/// One of the kernel's video devices, open or not. Problems are texts; empty: none.
class V4l2Device {
 public:
  V4l2Device(std::string path, V4l2Kernel& kernel) : path_(std::move(path)), kernel_(kernel) {}
  ~V4l2Device() { close(); }
  V4l2Device(const V4l2Device&) = delete;
  V4l2Device& operator=(const V4l2Device&) = delete;

  /// Opens it and makes sure that it captures video.
  std::string open();
  void close();

  /// ioctl, repeated if a signal interrupts it.
  int control(unsigned long request, void* argument) const;
  /// "PATH: WHAT (the system's reason)".
  std::string failed(std::string_view what) const;

  const std::string& path() const { return path_; }
  V4l2Kernel& kernel() const { return kernel_; }
  int fd() const { return fd_; }
  /// The driver's names for the device and for itself; after open().
  const std::string& card() const { return card_; }
  const std::string& driver() const { return driver_; }

 private:
  std::string path_;
  V4l2Kernel& kernel_;
  int fd_ = -1;
  std::string card_;
  std::string driver_;
};

/// "YUYV" from the kernel's number for it.
std::string four_letters(unsigned format);

}  // namespace skein::vision::detail
