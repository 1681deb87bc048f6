#include "core/planning/assignment.h"

#include <cmath>
#include <limits>
#include <optional>
#include <set>
#include <utility>

namespace skein::core {

std::vector<std::size_t> cheapest_assignment(const Eigen::MatrixXd& cost) {
  const auto n = static_cast<std::size_t>(cost.rows());
  constexpr double infinite = std::numeric_limits<double>::infinity();
  // Row and column n are the root that each augmenting path begins at.
  std::vector<double> price_of_row(n, 0.0), price_of_column(n + 1, 0.0);
  std::vector<std::size_t> row_of(n + 1, n), before(n + 1, n);
  const auto reduced = [&](std::size_t row, std::size_t column) {
    return cost(static_cast<Eigen::Index>(row), static_cast<Eigen::Index>(column)) - price_of_row[row] -
           price_of_column[column];
  };
  for (std::size_t row = 0; row < n; ++row) {
    std::vector<double> distance(n, infinite);
    std::vector<bool> reached(n + 1, false);
    row_of[n] = row;
    std::size_t column = n;
    do {  // Dijkstra's, over the reduced costs, to the nearest column that no row has
      reached[column] = true;
      double nearest = infinite;
      std::size_t next = n;
      for (std::size_t k = 0; k < n; ++k) {
        if (reached[k]) continue;
        if (const double d = reduced(row_of[column], k); d < distance[k]) {
          distance[k] = d;
          before[k] = column;
        }
        if (distance[k] < nearest) {
          nearest = distance[k];
          next = k;
        }
      }
      for (std::size_t k = 0; k <= n; ++k) {
        if (reached[k]) {
          price_of_row[row_of[k]] += nearest;
          price_of_column[k] -= nearest;
        } else {
          distance[k] -= nearest;
        }
      }
      column = next;
    } while (row_of[column] != n);
    for (; column != n; column = before[column]) row_of[column] = row_of[before[column]];
  }
  std::vector<std::size_t> taken(n);
  for (std::size_t k = 0; k < n; ++k) taken[row_of[k]] = k;
  return taken;
}

namespace {

/// Who may not take what, and the cheapest assignment that keeps to it.
struct Barred {
  std::vector<bool> pairs;  // row by row
  std::vector<std::size_t> taken;
  double sum = 0.0;
};

/// False: somebody is left with nothing.
bool assign(const Eigen::MatrixXd& cost, Barred& barred) {
  const auto n = static_cast<std::size_t>(cost.rows());
  const auto is_barred = [&](std::size_t i, std::size_t a) { return barred.pairs[i * n + a]; };
  // Dearer than any assignment that keeps to it.
  double dear = 1.0;
  for (Eigen::Index i = 0; i < cost.rows(); ++i)
    for (Eigen::Index a = 0; a < cost.cols(); ++a)
      if (std::isfinite(cost(i, a))) dear += std::abs(cost(i, a));
  Eigen::MatrixXd open = cost;
  for (std::size_t i = 0; i < n; ++i)
    for (std::size_t a = 0; a < n; ++a)
      if (is_barred(i, a)) open(static_cast<Eigen::Index>(i), static_cast<Eigen::Index>(a)) = dear;
  barred.taken = cheapest_assignment(open);
  barred.sum = 0.0;
  for (std::size_t i = 0; i < n; ++i) {
    if (is_barred(i, barred.taken[i])) return false;
    barred.sum += open(static_cast<Eigen::Index>(i), static_cast<Eigen::Index>(barred.taken[i]));
  }
  return true;
}

/// Two rows that do not fit together.
std::optional<std::pair<std::size_t, std::size_t>> misfit(const std::vector<std::size_t>& taken,
                                                          const Fitting& fitting) {
  for (std::size_t j = 0; j < taken.size(); ++j)
    for (std::size_t i = 0; i < j; ++i)
      if (!fitting.both(i, taken[i], j, taken[j])) return std::pair{i, j};
  return {};
}

}  // namespace

std::vector<std::size_t> cheapest_fitting_assignment(const Eigen::MatrixXd& cost, const Fitting& fitting,
                                                     std::size_t most_trials) {
  const auto n = static_cast<std::size_t>(cost.rows());
  std::vector<Barred> known;
  std::set<std::vector<bool>> tried;
  using Entry = std::pair<double, std::size_t>;  // the sum, and which of those known
  std::set<Entry> open;
  const auto attempt = [&](std::vector<bool> pairs) {
    if (tried.size() == most_trials || !tried.insert(pairs).second) return;
    Barred next{std::move(pairs), {}};
    if (!assign(cost, next)) return;
    open.emplace(next.sum, known.size());
    known.push_back(std::move(next));
  };
  std::vector<bool> first(n * n);
  for (std::size_t i = 0; i < n; ++i)
    for (std::size_t a = 0; a < n; ++a)
      first[i * n + a] = !std::isfinite(cost(static_cast<Eigen::Index>(i), static_cast<Eigen::Index>(a)));
  attempt(std::move(first));
  while (!open.empty()) {
    const std::size_t cheapest = open.begin()->second;
    open.erase(open.begin());
    std::vector<std::size_t> taken = known[cheapest].taken;
    const auto together = misfit(taken, fitting);
    if (!together) return taken;
    for (const std::size_t i : {together->first, together->second}) {
      std::vector<bool> pairs = known[cheapest].pairs;
      for (std::size_t k = 0; k < n; ++k)
        if (k == i || fitting.needs_no_less(k, i)) pairs[k * n + taken[i]] = true;
      attempt(std::move(pairs));
    }
  }
  return {};
}

}  // namespace skein::core
