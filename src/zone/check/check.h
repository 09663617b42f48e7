#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "cosiva/zone/layout/traffic_zone.h"

namespace cosiva::zone {

/// One finding of the check of a zone, with its location.
struct Problem {
  enum class Severity {
    error,    ///< vehicles cannot do what the zone requires of them
    warning,  ///< vehicles can, but something is probably unintended
    notice,   ///< a remark on a zone that is as intended
  };
  Severity severity;
  std::string code;  ///< "circuit.gap", "zone.dead_end", …: docs/guide/zones.md lists them
  TrackPosition position;
  Point2 at;         ///< the same location on the map
  std::string text;  ///< a sentence
};
[[nodiscard]] std::string_view to_string(Problem::Severity severity);
/// "warning zone.dead_end at 'spur' 2.00 m (1.50, -0.20): …", as commands print it.
[[nodiscard]] std::string to_string(const Problem& problem, const TrafficZone& zone);

struct CheckLimits {
  double gap_m{1e-3};
  double kink_rad{1e-3};
  double lateral_mps2{1.0};       ///< the lateral acceleration that loads and bodies tolerate in a bend at full speed
  double unread_max_m{5.0};       ///< without a tag or a beacon
  std::size_t of_one_code{100};   ///< further findings are counted, not listed
  std::size_t single_tracks{10};  ///< likewise; on a floor of two-way tracks each one is such a finding
};

/// Everything that is wrong or odd with a readable zone, errors first, then by code and section: gaps and kinks, bends
/// too tight for the vehicle or its speed, stations that cannot be reached from the starts or from another station
/// (closed sections count as absent), sections that end, sections that no other leads to, long distances without tag or
/// beacon, starts and stations where vehicles obstruct others, tracks driven both ways. The faults for which make_zone
/// refuses a zone are reported by CircuitFactory::faults.
[[nodiscard]] std::vector<Problem> problems(const TrafficZone& zone, const CheckLimits& limits = {});

}  // namespace cosiva::zone
