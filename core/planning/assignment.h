#pragma once

#include <cstddef>
#include <vector>

#include <Eigen/Core>

namespace skein::core {

/// Which column each row takes, every column once, so that the sum of the costs is the smallest: the Hungarian method
/// by shortest augmenting paths (`jonker1987`), n^3 steps. `cost` is square and finite. The same on every machine.
std::vector<std::size_t> cheapest_assignment(const Eigen::MatrixXd& cost);

}  // namespace skein::core
