#pragma once

#include <cmath>
#include <cstddef>
#include <memory>
#include <vector>

#include "cosiva/base/math.h"
#include "cosiva/zone/geometry/curve_shape.h"

namespace cosiva::zone::test {

/// y = amplitude·sin(2π·x/wavelength) for x from 0 to `waves` wavelengths.
inline CurveFormulas sine(double amplitude_m, double wavelength_m, double waves) {
  const double k = 2.0 * pi / wavelength_m;
  return {[=](double x) {
            const SinCos at = sincos(k * x);
            return CurveFormulas::At{
                {x, amplitude_m * at.sin}, {1.0, amplitude_m * k * at.cos}, {0.0, -amplitude_m * k * k * at.sin}};
          },
          waves * wavelength_m};
}

inline std::shared_ptr<const SectionShape> sine_shape(double amplitude_m, double wavelength_m, double waves) {
  auto shape =
      CurveShape::make("sine", {{"amplitude_m", amplitude_m}, {"wavelength_m", wavelength_m}, {"waves", waves}},
                       sine(amplitude_m, wavelength_m, waves));
  return shape ? *shape : nullptr;
}

/// A double of a section: an arc that counts the requests nextAIVposition, and gives its poses in closed form.
class CountingArc final : public SectionShape {
 public:
  CountingArc(double length_m, double curvature_per_m) : length_m_{length_m}, curvature_per_m_{curvature_per_m} {}

  std::string_view kind() const override { return "counting_arc"; }
  double length_m() const override { return length_m_; }
  Pose2 pose_at(double s_m) const override {
    const double turn_rad = s_m * curvature_per_m_;
    if (curvature_per_m_ == 0.0) return {s_m, 0.0, 0.0};
    const SinCos turn = sincos(turn_rad);
    return {turn.sin / curvature_per_m_, (1.0 - turn.cos) / curvature_per_m_, wrap_angle(turn_rad)};
  }
  double curvature_at(double /*s_m*/) const override { return curvature_per_m_; }
  double curvature_max_per_m() const override { return std::fabs(curvature_per_m_); }
  std::vector<Field> fields() const override {
    return {{"length_m", length_m_}, {"curvature_per_m", curvature_per_m_}};
  }
  NextPosition nextAIVposition(double mDTCS_m, double DTT_m, bool indirect) const override {
    requests.push_back({mDTCS_m, DTT_m, indirect});
    return SectionShape::nextAIVposition(mDTCS_m, DTT_m, indirect);
  }

  struct Request {
    double mDTCS_m;
    double DTT_m;
    bool indirect;
    friend bool operator==(const Request&, const Request&) = default;
  };
  mutable std::vector<Request> requests;

 private:
  double length_m_;
  double curvature_per_m_;
};

}  // namespace cosiva::zone::test
