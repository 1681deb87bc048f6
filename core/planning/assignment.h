#pragma once

#include <cstddef>
#include <functional>
#include <vector>

#include <Eigen/Core>

namespace skein::core {

/// Which column each row takes, every column once, so that the sum of the costs is the smallest: the Hungarian method
/// by shortest augmenting paths (`jonker1987`), n^3 steps. `cost` is square and finite. The same on every machine.
std::vector<std::size_t> cheapest_assignment(const Eigen::MatrixXd& cost);

/// What an assignment must keep beside its cost.
struct Fitting {
  /// Whether row i may take column a while row j takes column b.
  std::function<bool(std::size_t i, std::size_t a, std::size_t j, std::size_t b)> both;
  /// Whether row k fits nowhere where row i does not fit either.
  std::function<bool(std::size_t k, std::size_t i)> needs_no_less;
};

/// The cheapest assignment that fits; an infinite cost bars a row from a column. Best first: of two rows that do not
/// fit together, one has to take another column, and so has everybody who needs no less room than it. Empty: nothing
/// fits, or nothing was found with `most_trials` assignments of the kind above.
std::vector<std::size_t> cheapest_fitting_assignment(const Eigen::MatrixXd& cost, const Fitting& fitting,
                                                     std::size_t most_trials);

}  // namespace skein::core
