#pragma once

#include <cstdint>
#include <string_view>

namespace skein::app {

/// Hostile behaviours of a controller.
enum class Adversary : std::uint8_t {
  no_number,    ///< returns NaN, for some robots or for all
  infinite,     ///< returns excessive speeds
  collide,      ///< full speed at the nearest other robot
  walls,        ///< full speed at the nearest edge
  obstacles,    ///< full speed at the nearest obstacle
  erratic,      ///< full speed forward and backward, alternating each tick
  late,         ///< answers after the deadline, now and then or always
  crash,        ///< a signal, abort or exit at some tick
  hang,         ///< never answers again
  stop_itself,  ///< SIGSTOP to itself
  flood,        ///< writes to its pipe and prints as fast as it can
  scribble,     ///< writes over the whole memory that it shares
  allocate,     ///< allocates all available memory
  fork,         ///< starts processes that hold its pipes and do not end
};

/// As a word (core/words.h).
constexpr std::string_view word(Adversary kind) noexcept {
  switch (kind) {
    case Adversary::no_number:
      return "no_number";
    case Adversary::infinite:
      return "infinite";
    case Adversary::collide:
      return "collide";
    case Adversary::walls:
      return "walls";
    case Adversary::obstacles:
      return "obstacles";
    case Adversary::erratic:
      return "erratic";
    case Adversary::late:
      return "late";
    case Adversary::crash:
      return "crash";
    case Adversary::hang:
      return "hang";
    case Adversary::stop_itself:
      return "stop_itself";
    case Adversary::flood:
      return "flood";
    case Adversary::scribble:
      return "scribble";
    case Adversary::allocate:
      return "allocate";
    case Adversary::fork:
      return "fork";
  }
  return {};
}

/// The behaviour for a seed: in turn.
Adversary adversary_of(std::uint64_t seed) noexcept;

/// `skein controller-host --adversary SEED`: a hostile controller, the same for the same seed. For studies. Returns an
/// ExitStatus, if it returns.
int be_adversary(std::uint64_t seed);

/// `skein controller-host --honest`: tracks, and answers at once. For measurements.
int be_honest();

}  // namespace skein::app
