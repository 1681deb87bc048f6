#pragma once

#include <memory>
#include <vector>

#include "core/avoidance/avoidance.h"
#include "core/control/gains.h"

namespace skein::test {

/// A group of robots, their nominal references and the avoidance between them, at 25 Hz with the gains of (36).
struct Encounter {
  explicit Encounter(std::size_t robots)
      : n(robots),
        gains(core::paper_gains(robots)),
        avoidance(robots, 100),
        poses(robots),
        twists_before(robots),
        held(std::make_unique<bool[]>(robots)),
        nominal(robots),
        reference(robots) {}

  void step() {
    const core::Scene scene{poses, twists_before, {held.get(), n}, obstacles};
    avoidance.step(parameters, gains, dt, scene, nominal, reference);
  }
  std::vector<core::Twist> twists() const {
    std::vector<core::Twist> all;
    for (const auto& point : reference) all.push_back(point.twist);
    return all;
  }

  std::size_t n;
  double dt = 0.04;
  core::AvoidanceParameters parameters;
  core::Gains gains;
  core::Avoidance avoidance;
  std::vector<core::Pose> poses;
  std::vector<core::Twist> twists_before;  // what each was told last
  std::unique_ptr<bool[]> held;            // whom the shield has held up
  std::vector<core::Obstacle> obstacles;
  std::vector<core::ReferencePoint> nominal, reference;
};

}  // namespace skein::test
