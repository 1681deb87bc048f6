#pragma once

#include <cstddef>
#include <span>
#include <vector>

#include "core/control/gains.h"
#include "core/control/tracking_error.h"

namespace skein::core {

/// The processor's instruction set that the loops over pairs use. The results are the same, bit for bit: the operations
/// of every pair and partial sum and their order are fixed, only the vector width differs.
enum class Instructions { baseline, avx2 };
/// The widest of this machine.
Instructions best_instructions() noexcept;

/// The coupling sums of (15a, b) for large groups, without a transcendental function per pair: with c the same for all
/// pairs, tanh(a - b) follows from one exponential per robot (the addition formula). Allocates in its constructor only.
class LawPairs {
 public:
  explicit LawPairs(std::size_t robots, Instructions instructions = best_instructions());

  /// Whether these gains and errors are suitable: (11b) needs uniform c and |c e| small enough to lose no significant
  /// digit.
  bool suit(const Gains& gains, std::span<const TrackingError> errors) const noexcept;
  /// Adds the sums to the commands. Requires `suit`, and at most as many robots as given to the constructor.
  void add(const Gains& gains, std::span<const TrackingError> errors, std::span<Twist> command) noexcept;

  /// One error b (x, y or theta) of all robots and, for tanh, exp(2 c b) and exp(2 c b) - 1, each to its last digit.
  struct Error {
    std::vector<double> b, exp, expm1;
  };

  // Working arrays of the loops, one entry per robot.
  Error x, y, theta;
  std::vector<double> sin, sinc;           // of the heading errors
  std::vector<double> v, omega;            // the sums
  std::vector<double> term_v, term_omega;  // contribution of robot j to robot i, for one i

 private:
  Instructions instructions_;
};

}  // namespace skein::core
