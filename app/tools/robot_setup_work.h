#pragma once

#include <cstddef>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "app/tools/robot_setup.h"

namespace skein::app {

/// What is to be done with robots that are being set up.
struct SetupTask {
  enum class Kind {
    scan,  ///< search for robots by Bluetooth
    pair,  ///< with each of `robots`
    ping,  ///< all of `robots` at once, see ping_robots
    test,  ///< one of `robots` after the other, see RobotTest: they drive
  };
  Kind kind;
  std::string adapter{};                                     ///< Bluetooth: "hci1" or its address; empty: any
  Experiment experiment{};                                   ///< rate, limits of the links and cameras are its own
  std::vector<std::pair<std::size_t, RobotSetup>> robots{};  ///< each with the caller's own number for it
};

/// The progress of a task since the last call.
struct SetupNews {
  std::string doing;                                       ///< what goes on, in words
  std::vector<std::pair<std::size_t, RobotSetup>> robots;  ///< with all that is known of them now
  std::vector<comms::BluetoothRobot> found;                ///< by a scan
  std::vector<std::string> warnings;                       ///< that the operator must see
  std::string problem;                                     ///< why it did not finish; empty: it did
  bool over = false;  ///< the task uses no robot any more, and all are known to stand except those with `may_drive`
};

/// Does a task aside. Neither a call nor the destructor waits for robots; the destructor stops the task, which then
/// ends by itself. A test also ends if news() is not called for 3 s: an operator whose window hangs cannot stop the
/// robots. All calls from one thread.
class SetupWork {
 public:
  explicit SetupWork(SetupTask task);
  ~SetupWork();
  SetupWork(const SetupWork&) = delete;
  SetupWork& operator=(const SetupWork&) = delete;

  /// Ends it: robots that drive are stopped at once, as by STOP.
  void stop() noexcept;
  /// Takes what is new, once.
  SetupNews news();
  bool wait(double seconds) const;  ///< until it is over; false: it is not yet

 private:
  struct Work;
  std::shared_ptr<Work> work_;  // the thread's, too
};

}  // namespace skein::app
