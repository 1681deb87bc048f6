#pragma once

#include <cstddef>
#include <string>

namespace skein::comms {

/// A pseudo-terminal in raw mode: what a program writes to path() can be read from robot(), and vice versa. Move-only;
/// the constructor throws std::system_error.
class Pty {
 public:
  Pty();
  Pty(Pty&& other) noexcept;
  Pty& operator=(Pty&& other) noexcept;
  ~Pty();  ///< the program's end hangs up

  int robot() const noexcept { return robot_; }  ///< the robot's end, a non-blocking descriptor
  const std::string& path() const noexcept { return path_; }

 private:
  int robot_ = -1;
  int program_ = -1;
  std::string path_;
};

/// Names robot1, robot2, ... in a directory, symbolic links to devices. Constructor and point() throw
/// std::system_error; the destructor removes the names, and the directory if it was made here.
class DeviceNames {
 public:
  /// An empty `directory`: a new one for temporary files.
  explicit DeviceNames(std::string directory);
  ~DeviceNames();
  DeviceNames(const DeviceNames&) = delete;
  DeviceNames& operator=(const DeviceNames&) = delete;

  std::string name(std::size_t robot) const;
  /// Makes a robot's name lead to `device`, atomically. Takes over a name left behind by a program that died, but no
  /// file that is something else.
  void point(std::size_t robot, const std::string& device);

 private:
  std::string directory_;
  bool made_ = false;
  std::size_t pointed_ = 0;  // robots below this number may have a name made here
};

}  // namespace skein::comms
