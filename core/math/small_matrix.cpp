#include "core/math/small_matrix.h"

#include <Eigen/LU>

namespace skein::core::math {

SmallMatrix inverse(const SmallMatrix& matrix) {
  return matrix.inverse();
}

}  // namespace skein::core::math
