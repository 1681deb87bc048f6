#pragma once

#include <sys/types.h>
#include <functional>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include <poll.h>
#include <tl/expected.hpp>

namespace skein::app {

/// What became of one robot that was to be stopped.
struct StopResult {
  std::string address;  ///< as comms::to_text() writes it
  bool stopped = false;
  std::string reason{};  ///< why it is not known to be, if it is not
};

/// The socket beside a run's marker, where everybody of the same user can stop the run, or the guard that goes on after
/// it, without a keyboard: `skein stop`. One word in, "stop" or "forget"; lines out: "stopping", then one for each
/// robot. One thread at a time.
class StopSocket {
 public:
  static tl::expected<StopSocket, std::string> listen(const std::string& path);
  StopSocket(StopSocket&& other) noexcept;
  StopSocket& operator=(StopSocket&& other) noexcept;
  ~StopSocket();  ///< the file stays: it goes with the marker

  int descriptor() const noexcept { return listening_; }  ///< readable: somebody calls
  bool waits() const noexcept { return !callers_.empty(); }
  /// Hears who calls, and tells those that wait how the robots are as soon as all stand, or after 5 s, or at once if
  /// this is the `last` chance. `heard` gets each word before the caller is answered.
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

/// What a run says to `word`.
struct StopAnswer {
  bool reached = false;                           ///< somebody listens there
  bool heard = false;                             ///< and said so within the time
  bool ended = false;                             ///< and went away
  pid_t process = 0;                              ///< of who listens; 0: not known, or in another PID namespace
  std::optional<std::vector<StopResult>> robots;  ///< empty: it ended before it could say
};

/// Says `word` to the run whose stop socket is there. Waits `patience` for somebody to hear it, then up to 8 s for what
/// became of the robots.
StopAnswer ask_run(const std::string& path, std::string_view word, double patience);

}  // namespace skein::app
