// (36) as it is printed, for the four robots of section V, against the general law with the gains that claim to be it.
#include <array>
#include <cmath>

#include "core/control/coordination_law.h"
#include "draw.h"
#include "tests/property.h"

namespace skein::test {
namespace {

using core::TrackingError;
using core::Twist;

struct Printed {
  double v, omega;
  double size;  // the largest number on the way, for the tolerance
};

/// (36a, b), the sums over j = 1..4 with j = i in them, where tanh(0) = 0. In (36b) k_y = 11, k = 200.
Printed printed_36(const std::array<TrackingError, 4>& e, const std::array<Twist, 4>& ref, std::size_t i) {
  const double v_max = 0.1, omega_max = 1.7;
  const double k_xx = 0.008, k_tt = 0.025, k_yy = 0.08;

  double sum_x = 0.0;
  for (std::size_t j = 0; j < 4; ++j)
    sum_x += 100 * e[j].x * std::tanh(1.5 * (e[i].x - e[j].x)) / std::sqrt(1 + std::pow(100 * e[i].x * e[j].x, 2));
  const double v =
      ref[i].v * std::cos(e[i].theta) + (v_max - std::abs(ref[i].v) - 3 * k_xx) * std::tanh(20 * e[i].x) + k_xx * sum_x;

  double squares = 0.0, sum_tt = 0.0, sum_yy = 0.0;
  for (std::size_t j = 0; j < 4; ++j) {
    squares += e[j].x * e[j].x + e[j].y * e[j].y;
    sum_tt += 100 * e[j].theta * std::tanh(0.04 * (e[i].theta - e[j].theta)) /
              std::sqrt(1 + std::pow(100 * e[i].theta * e[j].theta, 2));
    sum_yy += std::tanh(1.5 * (e[i].y - e[j].y)) * std::sin(e[i].theta) / e[i].theta * std::sin(e[j].theta);
  }
  const double omega =
      ref[i].omega +
      11 * ref[i].v * 200 * e[i].y / std::sqrt(1 + 200 * 200 * squares) * std::sin(e[i].theta) / e[i].theta +
      (omega_max - std::abs(ref[i].omega) - 11 * std::abs(ref[i].v) - 3 * k_tt - 3 * k_yy) * std::tanh(e[i].theta) +
      k_tt * sum_tt + k_yy * sum_yy;
  return {v, omega, std::max({1.0, std::abs(k_xx * sum_x), std::abs(k_tt * sum_tt)})};
}

TEST(Paper36, IsTheLawWithPaperGains) {
  holds("(36) is coordination_law with paper_gains and all authority", [] {
    Draw draw(any_seed());
    std::array<TrackingError, 4> errors;
    std::array<Twist, 4> reference, command;
    for (std::size_t i = 0; i < 4; ++i) {
      errors[i] = {draw.between(-1.0, 1.0), draw.between(-1.0, 1.0), draw.angle()};
      if (draw.chance(0.3)) errors[i].x = draw.sign() * draw.decades(-6.0, -1.0);
      if (draw.chance(0.3)) errors[i].theta = draw.sign() * draw.decades(-6.0, -1.0);
      reference[i] = {draw.between(0.0, 0.07), draw.between(-0.5, 0.5)};
    }
    core::Gains gains = core::paper_gains(4);
    core::use_all_authority(gains, reference);
    core::coordination_law(gains, errors, reference, command);
    for (std::size_t i = 0; i < 4; ++i) {
      const Printed printed = printed_36(errors, reference, i);
      RC_ASSERT(std::abs(command[i].v - printed.v) <= 1e-14 * printed.size);
      RC_ASSERT(std::abs(command[i].omega - printed.omega) <= 1e-14 * printed.size);
    }
  });
}

TEST(Paper36, SettlesAtTheReference) {
  const core::Gains gains = core::paper_gains(4);
  const std::array<TrackingError, 4> errors{};
  const std::array<Twist, 4> reference{{{0.05, 0.0}, {0.05, 0.42}, {0.0, 0.0}, {0.03, -0.2}}};
  std::array<Twist, 4> command;
  core::coordination_law(gains, errors, reference, command);
  for (std::size_t i = 0; i < 4; ++i) EXPECT_EQ(command[i], reference[i]);
}

TEST(Paper36, TracksFirstAndCouplesSecond) {
  // Signs a person can check: a reference ahead asks for more speed, one to the left or turned left asks for a left
  // turn.
  core::Gains gains = core::paper_gains(1);
  const std::array<Twist, 1> reference{{{0.05, 0.0}}};
  core::use_all_authority(gains, reference);
  std::array<Twist, 1> command;
  const auto law = [&](TrackingError e) {
    core::coordination_law(gains, std::array{e}, reference, command);
    return command[0];
  };
  EXPECT_GT(law({0.1, 0.0, 0.0}).v, 0.05);
  EXPECT_LT(law({-0.1, 0.0, 0.0}).v, 0.05);
  EXPECT_GT(law({0.0, 0.1, 0.0}).omega, 0.0);
  EXPECT_LT(law({0.0, -0.1, 0.0}).omega, 0.0);
  EXPECT_GT(law({0.0, 0.0, 0.1}).omega, 0.0);
  EXPECT_LT(law({0.0, 0.0, -0.1}).omega, 0.0);
}

}  // namespace
}  // namespace skein::test
