// Whose place is whose: every place once, at the smallest cost.
#include "core/planning/assignment.h"

#include <gtest/gtest.h>
#include <rapidcheck/gtest.h>

#include <algorithm>
#include <limits>
#include <numeric>

namespace skein::core {
namespace {

double sum(const Eigen::MatrixXd& cost, const std::vector<std::size_t>& taken) {
  double sum = 0.0;
  for (std::size_t i = 0; i < taken.size(); ++i)
    sum += cost(static_cast<Eigen::Index>(i), static_cast<Eigen::Index>(taken[i]));
  return sum;
}

Eigen::MatrixXd any_cost(Eigen::Index n) {
  Eigen::MatrixXd cost(n, n);
  for (Eigen::Index i = 0; i < n; ++i)
    for (Eigen::Index j = 0; j < n; ++j) cost(i, j) = *rc::gen::inRange(-50, 50) / 7.0;
  return cost;
}

TEST(Assignment, OfNobodyAndOfOne) {
  EXPECT_TRUE(cheapest_assignment(Eigen::MatrixXd(0, 0)).empty());
  EXPECT_EQ(cheapest_assignment(Eigen::MatrixXd::Constant(1, 1, 3.0)), (std::vector<std::size_t>{0}));
}

RC_GTEST_PROP(Assignment, IsTheCheapestOfAllPermutations, ()) {
  const Eigen::MatrixXd cost = any_cost(*rc::gen::inRange(1, 7));
  const auto taken = cheapest_assignment(cost);
  std::vector<std::size_t> order(static_cast<std::size_t>(cost.rows()));
  std::iota(order.begin(), order.end(), std::size_t{0});
  RC_ASSERT(std::is_permutation(order.begin(), order.end(), taken.begin(), taken.end()));
  double cheapest = std::numeric_limits<double>::infinity();
  do cheapest = std::min(cheapest, sum(cost, order));
  while (std::next_permutation(order.begin(), order.end()));
  RC_ASSERT(std::abs(sum(cost, taken) - cheapest) < 1e-9);
}

RC_GTEST_PROP(Assignment, OfManyIsCheaperThanAnyExchangeOfTwo, ()) {
  const Eigen::MatrixXd cost = any_cost(*rc::gen::inRange(20, 64));
  auto taken = cheapest_assignment(cost);
  const double cheapest = sum(cost, taken);
  for (std::size_t i = 0; i < taken.size(); ++i)
    for (std::size_t j = 0; j < i; ++j) {
      std::swap(taken[i], taken[j]);
      RC_ASSERT(sum(cost, taken) > cheapest - 1e-9);
      std::swap(taken[i], taken[j]);
    }
}

}  // namespace
}  // namespace skein::core
