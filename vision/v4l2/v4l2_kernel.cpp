#include "vision/v4l2/v4l2_kernel.h"

#include <fcntl.h>
#include <sys/ioctl.h>
#include <sys/mman.h>
#include <unistd.h>

#include <fstream>

namespace skein::vision {
namespace {

class SystemKernel final : public V4l2Kernel {
 public:
  int open(const char* device) override { return ::open(device, O_RDWR | O_NONBLOCK | O_CLOEXEC); }
  void close(int fd) override { ::close(fd); }
  int control(int fd, unsigned long request, void* argument) override { return ::ioctl(fd, request, argument); }
  int poll(pollfd* waiting, int milliseconds) override { return ::poll(waiting, 1, milliseconds); }
  void* map(int fd, std::size_t length, std::uint32_t offset) override {
    return ::mmap(nullptr, length, PROT_READ | PROT_WRITE, MAP_SHARED, fd, static_cast<off_t>(offset));
  }
  void unmap(void* start, std::size_t length) override { ::munmap(start, length); }
  std::string parameter(const std::string& module, const std::string& name) override {
    std::ifstream file("/sys/module/" + module + "/parameters/" + name);
    std::string value;
    std::getline(file, value);
    return value;
  }
};

}  // namespace

V4l2Kernel& system_kernel() {
  static SystemKernel kernel;
  return kernel;
}

}  // namespace skein::vision
