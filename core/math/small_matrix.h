#pragma once

#include <Eigen/Core>

namespace skein::core::math {

/// At most 13 rows and columns, without heap memory. Eigen's decompositions take seconds to compile, for every fixed
/// size anew; for this type they are compiled once, here. They give the same bits as those of a fixed size, as fast.
using SmallMatrix = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::ColMajor, 13, 13>;

/// Of a square matrix, by LU with partial pivoting. For four rows and fewer Eigen has formulas, which compile quickly.
SmallMatrix inverse(const SmallMatrix& matrix);

}  // namespace skein::core::math
