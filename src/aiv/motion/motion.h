#pragma once

#include <span>
#include <string_view>

#include "cosiva/base/archive_fwd.h"
#include "cosiva/base/expect.h"
#include "cosiva/base/pose.h"
#include "cosiva/zone/circuit/circuit.h"

namespace cosiva::aiv {

/// Travel direction, reified (A32, figure 13): determines which section follows, where a section starts, and the effect
/// of a request to move in the other direction. Invariant: the state is that of the last request, direct by default.
class TravelDir {
 public:
  enum class State { St_DirectTravelDir, St_IndirectTravelDir };
  enum class Event { Ev_OnDirectMoveReq, Ev_OnIndirectMoveReq };

  [[nodiscard]] static TravelDir direct() { return TravelDir{State::St_DirectTravelDir}; }
  [[nodiscard]] static TravelDir indirect() { return TravelDir{State::St_IndirectTravelDir}; }
  TravelDir() = default;

  [[nodiscard]] State state() const { return state_; }
  [[nodiscard]] bool is_direct() const { return state_ == State::St_DirectTravelDir; }

  /// The section that comes next in this direction; no_section at a dead end.
  [[nodiscard]] zone::SectionId next_section(const zone::Circuit& circuit, zone::SectionId current) const;
  /// Pose at this direction's start of the section, heading of increasing s.
  [[nodiscard]] Pose2 section_start(const zone::Section& section) const;
  /// Arc length from the section's own start for a distance travelled in this direction: s, or L − s.
  [[nodiscard]] double arc_length(const zone::Section& section, double mDTCS_m) const {
    return is_direct() ? mDTCS_m : section.length_m() - mDTCS_m;
  }

  /// The state diagram of A32. True when the state changed.
  bool on(Event event);

  friend bool operator==(const TravelDir&, const TravelDir&) = default;
  void archive(Archive& archive);  ///< the state, for a snapshot

 private:
  explicit TravelDir(State state) : state_{state} {}
  State state_{State::St_DirectTravelDir};
};

/// The route memory of an AIV (A28): the section, the distance travelled on the section (mDTCS), and the direction.
/// Geometry stays in circuit and sections. A value: the plant's ground truth, the on-board estimate, and the twin each
/// own one. Invariant: 0 ≤ mDTCS ≤ L, the length of the section, in either direction.
class AivMotion {
 public:
  AivMotion() = default;
  /// @param position section and arc length from the section's own start; s clamped to [0, L]
  AivMotion(const zone::Circuit& circuit, zone::TrackPosition position, TravelDir direction = TravelDir::direct());

  [[nodiscard]] zone::SectionId current_section() const { return section_; }
  [[nodiscard]] double mDTCS_m() const { return mDTCS_m_; }  ///< distance travelled on the current section
  [[nodiscard]] TravelDir direction() const { return direction_; }
  [[nodiscard]] zone::TrackPosition track_position(const zone::Circuit& circuit) const;
  /// X_MB with the body's x axis along increasing s, in either direction: reversing does not turn the vehicle.
  [[nodiscard]] Pose2 pose(const zone::Circuit& circuit) const;

  /// A30: travels DTT ≥ 0 over as many sections as necessary. Returns the distance actually travelled: less than DTT
  /// only at a dead end. DTT is at most 1e9 m, because the loop visits every section passed. At a fork the `branch`-th
  /// successor is taken (0: the default; too large: the last).
  double move(const zone::Circuit& circuit, double DTT_m, std::size_t branch = 0);

  /// A32: on a change mDTCS is mirrored first (L − mDTCS), then the state; the position stays. True on a change.
  bool on_direct_move_req(const zone::Circuit& circuit);
  bool on_indirect_move_req(const zone::Circuit& circuit);

  /// Signed move along the circuit, for corrections: negative distances travel against the current direction. Forwards
  /// through the sections of `remaining`, then along default successors; backwards through `traversed`, the last first.
  /// Returns the distance actually travelled, with its sign.
  double shift(const zone::Circuit& circuit, double distance_m, std::span<const zone::SectionId> remaining = {},
               std::span<const zone::SectionId> traversed = {});

  friend bool operator==(const AivMotion&, const AivMotion&) = default;
  void archive(Archive& archive);  ///< the state, for a snapshot

 private:
  /// Phase b of figure 14, once for each section that is too short; called when the section conservation condition
  /// fails.
  double move_across(const zone::Circuit& circuit, double DTT_m, std::size_t branch);
  /// Mirrors mDTCS, then lets the direction change its state (figure 13).
  bool turn(const zone::Circuit& circuit, TravelDir::Event event);

  zone::SectionId section_{zone::no_section};
  double mDTCS_m_{0.0};
  TravelDir direction_;
};

/// One pass over many AIVs: each travels its own distance; `poses` (same length, may be empty) receives their poses.
void move_all(const zone::Circuit& circuit, std::span<AivMotion> aivs, std::span<const double> DTT_m,
              std::span<Pose2> poses);

// The usual move stays on its section (phases a and c only). The function is inlined because a fleet makes millions of
// moves.
inline double AivMotion::move(const zone::Circuit& circuit, double DTT_m, std::size_t branch) {
  COSIVA_EXPECT(DTT_m >= 0.0);
  const double length_m = circuit.section(section_).length_m();
  const double reached_m = mDTCS_m_ + DTT_m;
  if (reached_m > length_m) return move_across(circuit, DTT_m, branch);
  mDTCS_m_ = reached_m;
  return DTT_m;
}

inline zone::TrackPosition AivMotion::track_position(const zone::Circuit& circuit) const {
  return {section_, direction_.arc_length(circuit.section(section_), mDTCS_m_)};
}

inline Pose2 AivMotion::pose(const zone::Circuit& circuit) const { return circuit.pose_at(track_position(circuit)); }

}  // namespace cosiva::aiv
