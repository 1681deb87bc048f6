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

/// Rows of any size, and columns so far apart that not every two rows have room beside each other.
RC_GTEST_PROP(Assignment, ThatFitsIsTheCheapestOfAllPermutationsThatFit, ()) {
  const auto n = static_cast<std::size_t>(*rc::gen::inRange(1, 7));
  Eigen::MatrixXd cost = any_cost(static_cast<Eigen::Index>(n));
  for (Eigen::Index i = 0; i < cost.size(); ++i)
    if (*rc::gen::inRange(0, 8) == 0) cost(i) = std::numeric_limits<double>::infinity();
  std::vector<int> size, column;
  for (std::size_t i = 0; i < n; ++i) size.push_back(*rc::gen::inRange(1, 5));
  for (std::size_t i = 0; i < n; ++i) column.push_back(*rc::gen::inRange(0, 20));
  const Fitting fitting{[&](std::size_t i, std::size_t a, std::size_t j, std::size_t b) {
                          return std::abs(column[a] - column[b]) >= size[i] + size[j] - 2;
                        },
                        [&](std::size_t k, std::size_t i) { return size[k] >= size[i]; }};
  const auto taken = cheapest_fitting_assignment(cost, fitting, 100000);
  const auto fits = [&](const std::vector<std::size_t>& order) {
    for (std::size_t i = 0; i < n; ++i)
      for (std::size_t j = 0; j < i; ++j)
        if (!fitting.both(i, order[i], j, order[j])) return false;
    return true;
  };
  std::vector<std::size_t> order(n);
  std::iota(order.begin(), order.end(), std::size_t{0});
  double cheapest = std::numeric_limits<double>::infinity();
  do
    if (fits(order)) cheapest = std::min(cheapest, sum(cost, order));
  while (std::next_permutation(order.begin(), order.end()));
  if (std::isinf(cheapest)) {
    RC_ASSERT(taken.empty());
    return;
  }
  RC_ASSERT(taken.size() == n);
  RC_ASSERT(fits(taken));
  RC_ASSERT(std::abs(sum(cost, taken) - cheapest) < 1e-9);
}

}  // namespace
}  // namespace skein::core
