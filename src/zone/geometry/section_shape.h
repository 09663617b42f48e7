#pragma once

#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "cosiva/base/pose.h"
#include "cosiva/base/result.h"

namespace cosiva::zone {

/// What a section responds to the article's request nextAIVposition (A30).
struct NextPosition {
  Pose2 pose;   ///< the position reached
  double DT_m;  ///< the distance travelled, ≤ DTT; less where the section ends first (figure 14)
};

/// A curve for a kind of section that this library does not contain (docs/guide/zones.md, "Further kinds of sections").
/// The curve has finite curvature and is parametrised by its arc length s ∈ [0, L], in the frame of its start: the
/// start is the origin, with heading 0. The functions are called from several threads at once, and must give the same
/// result each time.
class SectionShape {
 public:
  SectionShape() = default;
  SectionShape(const SectionShape&) = delete;
  SectionShape& operator=(const SectionShape&) = delete;
  virtual ~SectionShape() = default;

  /// The name of its kind in the files of zones, such as "sine".
  [[nodiscard]] virtual std::string_view kind() const = 0;
  [[nodiscard]] virtual double length_m() const = 0;  ///< L
  /// The pose at s ∈ [0, L]; the heading is that of increasing s.
  [[nodiscard]] virtual Pose2 pose_at(double s_m) const = 0;
  [[nodiscard]] virtual double curvature_at(double s_m) const = 0;  ///< [1/m], positive to the left
  /// An upper limit of |curvature| [1/m], as close as possible: searches cut the curve by it.
  [[nodiscard]] virtual double curvature_max_per_m() const = 0;

  /// The numbers that its entry in a zone's file contains besides the kind, in the file's order.
  struct Field {
    std::string key;
    double value;
    friend bool operator==(const Field&, const Field&) = default;
  };
  [[nodiscard]] virtual std::vector<Field> fields() const = 0;

  /// The article's request (A30): from `mDTCS_m` ≥ 0 travelled on this section, try to travel `DTT_m` ≥ 0 more. A
  /// vehicle in indirect direction (A32) travels towards the start, and mDTCS counts from the end. The default follows
  /// from pose_at.
  [[nodiscard]] virtual NextPosition nextAIVposition(double mDTCS_m, double DTT_m, bool indirect) const;
};

/// Fails ("section.invalid") where a shape contradicts itself: by samples along it, whether it begins at the origin, s
/// is its arc length, its heading its direction, and its curvature the change of its heading, within its limit. All
/// numbers have to be finite, the length from 1e-6 m to 1e5 m.
[[nodiscard]] Result<void> check_shape(const SectionShape& shape);

/// The part of a shape from `from_m` to `to_m`, with a start of its own; its kind and fields are those of the whole.
[[nodiscard]] std::shared_ptr<const SectionShape> part_of_shape(std::shared_ptr<const SectionShape> whole,
                                                                double from_m, double to_m);

/// The shape from its end to its start; its kind and fields are those of the shape. Reversed twice the shape itself.
[[nodiscard]] std::shared_ptr<const SectionShape> reversed_shape(std::shared_ptr<const SectionShape> shape);

/// Whether two shapes are of one kind with the same fields. A null pointer equals only another one.
[[nodiscard]] bool same_shape(const SectionShape* a, const SectionShape* b);

}  // namespace cosiva::zone
