#pragma once

#include <cstddef>
#include <optional>
#include <vector>

#include "cosiva/base/pose.h"
#include "cosiva/zone/layout/traffic_zone.h"

namespace cosiva::planning {

/// The area that a body occupies while it is stopped or moves: rectangles, at poses so near to one another that nothing
/// of the body's size fits between them.
///
/// Invariant: the box contains all rectangles.
class SweptArea {
 public:
  /// @param shape        of the body, whose origin is its centre
  /// @param clearance_m  by which the body is larger on each side, at least 0
  SweptArea(const zone::VehicleShape& shape, double clearance_m);

  void add_pose(const Pose2& X_MB);
  /// A turn on the spot, in the shorter direction; by π to the left.
  void add_turn(const Pose2& X_MB, double turn_rad);
  /// Along a section, both ends included.
  void add_drive(const zone::Circuit& circuit, zone::SectionId section, double from_m, double to_m);

  /// Two bodies, one in each area, could touch.
  [[nodiscard]] bool touches(const SweptArea& other) const;
  /// The last of the poses added, in their order, at which a body could touch the other area; none: the areas are
  /// apart.
  [[nodiscard]] std::optional<std::size_t> last_touching(const SweptArea& other) const;
  [[nodiscard]] std::size_t poses() const noexcept { return rectangles_.size(); }
  [[nodiscard]] double x_min_m() const noexcept { return box_.x_min_m; }
  [[nodiscard]] double x_max_m() const noexcept { return box_.x_max_m; }

 private:
  struct Box {
    double x_min_m;
    double x_max_m;
    double y_min_m;
    double y_max_m;
  };
  struct Rectangle {
    Point2 centre;
    Point2 along;  // half the length, in the direction of the heading
    Point2 left;   // half the width, to the left
  };

  [[nodiscard]] bool boxes_touch(const SweptArea& other) const;
  [[nodiscard]] static bool touch(const Rectangle& a, const Rectangle& b);

  double half_length_m_;
  double half_width_m_;
  Box box_;
  std::vector<Rectangle> rectangles_;
};

}  // namespace cosiva::planning
