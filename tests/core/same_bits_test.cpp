#include <gtest/gtest.h>

#include <Eigen/Dense>
#include <cstddef>

#include "core/math/elementary.h"

// A multiplication and an addition that a processor does in one, with one rounding, give other bits than both alone,
// and a record made on one computer could not be verified on another. Here the terms of a sum cancel each other, in
// whatever order: it is 0 if every product was rounded, and the product's error if the last one was not.
namespace skein::core {
namespace {

constexpr double number = 1.0 + 0x1p-30;  // whose square has more digits than a double

/// Rows of number, -number, number, ..., and a last 0 where they would be odd.
template <class Matrix>
Matrix alternating(Eigen::Index rows, Eigen::Index columns) {
  Matrix matrix(rows, columns);
  for (Eigen::Index i = 0; i < rows; ++i)
    for (Eigen::Index j = 0; j < columns; ++j)
      matrix(i, j) = j == columns - columns % 2 ? 0.0 : j % 2 == 0 ? number : -number;
  return matrix;
}

template <int size>
void expect_rounded_products() {
  using Matrix = Eigen::Matrix<double, size, size>;
  using Vector = Eigen::Matrix<double, size, 1>;
  const Matrix left = alternating<Matrix>(size, size), all = Matrix::Constant(number);
  const Vector column = Vector::Constant(number), row = left.row(0).transpose();
  EXPECT_EQ(Matrix(left * all), Matrix::Zero().eval()) << size;
  EXPECT_EQ(Matrix(left.transpose().transpose() * all.transpose()), Matrix::Zero().eval()) << size;
  EXPECT_EQ(Matrix(all.transpose() * left.transpose()), Matrix::Zero().eval()) << size;
  EXPECT_EQ(Vector(left * column), Vector::Zero().eval()) << size;
  EXPECT_EQ(row.dot(column), 0.0) << size;
}

TEST(SameBits, ProductsOfFixedSizeAreRoundedBeforeTheyAreAdded) {
  expect_rounded_products<2>();
  expect_rounded_products<3>();
  expect_rounded_products<4>();
  expect_rounded_products<6>();
}

TEST(SameBits, ProductsOfAnySizeAreRoundedBeforeTheyAreAdded) {
  for (Eigen::Index size = 1; size <= 40; ++size) {
    const auto left = alternating<Eigen::MatrixXd>(size, size);
    const Eigen::MatrixXd all = Eigen::MatrixXd::Constant(size, size, number);
    const Eigen::VectorXd column = Eigen::VectorXd::Constant(size, number);
    EXPECT_TRUE((left * column).isZero(0.0)) << size;
    EXPECT_TRUE((column.transpose() * left.transpose()).isZero(0.0)) << size;
    EXPECT_EQ(left.row(0).dot(column), 0.0) << size;
    if (3 * size < 20) {  // core multiplies no larger ones in a run
      EXPECT_TRUE((left * all).isZero(0.0)) << size;
    }
  }
}

TEST(SameBits, ALoopIsRoundedAsItIsWritten) {
  double sum = 0.0;
  volatile double plus = number, minus = -number;
  for (int k = 0; k < 100; ++k) {
    const double factor = plus, other = minus;
    sum = sum + factor * factor;
    sum = sum + factor * other;
  }
  EXPECT_EQ(sum, 0.0);
}

// A robot that is where it should be has errors of this size at every tick.
TEST(SameBits, TheCosineOfASmallErrorIsThatOfX86) {
  for (int k = 0; k <= 520; ++k) EXPECT_EQ(math::cos(-1e-18 * k), 1.0) << k;
}

}  // namespace
}  // namespace skein::core
