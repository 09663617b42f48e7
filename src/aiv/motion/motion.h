#pragma once

#include <algorithm>
#include <cstddef>
#include <span>
#include <utility>

#include "cosiva/base/archive_fwd.h"
#include "cosiva/base/expect.h"
#include "cosiva/base/pose.h"
#include "cosiva/zone/circuit/circuit.h"

namespace cosiva::aiv {

/// In the direction of increasing arc length (A32): the model of the travel direction that is the default.
struct DirectTravelDir {
  /// The sections that may come next.
  [[nodiscard]] static std::span<const zone::SectionId> next_sections(const zone::Circuit& circuit,
                                                                      zone::SectionId current) {
    return circuit.next(current);
  }
  /// Pose at this direction's start of the section, heading of increasing s.
  [[nodiscard]] static const Pose2& section_start(const zone::Section& section) { return section.start(); }
  /// Arc length from the section's own start for a distance travelled in this direction.
  [[nodiscard]] static double arc_length(const zone::Section& /*section*/, double mDTCS_m) { return mDTCS_m; }
  /// The position update (A30): the section's response to the request.
  [[nodiscard]] COSIVA_INLINE static zone::NextPosition next_position(const zone::Section& section, double mDTCS_m,
                                                                      double DTT_m) {
    return section.nextAIVposition(mDTCS_m, DTT_m);
  }
};

/// Towards the start of each section (A32).
struct IndirectTravelDir {
  [[nodiscard]] static std::span<const zone::SectionId> next_sections(const zone::Circuit& circuit,
                                                                      zone::SectionId current) {
    return circuit.previous(current);
  }
  [[nodiscard]] static const Pose2& section_start(const zone::Section& section) { return section.end(); }
  [[nodiscard]] static double arc_length(const zone::Section& section, double mDTCS_m) {
    return section.length_m() - mDTCS_m;
  }
  [[nodiscard]] COSIVA_INLINE static zone::NextPosition next_position(const zone::Section& section, double mDTCS_m,
                                                                      double DTT_m) {
    return section.nextAIVposition(mDTCS_m, DTT_m, true);
  }
};

/// Travel direction, reified (A32, figure 13): determines which section follows, where a section starts, how a position
/// is updated, and the effect of a request to move in the other direction. Invariant: the state is that of the last
/// request, direct by default.
class TravelDir {
 public:
  enum class State { St_DirectTravelDir, St_IndirectTravelDir };
  enum class Event { Ev_OnDirectMoveReq, Ev_OnIndirectMoveReq };

  [[nodiscard]] static TravelDir direct() { return TravelDir{State::St_DirectTravelDir}; }
  [[nodiscard]] static TravelDir indirect() { return TravelDir{State::St_IndirectTravelDir}; }
  TravelDir() = default;

  [[nodiscard]] State state() const { return state_; }
  [[nodiscard]] bool is_direct() const { return state_ == State::St_DirectTravelDir; }
  /// Calls `request` with the model of the present state, a DirectTravelDir or an IndirectTravelDir.
  template <typename Request>
  COSIVA_INLINE decltype(auto) in_state(Request&& request) const {
    return is_direct() ? std::forward<Request>(request)(DirectTravelDir{})
                       : std::forward<Request>(request)(IndirectTravelDir{});
  }

  /// The section that comes next in this direction: the `branch`-th of a fork (too large: the last); no_section at a
  /// dead end.
  [[nodiscard]] zone::SectionId next_section(const zone::Circuit& circuit, zone::SectionId current,
                                             std::size_t branch = 0) const;
  [[nodiscard]] Pose2 section_start(const zone::Section& section) const {
    return in_state([&](auto model) { return model.section_start(section); });
  }
  [[nodiscard]] double arc_length(const zone::Section& section, double mDTCS_m) const {
    return in_state([&](auto model) { return model.arc_length(section, mDTCS_m); });
  }
  [[nodiscard]] COSIVA_INLINE zone::NextPosition next_position(const zone::Section& section, double mDTCS_m,
                                                               double DTT_m) const {
    return in_state([&](auto model) { return model.next_position(section, mDTCS_m, DTT_m); });
  }

  /// The state diagram of A32. True when the state changed.
  bool on(Event event);

  friend bool operator==(const TravelDir&, const TravelDir&) = default;
  void archive(Archive& archive);  ///< the state, for a snapshot

 private:
  explicit TravelDir(State state) : state_{state} {}
  State state_{State::St_DirectTravelDir};
};

/// One request of figure 11 and its response.
struct SectionResponse {
  zone::SectionId section;
  double mDTCS_m;  ///< at the request
  double DTT_m;    ///< requested
  zone::NextPosition next;
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
  /// As move, through the sections of `route` and from its end along default successors; calls `on_response` with each
  /// SectionResponse, in order.
  template <typename OnResponse>
  double travel(const zone::Circuit& circuit, double DTT_m, std::span<const zone::SectionId> route,
                OnResponse&& on_response);

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
  /// As travel, through the sections that `next_section(current)` gives, no_section at a dead end.
  template <typename NextSection, typename OnResponse>
  double travel_through(const zone::Circuit& circuit, double DTT_m, NextSection&& next_section,
                        OnResponse&& on_response);
  /// The rest of a move whose section has responded with DT < DTT: phases b and c of figure 14.
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
// moves; the pose that the section responds with is computed only where it is used.
inline double AivMotion::move(const zone::Circuit& circuit, double DTT_m, std::size_t branch) {
  const zone::Section& section = circuit.section(section_);
  const double DT_m = direction_.next_position(section, mDTCS_m_, DTT_m).DT_m;
  if (DT_m < DTT_m) return move_across(circuit, DTT_m, branch);
  mDTCS_m_ = std::min(mDTCS_m_ + DTT_m, section.length_m());
  return DTT_m;
}

template <typename OnResponse>
double AivMotion::travel(const zone::Circuit& circuit, double DTT_m, std::span<const zone::SectionId> route,
                         OnResponse&& on_response) {
  std::size_t step = 0;
  const auto next = [&](zone::SectionId here) {
    return step < route.size() ? route[step++] : direction_.next_section(circuit, here);
  };
  return travel_through(circuit, DTT_m, next, on_response);
}

template <typename NextSection, typename OnResponse>
double AivMotion::travel_through(const zone::Circuit& circuit, double DTT_m, NextSection&& next_section,
                                 OnResponse&& on_response) {
  constexpr double DTT_m_max = 1e9;
  COSIVA_EXPECT(DTT_m >= 0.0 && DTT_m <= DTT_m_max);
  double left_to_travel_m = DTT_m;
  for (;;) {
    const zone::Section& section = circuit.section(section_);
    const zone::NextPosition next = direction_.next_position(section, mDTCS_m_, left_to_travel_m);
    on_response(SectionResponse{section_, mDTCS_m_, left_to_travel_m, next});
    if (next.DT_m >= left_to_travel_m) {  // phase c: the move ends on this section
      mDTCS_m_ = std::min(mDTCS_m_ + left_to_travel_m, section.length_m());
      return DTT_m;
    }
    left_to_travel_m -= next.DT_m;
    const zone::SectionId after = next_section(section_);
    if (after == zone::no_section) {
      mDTCS_m_ = section.length_m();
      return DTT_m - left_to_travel_m;
    }
    section_ = after;  // phase b: the next section becomes the current one
    mDTCS_m_ = 0.0;
  }
}

inline zone::TrackPosition AivMotion::track_position(const zone::Circuit& circuit) const {
  return {section_, direction_.arc_length(circuit.section(section_), mDTCS_m_)};
}

inline Pose2 AivMotion::pose(const zone::Circuit& circuit) const { return circuit.pose_at(track_position(circuit)); }

}  // namespace cosiva::aiv
