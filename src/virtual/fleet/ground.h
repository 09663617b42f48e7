#pragma once

#include <cstddef>
#include <cstdint>
#include <limits>
#include <memory>
#include <span>
#include <vector>

#include "cosiva/base/result.h"
#include "cosiva/zone/layout/traffic_zone.h"

namespace cosiva::virtual_side {

/// Further than any distance; finite, so that it can be used in arithmetic.
inline constexpr double far_m = 1e9;

/// A zone preprocessed for a fleet, once for all its copies: the data that never changes during a run.
class Ground {
 public:
  /// Fails ("fleet.zone") on a zone without sections, or with crossings so close together that a vehicle would have to
  /// reserve too many at once.
  [[nodiscard]] static Result<Ground> make(std::shared_ptr<const zone::TrafficZone> zone);

  [[nodiscard]] const zone::TrafficZone& zone() const { return *zone_; }
  [[nodiscard]] const zone::Circuit& circuit() const { return zone_->circuit; }
  [[nodiscard]] std::size_t size() const { return length_m_.size(); }
  [[nodiscard]] double length_m(zone::SectionId section) const { return length_m_[section]; }
  [[nodiscard]] double limit_mps(zone::SectionId section) const { return limit_mps_[section]; }  ///< far_m: none
  /// The next section of a vehicle that circulates; no_section: a dead end.
  [[nodiscard]] zone::SectionId default_next(zone::SectionId section) const { return default_next_[section]; }
  /// Up to this distance along a section a body blocks vehicles that take another branch (0: there are none).
  [[nodiscard]] double parted_m(zone::SectionId section) const { return parted_m_[section]; }
  /// The turn on the spot; 0 if a vehicle drives on without one.
  [[nodiscard]] double turn_rad(zone::SectionId from, zone::SectionId to) const;
  [[nodiscard]] bool has_limits() const { return has_limits_; }
  [[nodiscard]] bool has_turns() const { return has_turns_; }
  /// Whether some route through a line has no chain: a route that returns to a section within a chain, without a
  /// stopping position on it. No vehicle may be sent along such a route; default_next() never leads along one.
  [[nodiscard]] bool has_cuts() const { return cuts_; }

  /// Crossings without a stopping position between them: they are reserved all at once.
  struct Chain {
    std::uint32_t first_section;  ///< in sections_of
    std::uint32_t sections;       ///< number of sections; the first contains the entry, the last the exit
    std::uint32_t first_leave;    ///< in leaves_of
    std::uint32_t leaves;
    double entry_m;  ///< on its first section
    double exit_m;   ///< counted from the start of its first section
  };
  /// Where a crossing of a chain is left; each crossing of the chain once, in the order along the path.
  struct Leave {
    std::uint32_t crossing;
    double at_m;  ///< counted from the start of the chain's first section
  };
  /// A stop line: a vehicle that does not hold the following crossings stops before it.
  struct Line {
    double at_m;
    std::uint32_t first_chain;  ///< one for each route on from here, except for has_cuts()
    std::uint32_t chains;
  };
  [[nodiscard]] std::span<const Line> lines(zone::SectionId section) const {
    return {lines_.data() + first_line_[section], lines_.data() + first_line_[section + 1]};
  }
  [[nodiscard]] const Chain& chain(std::uint32_t index) const { return chains_[index]; }
  [[nodiscard]] std::span<const zone::SectionId> sections_of(const Chain& chain) const {
    return {chain_sections_.data() + chain.first_section, chain.sections};
  }
  [[nodiscard]] std::span<const Leave> leaves_of(const Chain& chain) const {
    return {leaves_.data() + chain.first_leave, chain.leaves};
  }
  /// Whether a vehicle may start here: outside every crossing, and not between two of one chain.
  [[nodiscard]] bool may_stop(zone::TrackPosition position) const;
  /// A crossing counts as left this distance behind its exit, so that no rounding keeps it reserved.
  static constexpr double left_m = 0.02;
  [[nodiscard]] std::size_t bytes() const;

 private:
  struct Span {
    double from_m;
    double to_m;
    std::uint32_t crossing;
  };
  /// One chain under construction.
  struct Laying {
    std::vector<zone::SectionId> sections;
    std::vector<Leave> leaves;
    double start_m;  ///< of the last section, counted from the start of the first one
    double exit_m;
  };
  void lay_sections();
  void lay_defaults();
  void lay_parted();
  [[nodiscard]] Result<void> lay_lines();
  [[nodiscard]] Result<void> defaults_have_chains() const;
  [[nodiscard]] tl::unexpected<Error> no_stopping_position(zone::SectionId section) const;
  /// Remaining effort of the search from one line.
  struct Search {
    std::size_t chains_most;
    std::size_t checks_left;
    [[nodiscard]] bool is_over(std::size_t chains) const { return chains > chains_most || checks_left == 0; }
  };
  /// Follows a chain from `from_m` of its last section to its exit, along every possible route. Returns false if no
  /// route reaches an exit, or if the search is over.
  [[nodiscard]] bool follow(Laying& laying, double from_m, double entry_m, Search& search);
  void finish(const Laying& laying, double entry_m);

  std::shared_ptr<const zone::TrafficZone> zone_;
  std::vector<double> length_m_;
  std::vector<double> limit_mps_;
  std::vector<zone::SectionId> default_next_;
  std::vector<double> parted_m_;
  std::vector<std::vector<Span>> spans_;  ///< by section, in order
  std::vector<std::uint32_t> first_line_;
  std::vector<Line> lines_;
  std::vector<Chain> chains_;
  std::vector<zone::SectionId> chain_sections_;
  std::vector<Leave> leaves_;
  double gap_m_{};  ///< spans nearer to each other than this are one chain
  bool has_limits_{false};
  bool has_turns_{false};
  bool cuts_{false};
};

}  // namespace cosiva::virtual_side
