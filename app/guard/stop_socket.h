#pragma once

#include <sys/types.h>
#include <algorithm>
#include <functional>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include <poll.h>
#include <tl/expected.hpp>

namespace skein::app {

/// The result of stopping one robot.
struct StopResult {
  std::string address;  ///< as comms::to_text() writes it
  bool stopped = false;
  std::string reason{};  ///< why it is not known to stand, if so
};

inline bool all_stand(const std::vector<StopResult>& robots) {
  return std::all_of(robots.begin(), robots.end(), [](const StopResult& robot) { return robot.stopped; });
}

/// The socket beside a run's marker, through which every program of the same user can stop the run, or the guard that
/// continues after it: `skein stop`. Input: one word, "stop" or "forget"; output: "stopping", then one line for each
/// robot. One thread at a time.
class StopSocket {
 public:
  static tl::expected<StopSocket, std::string> listen(const std::string& path);
  StopSocket(StopSocket&& other) noexcept;
  StopSocket& operator=(StopSocket&& other) noexcept;
  ~StopSocket();  ///< the file stays: it is removed with the marker

  int descriptor() const noexcept { return listening_; }  ///< readable: a client connects
  bool waits() const noexcept { return !callers_.empty(); }
  /// Serves clients, and sends waiting ones the robots' states as soon as all stand, or after 5 s, or at once if this
  /// is the `last` chance. `heard` gets each word before the client is answered.
  void turn(const std::function<void(std::string_view word)>& heard,
            const std::function<std::vector<StopResult>()>& results, bool last = false);

 private:
  explicit StopSocket(int descriptor) : listening_(descriptor) {}
  struct Caller {
    int descriptor;
    double until;
  };
  int listening_ = -1;
  std::vector<Caller> callers_;
};

/// The answer of a run to `word`.
struct StopAnswer {
  bool reached = false;                           ///< the connection was accepted
  bool heard = false;                             ///< and `word` was confirmed in time
  bool ended = false;                             ///< and the other end has closed
  pid_t process = 0;                              ///< of the listener; 0: not known, or in another PID namespace
  std::optional<std::vector<StopResult>> robots;  ///< empty: it ended before it could report
};

/// Whether a run or its guard listens at this stop socket; asks it nothing, and waits for no answer.
bool listens(const std::string& path);

/// Sends `word` to the run with this stop socket. Waits `patience` for the confirmation, then up to 8 s for the robots'
/// states; in both cases until the user interrupts.
StopAnswer ask_run(const std::string& path, std::string_view word, double patience);

}  // namespace skein::app
