#pragma once

#include <sys/types.h>
#include <string>
#include <string_view>
#include <vector>

#include <tl/expected.hpp>

#include "app/experiment/experiment.h"
#include "app/run/status.h"
#include "comms/link_address.h"

namespace skein::app {

/// Robots that a run drives, on disk under $XDG_STATE_HOME/skein (or ~/.local/state/skein): how the next start of the
/// program, and the guard, find them when the run was killed. The file is locked as long as the run lives.
struct RunMarker {
  std::string path;
  std::string experiment;  ///< its name
  std::vector<comms::LinkAddress> robots;

  /// Its robots as people know them: "anna, serial:/dev/ttyUSB0".
  std::string names() const;
  /// The error: it cannot be read, or is no marker.
  static tl::expected<RunMarker, std::string> read(const std::string& path);
};

/// Markers of runs that died without knowing that their robots stand, oldest first.
std::vector<RunMarker> bad_ends();

/// What catches the robots when the program dies: the marker, and `skein guard`, a process of its own that waits at the
/// other end of a pipe and stops the robots when this end is gone. Move-only.
class SafetyNet {
 public:
  /// Nothing for an experiment without real robots. `program`: what to start as `program guard MARKER`; empty: this
  /// program itself. The error: the marker cannot be written, or the guard not started; the run can go on without.
  static tl::expected<SafetyNet, std::string> spread(const Experiment& experiment, const std::string& program = {});
  static tl::expected<SafetyNet, std::string> spread(const std::string& name,
                                                     const std::vector<comms::LinkAddress>& robots,
                                                     const std::string& program = {});
  SafetyNet() = default;
  SafetyNet(SafetyNet&& other) noexcept;
  SafetyNet& operator=(SafetyNet&& other) noexcept;
  ~SafetyNet();  ///< without done(): as if the program had died

  /// The run is over. Where a robot has not acknowledged its stop, the guard goes on trying, and the marker stays.
  void done(const std::vector<RobotStatus>& robots);

 private:
  std::string path_;
  int marker_ = -1;  // locked
  int pipe_ = -1;
  pid_t guard_ = -1;
};

/// `skein guard MARKER`: waits on `descriptor` until the run says that all is well, or is gone; then stops its robots
/// and removes the marker. An exit status.
int guard(const std::string& marker, int descriptor);

/// How a real robot of an experiment is reached, named as robot_name() says.
tl::expected<comms::LinkAddress, std::string> link_of(const Experiment& experiment, std::size_t robot);

/// The real robots of an experiment, named likewise. The error names the robot.
tl::expected<std::vector<comms::LinkAddress>, std::string> real_robots(const Experiment& experiment);

/// Connects to each, at the same time, stops it, and says on stdout and stderr how that went. True: all are known to
/// stand.
bool stop_all(const std::vector<comms::LinkAddress>& robots);

/// Stops the robots of these runs, and forgets the runs whose robots are known to stand. True: all of them.
bool stop_left_behind(const std::vector<RunMarker>& runs);

}  // namespace skein::app
