#pragma once

#include "core/control/coordination_law.h"
#include "core/controllers/controller.h"

namespace skein::core {

/// (15) with the gains of the input. It has no parameters of its own: they are keys of [controller].
class KosticController final : public Controller {
 public:
  explicit KosticController(std::size_t robots) : pairs_(robots) {}
  void step(const ControllerInput& input, std::span<Twist> command, std::span<double>) noexcept override {
    coordination_law(*input.gains, input.errors, input.reference_twists, command, pairs_);
  }

 private:
  LawPairs pairs_;
};

}  // namespace skein::core
