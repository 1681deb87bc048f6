#pragma once

#include <cstddef>
#include <span>
#include <vector>

#include "core/control/gains.h"
#include "core/control/tracking_error.h"

namespace skein::core {

/// Which of the processor's instructions the loops over pairs use. The results are the same, bit for bit: every pair
/// and every partial sum has its operations and their order fixed, only how many are done at once differs.
enum class Instructions { baseline, avx2 };
/// The widest that this machine has.
Instructions best_instructions() noexcept;

/// The coupling sums of (15a, b) for big groups, without a transcendental function per pair: with c the same for all
/// pairs, tanh(a - b) comes from one exponential a robot (the addition formula). Allocates in its constructor only.
class LawPairs {
 public:
  explicit LawPairs(std::size_t robots, Instructions instructions = best_instructions());

  /// Whether these gains and errors suit it: (11b) needs uniform c and |c e| so small that no digit that counts is
  /// lost.
  bool suit(const Gains& gains, std::span<const TrackingError> errors) const noexcept;
  /// Adds the sums to the commands. Requires `suit`, and at most as many robots as the constructor was told.
  void add(const Gains& gains, std::span<const TrackingError> errors, std::span<Twist> command) noexcept;

  /// One error b (x, y or theta) of all robots and, for tanh, exp(2 c b) and exp(2 c b) - 1, each to its last digit.
  struct Error {
    std::vector<double> b, exp, expm1;
  };

  // What the loops work on, one entry a robot.
  Error x, y, theta;
  std::vector<double> sin, sinc;           // of the heading errors
  std::vector<double> v, omega;            // the sums
  std::vector<double> term_v, term_omega;  // what robot j gives robot i, for one i

 private:
  Instructions instructions_;
};

}  // namespace skein::core
