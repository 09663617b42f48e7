#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "cosiva/base/archive_fwd.h"
#include "cosiva/base/digest.h"
#include "cosiva/base/pose.h"
#include "cosiva/base/time.h"

namespace cosiva::virtual_side {

/// Virtual objects (A3) other than AIVs.
enum class VirtualObjectKind : std::uint8_t { person, obstacle };
[[nodiscard]] std::string_view to_string(VirtualObjectKind kind);
[[nodiscard]] std::optional<VirtualObjectKind> parse_virtual_object_kind(std::string_view word);

/// What a person does at the end of the path.
enum class Repeat : std::uint8_t { once, back_and_forth, loop };
[[nodiscard]] std::string_view to_string(Repeat repeat);  ///< "once", "back and forth", "loop"
[[nodiscard]] std::optional<Repeat> parse_repeat(std::string_view word);

/// A path of straight legs, walked at constant speed: a closed form of the time since the start.
class Walk {
 public:
  static constexpr std::size_t points_max = 64;

  Walk() = default;
  /// @param path       at least one point; with one point, or with speed 0, the object stays at the first point
  /// @param speed_mps  ≥ 0
  Walk(std::vector<Point2> path, double speed_mps, Repeat repeat);

  struct Motion {
    Point2 at;
    double heading_rad{};  ///< direction of the present or last motion; 0 if it never moved
    double vx_mps{};
    double vy_mps{};
  };
  [[nodiscard]] Motion at(SimDuration since_start) const;
  [[nodiscard]] const std::vector<Point2>& path() const { return path_; }
  [[nodiscard]] double speed_mps() const { return speed_mps_; }
  [[nodiscard]] Repeat repeat() const { return repeat_; }
  [[nodiscard]] bool walks() const { return speed_mps_ > 0.0 && length_m_ > 0.0; }
  void archive(Archive& archive);  ///< the state, for a snapshot

 private:
  std::vector<Point2> path_{Point2{}};
  double speed_mps_{};
  Repeat repeat_{Repeat::once};
  std::vector<double> reached_m_{0.0};  ///< distance along the path from the start to each point; for a loop also back
                                        ///< to the first point
  double length_m_{};
};

struct VirtualObject {
  std::string id;
  VirtualObjectKind kind{VirtualObjectKind::person};
  std::uint16_t handle{};  ///< on binary frames, from Augmented::first_handle on
  double radius_m{};
  Walk walk;
  SimTime since{};    ///< time of addition
  SimTime started{};  ///< time when the walk began: the object was added or last moved
  [[nodiscard]] Walk::Motion at(SimTime time) const { return walk.at(time - started); }
};

/// The persons and obstacles that exist only virtually, in the order of their addition. Queries change nothing. The
/// class knows no zone and checks no positions. Invariant: each object has its own id, and there is a maximum of them.
class Augmented {
 public:
  static constexpr std::size_t virtual_objects_max = 64;
  static constexpr std::uint16_t first_handle = 0x8000;
  static constexpr std::uint16_t handles = 0x4000;

  /// Requires a free id and room for the object (checked by the caller). The function assigns the handle.
  const VirtualObject& add(VirtualObject virtual_object);
  /// The object walks from `now` on. Returns false if there is no such object.
  bool move(std::string_view id, Walk walk, SimTime now);
  bool remove(std::string_view id);
  void clear() { virtual_objects_.clear(); }

  [[nodiscard]] const VirtualObject* find(std::string_view id) const;
  [[nodiscard]] const std::vector<VirtualObject>& virtual_objects() const { return virtual_objects_; }
  [[nodiscard]] bool empty() const { return virtual_objects_.empty(); }
  void fold(Digest& digest) const;
  void archive(Archive& archive);  ///< the state, for a snapshot

 private:
  std::vector<VirtualObject> virtual_objects_;
  std::uint16_t next_{0};
};

}  // namespace cosiva::virtual_side
