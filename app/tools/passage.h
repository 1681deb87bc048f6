#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include <tl/expected.hpp>

#include "app/experiment/experiment.h"

namespace skein::app {

/// Scenes with walls, which are rows of round obstacles, anywhere in the arena and in any direction.
enum class PassageKind {
  corridor,  ///< a robot on one side of a block that fills the arena, its place on the other; one way leads through
  head_on,   ///< the same with robots on both sides, which change sides
  dead_end,  ///< a robot in a U, its place behind the U's end
  door,      ///< a wall across the arena with one door; robots on both sides change sides
};

/// As files call it (core/words.h).
constexpr std::string_view word(PassageKind kind) noexcept {
  switch (kind) {
    case PassageKind::corridor:
      return "corridor";
    case PassageKind::head_on:
      return "head_on";
    case PassageKind::dead_end:
      return "dead_end";
    case PassageKind::door:
      return "door";
  }
  return {};
}

struct Passage {
  PassageKind kind = PassageKind::corridor;
  std::array<double, 2> width{1.25, 3.0};    ///< between the walls, in diameters of a robot
  std::array<double, 2> length{0.2, 0.8};    ///< of a corridor or a U [m]
  std::array<std::int64_t, 2> robots{2, 4};  ///< of head_on and door, half of them on each side
  double clearance = 0.12;                   ///< between two starts, two places, and from both to any wall [m]
};

/// The robots and obstacles of such a scene in the experiment's arena, as for --set; the same seed draws the same
/// scene. The error: there is no room for it.
tl::expected<std::vector<std::string>, std::string> draw_passage(const Passage& passage, const Experiment& experiment,
                                                                 std::uint64_t seed);

}  // namespace skein::app
