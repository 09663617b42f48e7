#include "cosiva/base/least_squares.h"

#include <gmock/gmock.h>

#include <algorithm>
#include <cmath>

#include "cosiva/base/math.h"

namespace cosiva {
namespace {

using ::testing::DoubleNear;
using ::testing::ElementsAre;
using ::testing::Pointwise;

Matrix matrix_of(const std::vector<std::vector<double>>& rows) {
  Matrix matrix{rows.size(), rows.front().size()};
  for (std::size_t i = 0; i < rows.size(); ++i)
    for (std::size_t j = 0; j < rows[i].size(); ++j) matrix(i, j) = rows[i][j];
  return matrix;
}

TEST(Matrix, stores_its_columns_one_after_the_other) {
  const Matrix matrix = matrix_of({{1.0, 2.0, 3.0}, {4.0, 5.0, 6.0}});
  EXPECT_EQ(matrix.rows(), 2U);
  EXPECT_EQ(matrix.columns(), 3U);
  EXPECT_THAT(matrix.values(), ElementsAre(1.0, 4.0, 2.0, 5.0, 3.0, 6.0));
}

TEST(Residuals, are_the_product_minus_the_right_side) {
  const std::vector<double> errors =
      residuals(matrix_of({{1.0, 2.0}, {3.0, 4.0}, {5.0, 6.0}}), std::vector{1.0, -1.0}, std::vector{0.0, 1.0, 2.0});
  EXPECT_THAT(errors, ElementsAre(-1.0, -2.0, -3.0));
  EXPECT_EQ(weighted_squares(std::vector{1.0, 0.5, 2.0}, errors), 1.0 + 2.0 + 18.0);
}

// The line through (0, 6), (1, 0), (2, 0) is 5 − 3 t. Source: G. Strang, Introduction to Linear Algebra, section 4.3.
TEST(LeastSquares, draw_the_textbook_line_through_three_points) {
  const Matrix a = matrix_of({{1.0, 0.0}, {1.0, 1.0}, {1.0, 2.0}});
  const std::vector<double> y{6.0, 0.0, 0.0};
  const auto line = least_squares(a, y, 1e-6);
  ASSERT_TRUE(line);
  EXPECT_THAT(*line, ElementsAre(DoubleNear(5.0, 1e-14), DoubleNear(-3.0, 1e-14)));
  EXPECT_THAT(residuals(a, *line, y), Pointwise(DoubleNear(1e-14), {-1.0, 2.0, -1.0}));
}

TEST(LeastSquares, find_nothing_where_columns_depend_on_each_other) {
  EXPECT_FALSE(
      least_squares(matrix_of({{1.0, 2.0}, {2.0, 4.0}, {3.0, 6.0}}), std::vector{1.0, 2.0, 3.0}, 1e-6).has_value());
}

TEST(LeastSquares, solve_each_right_side_alone) {
  // The columns of the right side are the line 1 + 2 t and the constant 3.
  const Matrix found =
      least_squares(matrix_of({{1.0, 0.0}, {1.0, 1.0}, {1.0, 2.0}}), matrix_of({{1.0, 3.0}, {3.0, 3.0}, {5.0, 3.0}}));
  EXPECT_THAT(found.values(), Pointwise(DoubleNear(1e-14), {1.0, 2.0, 3.0, 0.0}));
}

TEST(LeastSquares, without_right_side_find_the_direction_of_the_equations_kernel) {
  // Eight equations x_i = x_(i+1): the kernel is (1, 1, …, 1), of length 3.
  Matrix a{8, 9};
  for (std::size_t i = 0; i < 8; ++i) {
    a(i, i) = 1.0;
    a(i, i + 1) = -1.0;
  }
  const std::array<double, 9> x = homogeneous_least_squares(a);
  for (const double value : x) EXPECT_NEAR(value / x[0], 1.0, 1e-12);
  EXPECT_NEAR(std::fabs(x[0]), 1.0 / 3.0, 1e-12);
}

TEST(NormalEquations, of_weighted_equations_count_a_row_as_often_as_its_weight) {
  const NormalEquations weighted =
      normal_equations(matrix_of({{1.0, 0.0}, {1.0, 1.0}}), std::vector{1.0, 2.0}, std::vector{6.0, 3.0});
  const NormalEquations repeated = normal_equations(matrix_of({{1.0, 0.0}, {1.0, 1.0}, {1.0, 1.0}}),
                                                    std::vector{1.0, 1.0, 1.0}, std::vector{6.0, 3.0, 3.0});
  EXPECT_THAT(weighted.normal.values(), ElementsAre(3.0, 2.0, 2.0, 2.0));
  EXPECT_THAT(weighted.right, ElementsAre(12.0, 6.0));
  EXPECT_THAT(repeated.normal.values(), ElementsAre(3.0, 2.0, 2.0, 2.0));
  EXPECT_THAT(repeated.right, ElementsAre(12.0, 6.0));
}

TEST(NonnegativeLeastSquares, clamp_negative_unknowns_to_zero) {
  const Matrix normal = matrix_of({{2.0, 1.0}, {1.0, 2.0}});
  // Without the bound x = (5/3, −4/3); with it only the first unknown remains: 2 x = 2.
  EXPECT_THAT(nonnegative_least_squares({normal, {2.0, -1.0}}), ElementsAre(DoubleNear(1.0, 1e-12), 0.0));
  EXPECT_THAT(nonnegative_least_squares({normal, {3.0, 3.0}}),
              ElementsAre(DoubleNear(1.0, 1e-12), DoubleNear(1.0, 1e-12)));
  EXPECT_THAT(nonnegative_least_squares({normal, {-1.0, -1.0}}), ElementsAre(0.0, 0.0));
}

// Rosenbrock's valley, whose only minimum is (1, 1). Source: H. Rosenbrock, An automatic method for finding the
// greatest or least value of a function, 1960.
TEST(LevenbergMarquardt, follows_rosenbrocks_valley_to_its_minimum) {
  const auto valley = [](std::span<const double> x, std::span<double> out) {
    out[0] = 10.0 * (x[1] - x[0] * x[0]);
    out[1] = 1.0 - x[0];
  };
  EXPECT_THAT(levenberg_marquardt(std::vector{-1.2, 1.0}, 2, valley),
              ElementsAre(DoubleNear(1.0, 1e-6), DoubleNear(1.0, 1e-6)));
}

TEST(LevenbergMarquardt, fits_a_circle_to_points_on_one) {
  std::vector<std::array<double, 2>> points;
  for (int i = 0; i < 7; ++i) points.push_back({0.5 + 2.0 * det_cos(0.3 * i), -1.0 + 2.0 * det_sin(0.3 * i)});
  const auto off = [&](std::span<const double> x, std::span<double> out) {
    for (std::size_t i = 0; i < points.size(); ++i) out[i] = norm(points[i][0] - x[0], points[i][1] - x[1]) - x[2];
  };
  EXPECT_THAT(levenberg_marquardt(std::vector{0.0, 0.0, 1.0}, points.size(), off),
              ElementsAre(DoubleNear(0.5, 1e-6), DoubleNear(-1.0, 1e-6), DoubleNear(2.0, 1e-6)));
}

TEST(LevenbergMarquardt, takes_no_step_to_where_a_residual_is_not_a_number) {
  // From 0.5 the undamped step on 2 / x = 20 leads to −1.5, where the root is not a number.
  const auto fraction = [](std::span<const double> x, std::span<double> out) {
    out[0] = 2.0 / (std::sqrt(x[0]) * std::sqrt(x[0])) - 20.0;
  };
  const std::vector<double> found = levenberg_marquardt(std::vector{0.5}, 1, fraction);
  EXPECT_NEAR(found[0], 0.1, 1e-6);
}

TEST(SolveSymmetric, finds_the_unknowns_of_two_and_of_three_equations) {
  EXPECT_THAT(solve_symmetric<2>({{{2.0, 1.0}, {1.0, 3.0}}}, {4.0, 7.0}),
              ElementsAre(DoubleNear(1.0, 1e-15), DoubleNear(2.0, 1e-15)));
  EXPECT_THAT(solve_symmetric<3>({{{4.0, 1.0, 0.0}, {1.0, 3.0, 1.0}, {0.0, 1.0, 2.0}}}, {6.0, 10.0, 8.0}),
              ElementsAre(DoubleNear(1.0, 1e-14), DoubleNear(2.0, 1e-14), DoubleNear(3.0, 1e-14)));
}

TEST(Inverse, of_a_shift_shifts_back) {
  const auto back = inverse({{{1.0, 0.0, 3.0}, {0.0, 1.0, -2.0}, {0.0, 0.0, 1.0}}});
  ASSERT_TRUE(back);
  EXPECT_EQ(*back, (SquareMatrix<3>{{{1.0, 0.0, -3.0}, {0.0, 1.0, 2.0}, {0.0, 0.0, 1.0}}}));
}

TEST(Inverse, is_missing_where_rows_depend_on_each_other_or_are_not_numbers) {
  EXPECT_FALSE(inverse({{{1.0, 2.0, 0.0}, {2.0, 4.0, 0.0}, {0.0, 0.0, 1.0}}}).has_value());
  EXPECT_FALSE(inverse({{{std::nan(""), 0.0, 0.0}, {0.0, 1.0, 0.0}, {0.0, 0.0, 1.0}}}).has_value());
}

TEST(NearestOrthogonal, of_a_scaled_rotation_is_the_rotation) {
  const double c = 0.6;
  const double s = 0.8;
  const SquareMatrix<3> rotation{{{c, -s, 0.0}, {s, c, 0.0}, {0.0, 0.0, 1.0}}};
  SquareMatrix<3> scaled = rotation;
  for (auto& row : scaled)
    for (double& value : row) value *= 1.7;
  const SquareMatrix<3> nearest = nearest_orthogonal(scaled);
  for (std::size_t i = 0; i < 3; ++i) EXPECT_THAT(nearest[i], Pointwise(DoubleNear(1e-14), rotation[i]));
}

}  // namespace
}  // namespace cosiva
