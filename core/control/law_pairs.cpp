#include "core/control/law_pairs.h"

#include <algorithm>
#include <cmath>

#include "core/kinematics/unicycle.h"
#include "core/math/elementary.h"

// The loops are compiled for more than one processor and chosen at run time. This file is compiled with -O3 and without
// errno and floating-point traps, which would keep the compiler from doing several pairs at once; neither changes a
// bit.
#define SKEIN_INLINE [[gnu::always_inline]] inline

namespace skein::core {
namespace {

/// Largest |c b| for the addition formula. Its error, in units of the gain, is a rounding (1e-16) times |c b|: 3e-14 at
/// most. And exp(2 c b) times any other factor stays a number.
constexpr double largest_argument = 150.0;

/// A value for every pair: one for all, or the row of robot i.
template <bool uniform>
class Row {
 public:
  SKEIN_INLINE Row(const PairTable& table, std::size_t i) noexcept : row_(table.row(i)) {}
  SKEIN_INLINE double operator[](std::size_t k) const noexcept { return uniform ? row_[0] : row_[k]; }

 private:
  const double* row_;
};

struct Fraction {
  double above, below;
};

/// phi_1(c(b_i - b_j)) of (11) as a fraction, so that it can share its division.
/// (11b): (exp 2cb_i - exp 2cb_j) / (exp 2cb_i + exp 2cb_j). Where both are near 1 the difference is that of the expm1,
/// which keeps the digits of small errors; where both are below 1/2 these are all near -1, and exp has the digits.
template <Saturation saturation>
SKEIN_INLINE Fraction phi(double c, double b_i, double b_j, double exp_i, double exp_j, double expm1_i,
                          double expm1_j) noexcept {
  if constexpr (saturation == Saturation::tanh) {
    const double sum = exp_i + exp_j;
    return {sum < 1.0 ? exp_i - exp_j : expm1_i - expm1_j, sum};
  } else {
    static_assert(saturation == Saturation::algebraic);
    const double a = c * (b_i - b_j);
    return {a, std::sqrt(1.0 + a * a)};
  }
}

/// The weight of the xx and theta-theta couplings without its b_j.
template <Coupling coupling>
SKEIN_INLINE Fraction weight(double l, double b_i, double b_j) noexcept {
  if constexpr (coupling == Coupling::paper) {
    const double product = l * b_i * b_j;
    return {l, std::sqrt(1.0 + product * product)};
  } else {
    static_assert(coupling == Coupling::bounded);
    return {std::sqrt(l), std::sqrt((1.0 + l * b_i * b_i) * (1.0 + l * b_j * b_j))};
  }
}

/// Eight sums side by side, then these: an order that does not depend on how many additions a processor does at once.
SKEIN_INLINE double sum_of(const double* terms, std::size_t count) noexcept {
  constexpr std::size_t lanes = 8;
  double sums[lanes] = {};
  std::size_t k = 0;
  for (; k + lanes <= count; k += lanes)
    for (std::size_t lane = 0; lane < lanes; ++lane) sums[lane] += terms[k + lane];
  double rest = 0.0;
  for (; k < count; ++k) rest += terms[k];
  return ((sums[0] + sums[1]) + (sums[2] + sums[3])) + ((sums[4] + sums[5]) + (sums[6] + sums[7])) + rest;
}

/// Robot i with all robots behind it, each pair once: phi is odd, so that what j gives to i, i takes from j.
template <Saturation saturation, Coupling coupling, bool uniform>
SKEIN_INLINE void add_row(const Gains& gains, LawPairs& pairs, std::size_t i, std::size_t robots) noexcept {
  const Row<uniform> k_xx(gains.k_xx, i), k_tt(gains.k_tt, i), k_yy(gains.k_yy, i);
  const Row<uniform> c_xx(gains.c_xx, i), c_tt(gains.c_tt, i), c_yy(gains.c_yy, i);
  const Row<uniform> l_xx(gains.l_xx, i), l_tt(gains.l_tt, i);
  const double *const x = pairs.x.b.data() + i, *const x_exp = pairs.x.exp.data() + i,
                      *const x_expm1 = pairs.x.expm1.data() + i;
  const double *const y = pairs.y.b.data() + i, *const y_exp = pairs.y.exp.data() + i,
                      *const y_expm1 = pairs.y.expm1.data() + i;
  const double *const theta = pairs.theta.b.data() + i, *const theta_exp = pairs.theta.exp.data() + i,
                      *const theta_expm1 = pairs.theta.expm1.data() + i;
  const double *const sin = pairs.sin.data() + i, *const sinc = pairs.sinc.data() + i;
  double *const v = pairs.v.data() + i, *const omega = pairs.omega.data() + i;
  double *const term_v = pairs.term_v.data(), *const term_omega = pairs.term_omega.data();
  const std::size_t partners = robots - i - 1;

#ifdef __clang__
#pragma clang loop vectorize(assume_safety)
#else
#pragma GCC ivdep
#endif
  for (std::size_t p = 0; p < partners; ++p) {
    const std::size_t j = p + 1;
    const Fraction x_phi = phi<saturation>(c_xx[p], x[0], x[j], x_exp[0], x_exp[j], x_expm1[0], x_expm1[j]);
    const Fraction x_weight = weight<coupling>(l_xx[p], x[0], x[j]);
    const double xx = k_xx[p] * x_weight.above * x_phi.above / (x_phi.below * x_weight.below);
    const Fraction theta_phi =
        phi<saturation>(c_tt[p], theta[0], theta[j], theta_exp[0], theta_exp[j], theta_expm1[0], theta_expm1[j]);
    const Fraction theta_weight = weight<coupling>(l_tt[p], theta[0], theta[j]);
    const double tt = k_tt[p] * theta_weight.above * theta_phi.above / (theta_phi.below * theta_weight.below);
    const Fraction y_phi = phi<saturation>(c_yy[p], y[0], y[j], y_exp[0], y_exp[j], y_expm1[0], y_expm1[j]);
    const double yy = k_yy[p] * y_phi.above / y_phi.below;
    term_v[p] = x[j] * xx;
    v[j] -= x[0] * xx;
    term_omega[p] = theta[j] * tt + yy * (sinc[0] * sin[j]);
    omega[j] -= theta[0] * tt + yy * (sinc[j] * sin[0]);
  }
  v[0] += sum_of(term_v, partners);
  omega[0] += sum_of(term_omega, partners);
}

template <Saturation saturation, Coupling coupling>
SKEIN_INLINE void add_rows(const Gains& gains, LawPairs& pairs, std::size_t robots, bool uniform) noexcept {
  for (std::size_t i = 0; i + 1 < robots; ++i)
    uniform ? add_row<saturation, coupling, true>(gains, pairs, i, robots)
            : add_row<saturation, coupling, false>(gains, pairs, i, robots);
}

template <Saturation saturation>
SKEIN_INLINE void add_coupled_rows(const Gains& gains, LawPairs& pairs, std::size_t robots, bool uniform) noexcept {
  switch (gains.coupling) {
    case Coupling::paper:
      return add_rows<saturation, Coupling::paper>(gains, pairs, robots, uniform);
    case Coupling::bounded:
      return add_rows<saturation, Coupling::bounded>(gains, pairs, robots, uniform);
  }
}

SKEIN_INLINE void add_all(const Gains& gains, LawPairs& pairs, std::size_t robots) noexcept {
  bool uniform = true;
  for (const PairTable* table :
       {&gains.k_xx, &gains.k_tt, &gains.k_yy, &gains.c_xx, &gains.c_tt, &gains.c_yy, &gains.l_xx, &gains.l_tt})
    uniform = uniform && table->uniform();
  switch (gains.saturation) {
    case Saturation::tanh:
      return add_coupled_rows<Saturation::tanh>(gains, pairs, robots, uniform);
    case Saturation::algebraic:
      return add_coupled_rows<Saturation::algebraic>(gains, pairs, robots, uniform);
  }
}

void add_all_baseline(const Gains& gains, LawPairs& pairs, std::size_t robots) noexcept {
  add_all(gains, pairs, robots);
}

#if defined(__x86_64__)
[[gnu::target("avx2")]] void add_all_avx2(const Gains& gains, LawPairs& pairs, std::size_t robots) noexcept {
  add_all(gains, pairs, robots);
}
#endif

/// exp(2 c b) and exp(2 c b) - 1, each from the one that has its digits.
void exponentials(LawPairs::Error& error, double c, std::size_t robots) noexcept {
  for (std::size_t i = 0; i < robots; ++i) {
    const double twice = 2.0 * c * error.b[i];
    if (twice > -0.5) {
      error.expm1[i] = math::expm1(twice);
      error.exp[i] = error.expm1[i] + 1.0;
    } else {
      error.exp[i] = math::exp(twice);
      error.expm1[i] = error.exp[i] - 1.0;
    }
  }
}

}  // namespace

Instructions best_instructions() noexcept {
#if defined(__x86_64__)
  if (__builtin_cpu_supports("avx2")) return Instructions::avx2;
#endif
  return Instructions::baseline;
}

LawPairs::LawPairs(std::size_t robots, Instructions instructions) : instructions_(instructions) {
  for (Error* error : {&x, &y, &theta})
    for (std::vector<double>* values : {&error->b, &error->exp, &error->expm1}) values->resize(robots);
  for (std::vector<double>* values : {&sin, &sinc, &v, &omega, &term_v, &term_omega}) values->resize(robots);
}

bool LawPairs::suit(const Gains& gains, std::span<const TrackingError> errors) const noexcept {
  if (errors.size() < 2 || errors.size() > v.size()) return false;
  switch (gains.saturation) {
    case Saturation::algebraic:
      return true;
    case Saturation::tanh:
      break;
  }
  if (!gains.c_xx.uniform() || !gains.c_tt.uniform() || !gains.c_yy.uniform()) return false;
  const double c_xx = gains.c_xx(0, 1), c_tt = gains.c_tt(0, 1), c_yy = gains.c_yy(0, 1);
  return std::all_of(errors.begin(), errors.end(), [&](const TrackingError& e) {
    return std::abs(c_xx * e.x) <= largest_argument && std::abs(c_tt * e.theta) <= largest_argument &&
           std::abs(c_yy * e.y) <= largest_argument;
  });
}

void LawPairs::add(const Gains& gains, std::span<const TrackingError> errors, std::span<Twist> command) noexcept {
  const std::size_t robots = errors.size();
  for (std::size_t i = 0; i < robots; ++i) {
    x.b[i] = errors[i].x;
    y.b[i] = errors[i].y;
    theta.b[i] = errors[i].theta;
    sin[i] = math::sin(errors[i].theta);
    sinc[i] = core::sinc(errors[i].theta);
    v[i] = omega[i] = 0.0;
  }
  switch (gains.saturation) {
    case Saturation::tanh:
      exponentials(x, gains.c_xx(0, 1), robots);
      exponentials(theta, gains.c_tt(0, 1), robots);
      exponentials(y, gains.c_yy(0, 1), robots);
      break;
    case Saturation::algebraic:
      break;
  }
#if defined(__x86_64__)
  switch (instructions_) {
    case Instructions::avx2:
      add_all_avx2(gains, *this, robots);
      break;
    case Instructions::baseline:
      add_all_baseline(gains, *this, robots);
      break;
  }
#else
  add_all_baseline(gains, *this, robots);
#endif
  for (std::size_t i = 0; i < robots; ++i) {
    command[i].v += v[i];
    command[i].omega += omega[i];
  }
}

}  // namespace skein::core
