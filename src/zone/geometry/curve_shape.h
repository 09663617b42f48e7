#pragma once

#include <functional>
#include <string>
#include <vector>

#include "cosiva/zone/geometry/section_shape.h"

namespace cosiva::zone {

/// A curve as a textbook states it: x(t) and y(t), for t from 0 to t_max, with their first two derivatives.
struct CurveFormulas {
  /// Position, velocity and acceleration at t, in any frame.
  struct At {
    Point2 position;
    Point2 velocity;
    Point2 acceleration;
  };
  std::function<At(double t)> at;
  double t_max{1.0};
};

/// A kind of section given by formulas. Positions, headings and curvatures come from the formulas themselves; only t of
/// an arc length comes from a table, whose error is below 1e-9 of the length.
class CurveShape final : public SectionShape {
 public:
  /// @param kind    the name of the kind in files of zones
  /// @param fields  of its entry there
  /// Fails ("section.invalid") where the velocity vanishes or something is not finite, or check_shape finds a fault.
  [[nodiscard]] static Result<std::shared_ptr<const SectionShape>> make(std::string kind, std::vector<Field> fields,
                                                                        CurveFormulas curve);

  std::string_view kind() const override { return kind_; }
  double length_m() const override { return length_m_; }
  Pose2 pose_at(double s_m) const override;
  double curvature_at(double s_m) const override;
  double curvature_max_per_m() const override { return curvature_max_per_m_; }
  std::vector<Field> fields() const override { return fields_; }

 private:
  /// t and dt/ds at equal steps of s; between them a cubic.
  struct Knot {
    double t;
    double t_per_m;
  };

  CurveShape(std::string kind, std::vector<Field> fields, CurveFormulas curve);
  [[nodiscard]] bool measure();
  [[nodiscard]] double t_at(double s_m) const;
  [[nodiscard]] double speed_at(double t) const;

  std::string kind_;
  std::vector<Field> fields_;
  CurveFormulas curve_;
  Pose2 X_SM_;  ///< of the formulas' frame, in the frame of the start
  double length_m_{0.0};
  double knots_per_m_{0.0};
  std::vector<Knot> knots_;
  double curvature_max_per_m_{0.0};
};

}  // namespace cosiva::zone
