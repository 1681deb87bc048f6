#pragma once

#include <string>
#include <string_view>
#include <vector>

#include <tl/expected.hpp>

#include "comms/link_address.h"

namespace skein::app {

/// Where runs leave their markers: the first of $XDG_STATE_HOME/skein, ~/.local/state/skein, $XDG_RUNTIME_DIR/skein,
/// /run/user/UID/skein and /tmp/skein-UID that exists or can be created, and that only this user can write to: another
/// user's marker would choose what this program connects to.
std::string state_directory();

/// Robots that a run drives, in a file of the state directory: how the next start of the program, the guard and `skein
/// robots stop` find them. The file is locked while the run is active; its stop socket (stop_socket.h) is beside it.
struct RunMarker {
  std::string path;
  std::string experiment;  ///< its name
  std::vector<comms::LinkAddress> robots;

  std::string socket() const { return path + ".stop"; }
  /// Its robots for messages: "anna, serial:/dev/ttyUSB0".
  std::string names() const;
  bool alive() const;   ///< the run that wrote it is still active
  void forget() const;  ///< removes it, and the socket
  /// forget(), and also ends its guard, at the user's request. The guard keeps the file open and reads `dismissal` at
  /// its beginning.
  void dismiss() const;
  static constexpr std::string_view dismissal = "skein dismissed\n";

  /// The error: it cannot be read, or is not a marker.
  static tl::expected<RunMarker, std::string> read(const std::string& path);
};

/// How a guard knows its marker, and others know the guard. Whoever ends all that is called skein (killall, pkill -f)
/// must spare it: neither its name nor its command line has the word, and this environment variable has the path.
inline constexpr const char* guard_name = "robot-guard";
inline constexpr const char* marker_variable = "SKEIN_GUARD_MARKER";

struct WrittenMarker {
  int lock = -1;        ///< the descriptor that holds the marker's lock
  std::string problem;  ///< why it is not in the state directory; empty: it is
};

/// Writes a new marker to disk, locks it, and sets its path: a name in the state directory that no other run ever has,
/// since process numbers repeat, in containers and after a boot. If it cannot be written there it goes to another place
/// where all_markers() searches: the user's runtime directory, /dev/shm or /tmp. Host names in it are resolved, since
/// its reader may have no name service.
tl::expected<WrittenMarker, std::string> write_marker(RunMarker& marker);

/// Keeps only these robots in the marker of this descriptor.
void rewrite_marker(int descriptor, const RunMarker& marker) noexcept;

struct FoundMarkers {
  std::vector<RunMarker> runs;  ///< oldest first
  std::string unreadable;  ///< a sentence: why there may be more of them, which are not stopped; empty: these are all
};
FoundMarkers find_markers();

/// Those that can be read.
std::vector<RunMarker> all_markers();

/// Markers of runs that died before their robots were known to stand, oldest first.
std::vector<RunMarker> bad_ends();

}  // namespace skein::app
