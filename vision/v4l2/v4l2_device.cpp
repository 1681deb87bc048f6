#include "vision/v4l2/v4l2_device.h"

#include <fmt/format.h>
#include <linux/videodev2.h>

#include <cerrno>
#include <cstring>

namespace skein::vision::detail {

std::string V4l2Device::open() {
  fd_ = kernel_.open(path_.c_str());
  if (fd_ < 0) return failed("cannot be opened");
  v4l2_capability capability{};
  if (control(VIDIOC_QUERYCAP, &capability) == -1) return path_ + ": is not a V4L2 camera";
  const auto text = [](const auto& letters) {
    const char* begin = reinterpret_cast<const char*>(letters);
    return std::string(begin, strnlen(begin, sizeof letters));
  };
  card_ = text(capability.card);
  driver_ = text(capability.driver);
  const unsigned can =
      (capability.capabilities & V4L2_CAP_DEVICE_CAPS) != 0 ? capability.device_caps : capability.capabilities;
  if ((can & V4L2_CAP_VIDEO_CAPTURE) == 0 || (can & V4L2_CAP_STREAMING) == 0)
    return path_ + ": does not capture video (a camera often has a second device that does)";
  return {};
}

void V4l2Device::close() {
  if (fd_ >= 0) kernel_.close(fd_);
  fd_ = -1;
}

int V4l2Device::control(unsigned long request, void* argument) const {
  int result = 0;
  do {
    result = kernel_.control(fd_, request, argument);
  } while (result == -1 && errno == EINTR);
  return result;
}

std::string V4l2Device::failed(std::string_view what) const {
  return fmt::format("{}: {} ({})", path_, what, std::strerror(errno));
}

std::string four_letters(unsigned format) {
  std::string text;
  for (int i = 0; i < 4; ++i) text += static_cast<char>((format >> (8 * i)) & 0x7f);
  return text;
}

}  // namespace skein::vision::detail
