#pragma once

#include <cstddef>
#include <cstdint>
#include <limits>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "cosiva/aiv/decision/agent.h"
#include "cosiva/aiv/negotiation/unit_watch.h"
#include "cosiva/aiv/order/crossing_finder.h"
#include "cosiva/base/time.h"
#include "cosiva/wire/own/crossing_claims.h"
#include "cosiva/zone/layout/traffic_zone.h"

namespace cosiva::aiv {

/// A vehicle's part in the agreement on crossings: which crossings it claims, to which claims of others it yields, and
/// how far it may drive meanwhile.
///
/// A vehicle that approaches crossings through which its base leads claims them as one chain, with a logical time stamp
/// (Lamport). Another vehicle yields to the claim unless it has a claim of its own for one of these crossings that is
/// granted, or that goes first (the lower stamp, then the higher priority, then the name), or is in one of them. The
/// claim is granted once every vehicle that is known nearby yields to it in a message younger than `fresh`; the vehicle
/// claims them no longer when its body has left the last one. An unresponsive vehicle never yields: then no other
/// vehicle enters a crossing near it. A vehicle that is in a crossing without a claim, since it was started there,
/// makes one with the stamp 0.
///
/// Two vehicles are never granted claims with a common crossing if each knows of the other: each needs the other's
/// yield, and a vehicle that yields to a claim cannot be granted one of its own before it receives that the other claim
/// has ended. A vehicle that has just started listens for `listens` before it claims, so that others are known.
///
/// Crossing units are witnesses: a crossing that a unit reports as occupied by another vehicle is not granted, and not
/// entered though granted, unless that vehicle itself states, in a message younger than `fresh`, that it has no claim
/// for the crossing. Therefore a unit can make vehicles wait, and never lets one go.
///
/// Invariant: the members are in the order of their names; a claim that is granted stays so until it ends.
class CrossingNegotiation {
 public:
  struct Model {
    SimDuration fresh{std::chrono::milliseconds{500}};  ///< maximum age of a message that counts as a yield
    SimDuration listens{std::chrono::seconds{2}};       ///< after the start
    double claims_within_m{0.7};  ///< of the crossing's entry, in addition to the braking distance
    double near_m{4.5};           ///< a member further away has no part in a claim
    std::size_t members_max{200};
  };
  CrossingNegotiation(const zone::TrafficZone& zone, wire::VehicleId self)
      : CrossingNegotiation{zone, std::move(self), Model{}} {}
  CrossingNegotiation(const zone::TrafficZone& zone, wire::VehicleId self, Model model);

  /// @param sender  by whom the message was sent, as the link has verified
  /// @return        false: the message is not used, because its content is not the sender's or of this map
  bool on_message(SimTime now, const wire::VehicleId& sender, std::shared_ptr<const wire::CrossingClaims> message);
  /// The status that a crossing unit sent; the result as of on_message().
  bool on_status(SimTime now, const wire::VehicleId& sender, std::shared_ptr<const wire::CrossingStatus> status) {
    return units_.on_status(now, sender, std::move(status));
  }
  /// One step, before each decision of the agent.
  void update(SimTime now, const Agent& agent);
  /// Along the path to the first crossing that the vehicle may not enter yet; infinite: none is near.
  [[nodiscard]] double barrier_m() const { return barrier_m_; }
  /// The message that is due now, if one is: ten times a second, and at once after a change of claim or yields. None
  /// before the vehicle knows its position on the path: without it, it does not know in which crossings it is.
  [[nodiscard]] std::optional<wire::CrossingClaims> take_message(SimTime now);

  /// The present claim, for reports and tests.
  struct Claim {
    std::uint32_t id{};
    std::uint32_t stamp{};
    bool granted{};
    std::vector<std::size_t> crossings;
    double exit_m{};  ///< of the last one, from the vehicle's position
  };
  [[nodiscard]] const std::optional<Claim>& claim() const { return claim_; }
  [[nodiscard]] std::size_t members() const { return members_.size(); }
  [[nodiscard]] const UnitWatch& units() const { return units_; }

 private:
  struct Member {
    std::shared_ptr<const wire::CrossingClaims> last;  ///< its last message; never null
    SimTime at{};
    bool yielded{};                      ///< this vehicle yields to the claim in `last`
    std::vector<std::size_t> crossings;  ///< of that claim, those that the zone has
  };
  /// A vehicle's crossings one after another, too close for a stop between them.
  struct Chain {
    double entry_m;  ///< of the first one that the vehicle has not entered; infinite: it is in the last one
    double exit_m;
    bool inside;
    std::vector<std::size_t> crossings;
  };
  [[nodiscard]] std::vector<Chain> chains_on_path(const Agent& agent);
  void follow_claim(const Agent& agent, const std::vector<Chain>& chains);
  void make_claim(const Agent& agent, const std::vector<Chain>& chains);
  void yield_where_due();
  [[nodiscard]] bool all_yield(SimTime now) const;
  /// By the report of a crossing unit, another vehicle is in one of them, or holds it.
  [[nodiscard]] bool occupied_by_another(SimTime now, const std::vector<std::size_t>& crossings) const;
  [[nodiscard]] bool goes_first(const Member& member) const;
  [[nodiscard]] std::uint32_t own_priority() const;

  const zone::TrafficZone& zone_;
  wire::VehicleId self_;
  Model model_;
  CrossingFinder finder_;
  std::vector<Member> members_;
  UnitWatch units_;
  std::optional<Claim> claim_;
  std::vector<std::size_t> occupied_;  ///< the crossings that the vehicle's body is in
  std::optional<SimTime> started_at_;
  std::optional<Point2> position_;  ///< nothing: the vehicle takes no part
  struct Counters {
    std::uint32_t clock{0};
    std::uint32_t claim{0};
    std::uint32_t header{0};
  };
  Counters next_;
  bool changed_{true};
  std::optional<SimTime> sent_at_;
  double barrier_m_{0.0};
};

}  // namespace cosiva::aiv
