#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "cosiva/zone/layout/traffic_zone.h"

namespace cosiva::zone {

/// What somebody who is about to drive in a zone should know of it, and where that is.
struct Problem {
  enum class Severity {
    error,    ///< vehicles cannot do what the zone asks of them
    warning,  ///< they can, but something is probably not meant so
    notice,   ///< worth knowing of a zone that is as it was meant
  };
  Severity severity;
  std::string code;  ///< "circuit.gap", "zone.dead_end", …: docs/guide/zones.md lists them
  TrackPosition position;
  Point2 at;         ///< the same place on the map
  std::string text;  ///< a sentence
};
[[nodiscard]] std::string_view to_string(Problem::Severity severity);
/// "warning zone.dead_end at 'spur' 2.00 m (1.50, -0.20): …", as commands print it.
[[nodiscard]] std::string to_string(const Problem& problem, const TrafficZone& zone);

struct CheckLimits {
  double gap_m{1e-3};
  double kink_rad{1e-3};
  double lateral_mps2{1.0};      ///< what loads and bodies bear in a bend at full speed
  double unread_max_m{5.0};      ///< without a tag or a beacon
  std::size_t of_one_code{100};  ///< more are counted, not listed
};

/// Everything that is wrong or odd with a zone that can be read, errors first, then by code and section: gaps and
/// kinks, bends too tight for the vehicle or its speed, stations that cannot be reached from the starts or from another
/// station (closed sections count as gone), ways that end, ways that nothing leads to, long ways without tag or beacon,
/// starts and stations where vehicles are in the way, tracks driven both ways. What make_zone refuses is told by
/// CircuitFactory::faults.
[[nodiscard]] std::vector<Problem> problems(const TrafficZone& zone, const CheckLimits& limits = {});

}  // namespace cosiva::zone
