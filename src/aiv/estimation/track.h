#pragma once

#include <memory>
#include <optional>
#include <vector>

#include "cosiva/base/pose.h"
#include "cosiva/base/result.h"
#include "cosiva/zone/circuit/circuit.h"
#include "cosiva/zone/layout/traffic_zone.h"

namespace cosiva::estimation {

/// A path along a circuit, unrolled: one arc length from its beginning, over all its sections and, where the track is
/// closed, over any number of rounds.
class Track {
 public:
  /// Fails ("track.empty"), ("track.gap") where a section does not follow the one before it.
  [[nodiscard]] static Result<Track> make(std::shared_ptr<const zone::Circuit> circuit,
                                          std::vector<zone::SectionId> sections, bool closed);
  /// From the circuit's first section by default successors as far as they lead; closed where they lead back, without
  /// the sections before the loop. Fails as make does.
  [[nodiscard]] static Result<Track> of_loop(std::shared_ptr<const zone::Circuit> circuit);
  /// The zone's first loop, or of_loop() where the zone names none: the loop on which its vehicles circulate. With
  /// `through`, the first loop over this section. Fails as make does.
  [[nodiscard]] static Result<Track> round(const std::shared_ptr<const zone::TrafficZone>& zone,
                                           std::optional<zone::SectionId> through = std::nullopt);

  [[nodiscard]] const zone::Circuit& circuit() const { return *circuit_; }
  [[nodiscard]] const std::shared_ptr<const zone::Circuit>& shared_circuit() const { return circuit_; }
  [[nodiscard]] double length_m() const { return starts_.back(); }  ///< of one round
  [[nodiscard]] bool closed() const { return closed_; }

  /// Where the track first passes a position; nothing: the track does not lead there.
  [[nodiscard]] std::optional<double> along_of(zone::TrackPosition position) const;
  /// On an open track clamped to its ends.
  [[nodiscard]] zone::TrackPosition position_at(double along_m) const;
  [[nodiscard]] Pose2 pose_at(double along_m) const;
  /// κ there, of increasing arc length.
  [[nodiscard]] double curvature_at(double along_m) const;
  /// The arc length nearest to `near_m`, and within `reach_m` of it, at which the track passes over a point, or past it
  /// within `beside_m`.
  [[nodiscard]] std::optional<double> foot(Point2 p_M, double near_m, double reach_m, double beside_m = 0.10) const;

 private:
  Track() = default;
  [[nodiscard]] std::size_t index_at(double once_m) const;
  [[nodiscard]] double once(double along_m) const;

  std::shared_ptr<const zone::Circuit> circuit_;
  std::vector<zone::SectionId> sections_;
  std::vector<double> starts_;  ///< arc length at which each section begins, and the end of the last
  bool closed_{};
};

}  // namespace cosiva::estimation
