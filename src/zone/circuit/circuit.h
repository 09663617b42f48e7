#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "cosiva/base/pose.h"
#include "cosiva/base/result.h"
#include "cosiva/zone/geometry/section.h"
#include "cosiva/zone/geometry/section_grid.h"
#include "cosiva/zone/geometry/section_tree.h"

namespace cosiva::zone {

using SectionId = std::uint32_t;  ///< index into the circuit's sections
inline constexpr SectionId no_section = ~SectionId{0};

/// A position on a circuit: arc length s along a section.
struct TrackPosition {
  SectionId section{no_section};
  double s_m{};
  friend bool operator==(const TrackPosition&, const TrackPosition&) = default;
};

/// A directed graph of sections. The article's closed circuit is a loop.
class Circuit {
 public:
  struct Part {
    std::string name;
    Section section;
    std::optional<double> speed_mps_max;  ///< limit on this section, if any
    std::vector<SectionId> next;          ///< possible successors; the first is the default
    bool pivots{false};  ///< at its end vehicles turn on the spot where the successor leaves at an angle
  };

  /// Joins the parts. An error's location is the name of the section at fault. Fails ("circuit.gap", "circuit.kink")
  /// where a next section does not start where this one ends: position within `gap_m`, heading within `kink_rad` unless
  /// the section pivots; ("circuit.duplicate") on equal names; ("circuit.next") on a successor that is none of the
  /// parts; ("circuit.empty").
  [[nodiscard]] static Result<Circuit> make(std::string name, std::vector<Part> parts, double gap_m = 1e-3,
                                            double kink_rad = 1e-3);

  [[nodiscard]] const std::string& name() const { return name_; }
  /// Vehicles travel it in indirect direction (A32): it is the reversed circuit of its source, and the heading of a
  /// vehicle's body is opposite to that of its path.
  [[nodiscard]] bool indirect() const { return indirect_; }
  [[nodiscard]] std::size_t size() const { return parts_.size(); }
  [[nodiscard]] const Section& section(SectionId id) const { return parts_[id].section; }
  [[nodiscard]] const Part& part(SectionId id) const { return parts_[id]; }
  [[nodiscard]] std::optional<SectionId> find(std::string_view section_name) const;

  [[nodiscard]] std::span<const SectionId> next(SectionId id) const { return parts_[id].next; }
  [[nodiscard]] std::span<const SectionId> previous(SectionId id) const { return previous_[id]; }
  [[nodiscard]] double total_length_m() const;
  /// The turn of a vehicle on the spot between the end of `from` and the start of `to`, (−π, π], left positive; 0 where
  /// the path goes on within `smooth_rad`.
  [[nodiscard]] double turn_at(SectionId from, SectionId to) const;
  static constexpr double smooth_rad = 1e-3;

  [[nodiscard]] Pose2 pose_at(TrackPosition position) const { return section(position.section).pose_at(position.s_m); }

  /// The position nearest to p over all sections; `heading_rad` (if given) breaks ties where sections cross: only those
  /// within π/3 of it count, unless none is. Of several equally near the lowest id.
  struct Located {
    TrackPosition position;
    double left_m;
    double distance_m;
  };
  [[nodiscard]] Located locate(Point2 p, std::optional<double> heading_rad = std::nullopt) const;
  /// All sections that pass within `within_m` of p, each at its position nearest to p; sorted by distance, then id. The
  /// content of `out` is replaced; its memory is reused.
  void near(Point2 p, double within_m, std::vector<Located>& out) const;

  /// The position `distance_m` ahead: through the sections of `coming`, in order, and from its end along default
  /// successors; stops at a dead end. Negative goes back through `gone`, its last first, then along `previous`.
  [[nodiscard]] TrackPosition advance(TrackPosition from, double distance_m, std::span<const SectionId> remaining = {},
                                      std::span<const SectionId> traversed = {}) const;

  /// Distance to travel forward from `from` to `to` through the sections of `coming`, which follow from.section, and
  /// from its end along default successors; nothing beyond `limit_m`.
  [[nodiscard]] std::optional<double> distance_ahead(TrackPosition from, TrackPosition to, double limit_m,
                                                     std::span<const SectionId> remaining = {}) const;

  /// The shortest route from one position to another over all branches; nothing beyond `limit_m`.
  struct Route {
    double length_m{};
    std::vector<SectionId> sections;  ///< from.section first, to.section last
  };
  [[nodiscard]] std::optional<Route> shortest_route(TrackPosition from, TrackPosition to, double limit_m) const;

 private:
  friend Circuit reversed(const Circuit& circuit, std::string name);

  std::string name_;
  bool indirect_{false};
  std::vector<Part> parts_;
  std::vector<std::vector<SectionId>> previous_;
  std::vector<SectionId> by_name_;  ///< sorted by name, for find
  template <typename NeighbourVisitor>
  void survey_neighbours(Point2 p, Headings headings, const double& limit_m, const NeighbourVisitor& visitor) const;

  SectionGrid grid_;
  SectionTree tree_;  ///< of the same pieces, for queries that the grid cannot resolve
};

/// The circuit as a vehicle travels it in the other direction (A32): each section from its end to its start, followed
/// by the sections that precede it. Names and ids stay; a position at s lies at L − s. Of several successors the first
/// is one whose own default successor the section is.
/// @param name  of the reversed circuit
[[nodiscard]] Circuit reversed(const Circuit& circuit, std::string name);
[[nodiscard]] inline Circuit reversed(const Circuit& circuit) { return reversed(circuit, circuit.name()); }
/// Whether `a` is the reversed circuit of `b`: sections of the same names, each from the other's end to its start.
[[nodiscard]] bool is_reversed(const Circuit& a, const Circuit& b);
/// The same point of a circuit on the reversed one.
[[nodiscard]] TrackPosition reversed(const Circuit& circuit, TrackPosition position);

}  // namespace cosiva::zone
