#include "comms/emulator/pty.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <pty.h>
#include <termios.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstdlib>
#include <filesystem>
#include <system_error>
#include <utility>

namespace skein::comms {
namespace {

[[noreturn]] void refuse(int error, const std::string& what) {
  throw std::system_error(error, std::generic_category(), what);
}

}  // namespace

Pty::Pty() {
  termios raw{};
  ::cfmakeraw(&raw);
  raw.c_cflag |= CREAD;
  std::array<char, 64> name{};
  // The program's end stays open here as well: otherwise the robot's end would report a hang-up whenever no program is
  // there, and forget the settings.
  if (::openpty(&robot_, &program_, name.data(), &raw, nullptr) != 0) refuse(errno, "pseudo-terminal");
  for (const int descriptor : {robot_, program_}) ::fcntl(descriptor, F_SETFD, FD_CLOEXEC);
  ::fcntl(robot_, F_SETFL, O_NONBLOCK);
  path_ = name.data();
}

Pty::Pty(Pty&& other) noexcept
    : robot_(std::exchange(other.robot_, -1)),
      program_(std::exchange(other.program_, -1)),
      path_(std::move(other.path_)) {}

Pty& Pty::operator=(Pty&& other) noexcept {
  std::swap(robot_, other.robot_);
  std::swap(program_, other.program_);
  std::swap(path_, other.path_);
  return *this;
}

Pty::~Pty() {
  for (const int descriptor : {robot_, program_})
    if (descriptor >= 0) ::close(descriptor);
}

DeviceNames::DeviceNames(std::string directory) : directory_(std::move(directory)) {
  if (!directory_.empty()) {
    std::error_code error;
    made_ = std::filesystem::create_directories(directory_, error);
    if (error) refuse(error.value(), directory_ + " cannot be made");
    return;
  }
  std::error_code error;
  const std::filesystem::path place = std::filesystem::temp_directory_path(error);
  if (error) refuse(error.value(), "the folder for temporary files, TMPDIR or /tmp");
  directory_ = (place / "skein-robots-XXXXXX").string();
  if (::mkdtemp(directory_.data()) == nullptr) refuse(errno, directory_);
  made_ = true;
}

DeviceNames::~DeviceNames() {
  std::error_code ignored;
  for (std::size_t i = 0; i < pointed_; ++i)
    if (std::filesystem::is_symlink(name(i), ignored)) std::filesystem::remove(name(i), ignored);
  if (made_) std::filesystem::remove(directory_, ignored);
}

std::string DeviceNames::name(std::size_t robot) const {
  return fmt::format("{}/robot{}", directory_, robot + 1);
}

void DeviceNames::point(std::size_t robot, const std::string& device) {
  const std::string path = name(robot), fresh = path + ".new";
  if (std::filesystem::exists(std::filesystem::symlink_status(path)) && !std::filesystem::is_symlink(path))
    refuse(EEXIST, path);
  std::error_code error;
  std::filesystem::remove(fresh, error);
  if (!error) std::filesystem::create_symlink(device, fresh, error);
  if (!error) std::filesystem::rename(fresh, path, error);
  if (error) refuse(error.value(), path + " cannot be made");
  pointed_ = std::max(pointed_, robot + 1);
}

}  // namespace skein::comms
