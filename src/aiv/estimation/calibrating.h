#pragma once

#include <array>
#include <cstdint>
#include <variant>
#include <vector>

#include "cosiva/aiv/estimation/algorithm.h"

/// Estimation on the plane with uncertain sensors: their scales and biases are states, outliers count less, and an
/// unknown heading is searched for.
namespace cosiva::estimation {

/// The state: x, y, heading (unwrapped), odometry's distance scale and turn scale, the ranges' scale and common bias,
/// one bias for each of the first eight stations, which changes as the vehicle moves (a Gauss-Markov process), and at
/// the end a gyroscope's offset [rad/s].
struct CalibratedState {
  static constexpr int size_max = 16;
  static constexpr int common_size = 7;
  enum Index : int { x, y, heading, distance_scale, turn_scale, range_scale, range_common, turn_drift = size_max - 1 };
  using Vector = Eigen::Matrix<double, size_max, 1>;
  using Matrix = Eigen::Matrix<double, size_max, size_max>;

  Vector mean;
  Matrix covariance;

  [[nodiscard]] Estimate estimate() const;
};

/// Which station has which bias, numbered by first ranges. Invariant: no station has the index of another component.
class Stations {
 public:
  /// The station's index in the state; −1 for the ninth and later ones, which have the common bias alone.
  [[nodiscard]] int index(std::uint32_t station);
  [[nodiscard]] int count() const { return count_; }
  static constexpr int count_max = CalibratedState::turn_drift - CalibratedState::common_size;

 private:
  std::array<std::uint32_t, count_max> ids_{};
  int count_{0};
};

/// One linear component of a reading or a range: `expected` at the state `about`, and its slope there.
struct Measured {
  CalibratedState::Vector slope;
  double residual;  ///< measured − expected at the point of linearisation
  double variance;  ///< of the noise
};

/// The extended Kalman filter of that state. Ranges and readings are weighted by Student's t with four degrees of
/// freedom instead of a Gaussian: outliers count less, and no input is refused for ever. Where the heading is unknown
/// at the start, or was lost later, several filters start, one per direction, and the measurements decide (a Gaussian
/// sum filter).
/// Sources: Y. Bar-Shalom, X. R. Li, T. Kirubarajan, Estimation with Applications to Tracking and Navigation (2001),
/// augmented states; D. L. Alspach, H. W. Sorenson, IEEE TAC 17 (1972), Gaussian sums. Invariant: a hypothesis is left.
class CalibratingFilter : public Algorithm {
 public:
  explicit CalibratingFilter(Setting setting);
  void predict(const Odometry& odometry) override;
  Rectified rectify(const Reading& reading) override;
  Rectified rectify(const Range& range) override;
  [[nodiscard]] Estimate estimate() const override;
  /// Of the most likely hypothesis.
  [[nodiscard]] const CalibratedState& state() const { return hypotheses[best()].state; }

 protected:
  /// A direction that was tried when the heading had been lost.
  struct Turned {
    std::size_t input;  ///< after this input, counted from 0
    double by_rad;
  };
  struct Hypothesis {
    CalibratedState state;
    double log_weight{};
    double start_heading_rad{};
    std::vector<Turned> turned{};
  };
  [[nodiscard]] std::size_t best() const;
  template <typename Input>
  Rectified rectify_all(const Input& input);
  void prune();
  void scan_headings();
  [[nodiscard]] CalibratedState start_state(double heading_rad, double heading_sigma_rad) const;

  Setting configured;
  Stations stations;
  std::vector<Hypothesis> hypotheses;
  std::size_t inputs_count{0};
};

/// A smoother over the whole run with the same model: forwards and backwards, linearised anew about the result, until
/// convergence: a Gauss-Newton solution of the run's factor graph. Sources: G. J. Bierman, Fixed Interval Smoothing
/// with Discrete Measurements, Int. J. Control 18 (1973), the backward pass, which inverts nothing; B. M. Bell, The
/// Iterated Kalman Smoother as a Gauss-Newton Method, SIAM J. Opt. 4 (1994). Invariant: all inputs counted are stored.
class CalibratingSmoother final : public CalibratingFilter {
 public:
  using CalibratingFilter::CalibratingFilter;
  void predict(const Odometry& odometry) override;
  Rectified rectify(const Reading& reading) override;
  Rectified rectify(const Range& range) override;
  [[nodiscard]] std::vector<Estimate> revised() override;

 private:
  using Input = std::variant<Odometry, Reading, Range>;
  /// One event of the forward pass: the state after it, and the input of the backward pass.
  struct Step {
    CalibratedState state;
    std::array<Measured, 2> measured;  ///< two of a reading, one of a range
    int measured_count{0};
    CalibratedState::Matrix before;  ///< covariance before those
    CalibratedState::Matrix motion;  ///< of odometry: slope of the new state in the old one
  };
  /// @param turned  of the first round, which has no result yet to linearise about
  void forwards(const CalibratedState& start, const std::vector<CalibratedState>& about,
                const std::vector<Turned>& turned, std::vector<Step>& steps);
  static void backwards(const std::vector<Step>& steps, std::vector<CalibratedState>& smoothed,
                        const CalibratedState& start, CalibratedState& start_smoothed);

  std::vector<Input> inputs_;
};

}  // namespace cosiva::estimation
