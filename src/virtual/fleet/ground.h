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

/// Further than anything; a number, so that it can be calculated with.
inline constexpr double far_m = 1e9;

/// A zone worked out for a fleet, once for all its copies: what never changes while it drives.
class Ground {
 public:
  /// Fails ("fleet.zone") on a zone without sections, or whose crossings come so close upon one another that a vehicle
  /// would have to reserve too many at once.
  [[nodiscard]] static Result<Ground> make(std::shared_ptr<const zone::TrafficZone> zone);

  [[nodiscard]] const zone::TrafficZone& zone() const { return *zone_; }
  [[nodiscard]] const zone::Circuit& circuit() const { return zone_->circuit; }
  [[nodiscard]] std::size_t size() const { return length_m_.size(); }
  [[nodiscard]] double length_m(zone::SectionId section) const { return length_m_[section]; }
  [[nodiscard]] double limit_mps(zone::SectionId section) const { return limit_mps_[section]; }  ///< far_m: none
  /// What follows for one that circulates; no_section: a dead end.
  [[nodiscard]] zone::SectionId default_next(zone::SectionId section) const { return default_next_[section]; }
  /// So far along a section a body still is in the way of those who take another branch (0: nobody could).
  [[nodiscard]] double parted_m(zone::SectionId section) const { return parted_m_[section]; }
  /// On the spot; 0 where one rolls on.
  [[nodiscard]] double turn_rad(zone::SectionId from, zone::SectionId to) const;
  [[nodiscard]] bool has_limits() const { return has_limits_; }
  [[nodiscard]] bool has_turns() const { return has_turns_; }
  /// Whether some way through a line has no chain: one that comes back onto a section within a chain, without a place
  /// to stand on it. Nobody is to be sent along such a way; default_next() never leads so.
  [[nodiscard]] bool has_cuts() const { return cuts_; }

  /// Crossings that one may not stand between: they are reserved all at once.
  struct Chain {
    std::uint32_t first_section;  ///< in sections_of
    std::uint32_t sections;       ///< how many; the first holds the entry, the last the exit
    std::uint32_t first_leave;    ///< in leaves_of
    std::uint32_t leaves;
    double entry_m;  ///< on its first section
    double exit_m;   ///< counted from the start of its first section
  };
  /// Where a crossing of a chain is left behind; each crossing of the chain once, in order of the way.
  struct Leave {
    std::uint32_t crossing;
    double at_m;  ///< counted from the start of the chain's first section
  };
  /// A place before which one stops who does not hold what comes.
  struct Line {
    double at_m;
    std::uint32_t first_chain;  ///< one for each way on from here, but for has_cuts()
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
  /// Whether a vehicle may begin here: outside every crossing, and not between two of one chain.
  [[nodiscard]] bool may_stop(zone::TrackPosition position) const;
  /// Behind an exit its crossing counts as left, so that no rounding keeps it.
  static constexpr double left_m = 0.02;
  [[nodiscard]] std::size_t bytes() const;

 private:
  struct Span {
    double from_m;
    double to_m;
    std::uint32_t crossing;
  };
  /// One chain while it is laid.
  struct Laying {
    std::vector<zone::SectionId> sections;
    std::vector<Leave> leaves;
    double start_m;  ///< of the last section, counted from the first one's
    double exit_m;
  };
  void lay_sections();
  void lay_defaults();
  void lay_parted();
  [[nodiscard]] Result<void> lay_lines();
  [[nodiscard]] Result<void> defaults_have_chains() const;
  [[nodiscard]] tl::unexpected<Error> no_stopping_position(zone::SectionId section) const;
  /// What may still be looked for from one line.
  struct Search {
    std::size_t chains_most;
    std::size_t checks_left;
    [[nodiscard]] bool is_over(std::size_t chains) const { return chains > chains_most || checks_left == 0; }
  };
  /// Follows a chain to its exit from `from_m` of its last section on; every way that it can go. False: none comes to
  /// an exit, or the search is over.
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
