#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "cosiva/aiv/motion/speed.h"
#include "cosiva/aiv/order/crossing_finder.h"
#include "cosiva/aiv/perception/body_gap.h"
#include "cosiva/aiv/v2x/intent.h"
#include "cosiva/base/digest.h"
#include "cosiva/base/time.h"
#include "cosiva/wire/own/v2x.h"
#include "cosiva/zone/layout/traffic_zone.h"

namespace cosiva::aiv {

/// What those near a vehicle have said of themselves (wire::Intent), for a second after they said it, and what follows
/// from it for the vehicle: who drives before it and who else wants its next crossing. Strangers are not trusted: their
/// clocks are not read, what cannot be is refused, and at most `count_max` are kept. What is left may make a vehicle
/// slower or let it come up to a crossing in better time; whether it may go somewhere is never asked here.
class Neighbours {
 public:
  struct Model {
    SimDuration memory_span{std::chrono::seconds{1}};       ///< since it arrived
    SimDuration carry_max{std::chrono::milliseconds{500}};  ///< a pose is carried on no longer
    std::size_t count_max{32};
    /// Nobody further off along an axis can be heard: two cells, both sides' slack, and what they drive meanwhile.
    double near_m{2.0 * wire::v2x_cell_m + 4.0 * wire::v2x_cell_slack_m};
    double speed_ratio_max{3.0};  ///< of the zone's fastest profile; who claims more is not believed
    double leap_m{0.5};           ///< more than that beyond what that speed allows is a leap
    BodyGap::Model gap_model{};
  };
  Neighbours(const zone::TrafficZone& zone, wire::VehicleId self) : Neighbours{zone, std::move(self), Model{}} {}
  Neighbours(const zone::TrafficZone& zone, wire::VehicleId self, Model model);

  enum class Verdict : std::uint8_t {
    taken,
    first,  ///< taken, and nobody had been heard of this name
    old,    ///< no newer than what is known: repeated, or overtaken on the way
    own,    ///< its own name
    other_map,
    far,          ///< nobody could have heard it from there
    implausible,  ///< a speed or a leap that no vehicle here can do; what was known of it is forgotten
    crowded,      ///< one more than are kept, and none of those is further away
  };
  /// @param topic  under which it came; who speaks under another name or cell than his own is not believed
  /// @param own    where this vehicle is
  Verdict receive(SimTime now, const wire::V2xTopic& topic, std::shared_ptr<const wire::Intent> intent, Point2 own);
  void age(SimTime now);
  void forget() { received_.clear(); }
  [[nodiscard]] std::size_t size() const { return received_.size(); }
  [[nodiscard]] bool empty() const { return received_.empty(); }

  /// @param agent  whose place is known and on the line
  [[nodiscard]] Others around(SimTime now, const Agent& agent);

  void fold(Digest& digest) const;

 private:
  struct KnownIntent {
    std::shared_ptr<const wire::Intent> intent;  ///< never none; others may have heard the same
    SimTime at{};
  };
  [[nodiscard]] bool leaps(const KnownIntent& before, SimTime now, const wire::Intent& intent) const;
  void find_leader(SimTime now, const Agent& agent, Others& others);
  void find_rivals(SimTime now, const Agent& agent, Others& others);
  [[nodiscard]] wire::Body body_of(const wire::Intent& intent) const;

  const zone::TrafficZone& zone_;
  wire::VehicleId self_;
  Model model_;
  double speed_mps_max_;
  BodyGap gap_;
  CrossingFinder crossing_finder_;
  std::vector<KnownIntent> received_;  ///< sorted by name
  std::vector<CrossingSpan> ahead_;
};
[[nodiscard]] std::string_view to_string(Neighbours::Verdict verdict);

}  // namespace cosiva::aiv
