#pragma once

#include <cstddef>
#include <cstdint>
#include <map>
#include <string>
#include <vector>

#include "cosiva/base/archive_fwd.h"
#include "cosiva/base/time.h"
#include "cosiva/virtual/server/registry/registry.h"
#include "cosiva/virtual/simulator/simulator.h"

namespace cosiva::virtual_side {

/// Compares what vehicles report with each other and with the zone, and reports to the bijection monitor: two programs
/// under one name, and tags that vehicles find elsewhere than the zone states.
///
/// Invariant: at most tags_max tags are stored, each with the last vehicle that was displaced at it.
class ReportWatch {
 public:
  /// A vehicle corrects its position at a tag by a few centimetres. By more: the tag, or the vehicle, was moved.
  static constexpr double displaced_m = 0.15;
  static constexpr std::size_t tags_max = 256;  ///< bounds the memory if many invented numbers are received

  ReportWatch(const Registry& registry, Simulator& simulator) : registry_{registry}, simulator_{simulator} {}

  /// A physical vehicle has read the tag that it reports as its last one.
  void on_tag(SimTime now, AivProxy& proxy);
  /// To be called once per tick.
  void tick(SimTime now);
  void archive(Archive& archive);  ///< the state, for a snapshot

 private:
  struct DisplacedTag {
    SimTime since;
    std::string vehicle;
    double shift_m{};
  };
  [[nodiscard]] std::vector<Finding> find(SimTime now) const;

  const Registry& registry_;
  Simulator& simulator_;
  std::map<std::uint32_t, DisplacedTag> tags_;  ///< by number
  std::uint64_t zone_revision_{0};
  bool any_{false};  ///< the monitor has findings from here
};

}  // namespace cosiva::virtual_side
