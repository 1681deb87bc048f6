#pragma once

#include <optional>
#include <string>

#include "vision/diagnosis/lasting_fault.h"

namespace skein::vision {

/// A camera whose time stamps make every pose too old to drive by, however good its pictures are: stamps that stand
/// still or were set back, a `camera.latency` that is too large, a camera that needs this long. Without this the robots
/// would stand for no reason that anybody could see. Times are those of one clock [s]; for one thread.
class StampWatch {
 public:
  /// It counts as a fault when no stamp has been well for longer than this, and not by a single frame: after a pause of
  /// the machine the first one is what the camera's buffers kept. [s]
  static constexpr double patience = 0.25;

  /// `oldest`: poses that are older stop their robots. [s]
  explicit StampWatch(double oldest) : oldest_(oldest) {}

  /// A frame by its stamp, and when it arrived. true: `fault` has begun or ended.
  bool update(double captured_at, double arrived_at);
  /// The same frame, before its stamp was limited to its arrival: how much later the stamp is [s]. A sentence without a
  /// full stop once that has lasted, and not again until stamps are right; otherwise empty.
  std::string update_ahead(double by, double arrived_at);
  /// A sentence without a full stop, for people: "its time stamps do not advance"; empty: none.
  const std::string& fault() const noexcept { return fault_; }

 private:
  double oldest_;
  std::optional<double> newest_;   // of all stamps
  std::optional<double> well_at_;  // when the last good one arrived
  bool well_ = true;               // the last one was
  std::string fault_;
  LastingFault ahead_;
};

}  // namespace skein::vision
