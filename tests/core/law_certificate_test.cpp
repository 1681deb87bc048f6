// The Lyapunov certificate of Theorem 1: what the law does to (19) is exactly (20), for any group and any gains that
// satisfy (18).
#include <algorithm>

#include "core/control/coordination_law.h"
#include "core/control/lyapunov.h"
#include "literal_law.h"
#include "tests/property.h"

namespace skein::test {
namespace {

using core::Coupling;
using core::TrackingError;
using core::Twist;

std::vector<Twist> commands_of(const Group& group) {
  std::vector<Twist> command(group.robots());
  core::coordination_law(group.gains, group.errors, group.reference, command);
  return command;
}

/// dV/dt from the gradient of (19) and the error dynamics (5), written here once more. `size` sums every product's
/// absolute value, with v and omega taken apart into the terms of (15): cancellation between any of them costs digits.
Literal rate_through_gradient(const Group& group, const std::vector<Twist>& command) {
  const double to_error = group.gains.k_y * group.gains.k / literal_normaliser(group);  // dV/de = to_error * e
  Literal rate;
  for (std::size_t i = 0; i < group.robots(); ++i) {
    const TrackingError& e = group.errors[i];
    const Twist& r = group.reference[i];
    const double v = command[i].v, omega = command[i].omega;
    rate.value +=
        to_error * (e.x * (omega * e.y + r.v * std::cos(e.theta) - v) + e.y * (-omega * e.x + r.v * std::sin(e.theta)));
    rate.value += e.theta * (r.omega - omega);
    const double size_v = literal_v(group, i).size, size_omega = literal_omega(group, i).size;
    rate.size += to_error * (std::abs(e.x) * (std::abs(r.v * std::cos(e.theta)) + size_v) +
                             2.0 * std::abs(e.x * e.y) * size_omega + std::abs(e.y * r.v * std::sin(e.theta)));
    rate.size += std::abs(e.theta) * (std::abs(r.omega) + size_omega);
  }
  return rate;
}

/// (20), written here once more.
double rate_of_paper(const Group& group) {
  const auto& g = group.gains;
  double rate = 0.0;
  for (std::size_t i = 0; i < group.robots(); ++i) {
    const TrackingError& e = group.errors[i];
    rate -= g.k_y * g.k * e.x * literal_phi(g.saturation, g.k_x[i], g.c_x[i] * e.x) / literal_normaliser(group);
    rate -= e.theta * literal_phi(g.saturation, g.k_theta[i], g.c_theta[i] * e.theta);
  }
  return rate;
}

TEST(Certificate, TheDrawnGainsSatisfy18) {
  holds("the generator's gains are admissible", [] {
    const int n = any_of(1, 12);
    Draw draw(any_seed());
    const Group group = random_group(draw, static_cast<std::size_t>(n));
    for (std::size_t i = 0; i < group.robots(); ++i)
      RC_ASSERT(core::margins(group.gains, i, group.reference[i]).hold());
  });
}

TEST(Certificate, TheLawIs15TermByTerm) {
  holds("coordination_law is (15)", [] {
    const int n = any_of(1, 12);
    Draw draw(any_seed());
    const Group group = random_group(draw, static_cast<std::size_t>(n));
    const std::vector<Twist> command = commands_of(group);
    for (std::size_t i = 0; i < group.robots(); ++i) {
      const Literal v = literal_v(group, i), omega = literal_omega(group, i);
      // A few dozen terms of a few roundings each.
      RC_ASSERT(std::abs(command[i].v - v.value) <= 1e-14 * v.size);
      RC_ASSERT(std::abs(command[i].omega - omega.value) <= 1e-14 * omega.size);
    }
  });
}

TEST(Certificate, TheRateOfVIs20) {
  holds("dV/dt through the gradient of (19) and (5) is (20), and never positive", [] {
    const int n = any_of(1, 12);
    Draw draw(any_seed());
    const Group group = random_group(draw, static_cast<std::size_t>(n));
    const std::vector<Twist> command = commands_of(group);
    const Literal rate = rate_through_gradient(group, command);
    const double paper = rate_of_paper(group);
    const double tolerance = 1e-12 * rate.size;
    RC_ASSERT(std::abs(rate.value - paper) <= tolerance);
    RC_ASSERT(paper <= 0.0);
    RC_ASSERT(rate.value <= tolerance);
    // Core's own versions, which the recorder and the window show.
    RC_ASSERT(std::abs(core::lyapunov_rate(group.gains, group.errors) - paper) <= 1e-13 * std::abs(paper));
    RC_ASSERT(std::abs(core::lyapunov_rate(group.gains, group.errors, group.reference, command) - rate.value) <=
              tolerance);
  });
}

TEST(Certificate, AWrongLawFailsIt) {
  // The comparison above must be able to fail: with the sign of one coupling term turned round it does, wherever that
  // term is worth more than a billionth of the sum.
  int worth_it = 0;
  Draw draw(1);
  for (int k = 0; k < 1000; ++k) {
    const Group group = random_group(draw, 4);
    std::vector<Twist> command = commands_of(group);
    const auto& e = group.errors;
    const double term =
        literal_phi(group.gains.saturation, group.gains.k_yy(0, 1), group.gains.c_yy(0, 1) * (e[0].y - e[1].y)) *
        literal_sinc(e[0].theta) * std::sin(e[1].theta);
    command[0].omega -= 2.0 * term;
    const Literal rate = rate_through_gradient(group, command);
    if (std::abs(e[0].theta * term) < 1e-9 * rate.size) continue;
    ++worth_it;
    EXPECT_GT(std::abs(rate.value - rate_of_paper(group)), 1e-12 * rate.size);
  }
  EXPECT_GT(worth_it, 300);
}

TEST(Certificate, TheCouplingSumsVanish) {
  holds("A_x, A_theta (21) and A_y (22) are zero", [] {
    const int n = any_of(1, 12);
    Draw draw(any_seed());
    const Group group = random_group(draw, static_cast<std::size_t>(n));
    const auto& g = group.gains;
    const auto& e = group.errors;
    // The sizes of the sums' terms, and the sums once more from (15)'s own terms.
    Literal x, theta, y;
    for (std::size_t i = 0; i < group.robots(); ++i)
      for (std::size_t j = 0; j < group.robots(); ++j) {
        if (i == j) continue;
        x.add(e[i].x * literal_weight(g.coupling, g.l_xx(i, j), e[i].x, e[j].x) *
              literal_phi(g.saturation, g.k_xx(i, j), g.c_xx(i, j) * (e[i].x - e[j].x)));
        theta.add(e[i].theta * literal_weight(g.coupling, g.l_tt(i, j), e[i].theta, e[j].theta) *
                  literal_phi(g.saturation, g.k_tt(i, j), g.c_tt(i, j) * (e[i].theta - e[j].theta)));
        y.add(literal_phi(g.saturation, g.k_yy(i, j), g.c_yy(i, j) * (e[i].y - e[j].y)) * std::sin(e[i].theta) *
              std::sin(e[j].theta));
      }
    const core::CouplingSums sums = core::coupling_sums(g, e);
    for (const auto& [sum, literal] : {std::pair{sums.x, x}, {sums.theta, theta}, {sums.y, y}}) {
      RC_ASSERT(std::abs(sum) <= 1e-14 * literal.size);
      RC_ASSERT(std::abs(literal.value) <= 1e-14 * literal.size);
    }
  });
}

TEST(Lyapunov, Is19) {
  holds("V is (19), to its last digits also near zero", [] {
    const int n = any_of(1, 12);
    Draw draw(any_seed());
    const Group group = random_group(draw, static_cast<std::size_t>(n));
    // (19) as printed loses digits where errors are small; long double has three more to lose.
    long double e_e = 0.0L, theta_theta = 0.0L;
    for (const auto& e : group.errors) {
      e_e += static_cast<long double>(e.x) * e.x + static_cast<long double>(e.y) * e.y;
      theta_theta += static_cast<long double>(e.theta) * e.theta;
    }
    const long double k = group.gains.k, k_y = group.gains.k_y;
    const long double v = k_y / k * std::sqrt(1.0L + k * k * e_e) + 0.5L * theta_theta - k_y / k;
    const double lost = 1e-18 * group.gains.k_y / group.gains.k;
    const double core_v = core::lyapunov(group.gains, group.errors);
    RC_ASSERT(core_v >= 0.0);
    RC_ASSERT(std::abs(core_v - static_cast<double>(v)) <= 1e-14 * static_cast<double>(v) + lost);
  });
}

TEST(Lyapunov, IsZeroOnlyAtZeroErrors) {
  const core::Gains gains = core::paper_gains(3);
  std::vector<TrackingError> errors(3);
  EXPECT_EQ(core::lyapunov(gains, errors), 0.0);
  EXPECT_EQ(core::lyapunov_rate(gains, errors), 0.0);
  for (double TrackingError::*part : {&TrackingError::x, &TrackingError::y, &TrackingError::theta}) {
    errors[1].*part = 1e-9;
    EXPECT_GT(core::lyapunov(gains, errors), 0.0);
    errors[1].*part = 0.0;
  }
}

}  // namespace
}  // namespace skein::test
