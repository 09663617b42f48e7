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
#include "cosiva/base/archive_fwd.h"
#include "cosiva/base/digest.h"
#include "cosiva/base/time.h"
#include "cosiva/wire/own/v2x.h"
#include "cosiva/zone/layout/traffic_zone.h"

namespace cosiva::aiv {

/// The intents (wire::Intent) of vehicles nearby, stored for a second after receipt, and their consequences for this
/// vehicle: its leader, and the other vehicle that requests its next crossing. Senders are not trusted: their clocks
/// are not read, impossible messages are refused, and at most `count_max` are stored. Accepted intents may slow a
/// vehicle down or let it approach a crossing at a better time; they never decide whether the vehicle may drive
/// somewhere. Invariant: at most count_max intents are stored, one of each sender, in the order of the senders' names.
class Neighbours {
 public:
  struct Model {
    SimDuration memory_span{std::chrono::seconds{1}};       ///< since receipt
    SimDuration carry_max{std::chrono::milliseconds{500}};  ///< longest extrapolation of a pose
    std::size_t count_max{32};
    /// Largest distance along an axis to a sender: two cells, both sides' slack, and the distance driven meanwhile.
    double near_m{2.0 * wire::v2x_cell_m + 4.0 * wire::v2x_cell_slack_m};
    double speed_ratio_max{3.0};  ///< of the zone's fastest profile; a higher reported speed is implausible
    double leap_m{0.5};           ///< a larger distance beyond what that speed allows is a leap
    BodyGap::Model gap_model{};
  };
  Neighbours(const zone::TrafficZone& zone, wire::VehicleId self) : Neighbours{zone, std::move(self), Model{}} {}
  Neighbours(const zone::TrafficZone& zone, wire::VehicleId self, Model model);

  enum class Verdict : std::uint8_t {
    taken,
    first,  ///< taken, and the first intent of this sender
    old,    ///< no newer than the stored intent: repeated, or overtaken in transit
    own,    ///< the vehicle's own name
    other_map,
    far,          ///< the message could not have been received from there
    implausible,  ///< a speed or a leap that no vehicle here is capable of; the sender's stored intent is discarded
    crowded,      ///< the maximum number is stored, and none of those is further away
  };
  /// @param topic  of the message; a sender that publishes under another name or cell than its own is refused
  /// @param own    position of this vehicle
  Verdict receive(SimTime now, const wire::V2xTopic& topic, std::shared_ptr<const wire::Intent> intent, Point2 own);
  void age(SimTime now);
  void forget() { received_.clear(); }
  [[nodiscard]] std::size_t size() const { return received_.size(); }
  [[nodiscard]] bool empty() const { return received_.empty(); }

  /// @param agent  its position is known and on the path
  [[nodiscard]] Others around(SimTime now, const Agent& agent);

  void fold(Digest& digest) const;
  void archive(Archive& archive);  ///< the state, for a snapshot

 private:
  struct KnownIntent {
    std::shared_ptr<const wire::Intent> intent;  ///< never null; other receivers may refer to the same
    SimTime at{};
  };
  [[nodiscard]] bool leaps(const KnownIntent& before, SimTime now, const wire::Intent& intent) const;
  void find_leader(SimTime now, const Agent& agent, Others& others);
  void find_rivals(SimTime now, const Agent& agent, Others& others);

  const zone::TrafficZone& zone_;
  wire::VehicleId self_;
  Model model_;
  double speed_mps_max_;
  BodyGap gap_;
  CrossingFinder crossing_finder_;
  std::vector<KnownIntent> received_;  ///< sorted by name
  /// None of them was received before `oldest_at_` or after `newest_at_`.
  SimTime oldest_at_{SimTime::max()};
  SimTime newest_at_{SimTime::min()};
  std::vector<CrossingSpan> approached_;
};
[[nodiscard]] std::string_view to_string(Neighbours::Verdict verdict);

}  // namespace cosiva::aiv
