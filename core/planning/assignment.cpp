#include "core/planning/assignment.h"

#include <limits>

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

}  // namespace skein::core
