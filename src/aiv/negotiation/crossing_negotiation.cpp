#include "cosiva/aiv/negotiation/crossing_negotiation.h"

#include <algorithm>
#include <cmath>
#include <tuple>
#include <utility>

#include "cosiva/base/expect.h"

namespace cosiva::aiv {
namespace {

constexpr double infinite = std::numeric_limits<double>::infinity();
/// Beyond this no crossing matters to a vehicle: more than its braking distance and claims_within_m.
constexpr double reach_m = 2.5;
constexpr std::size_t spans_max = 32;
/// The exit of a chain as it was computed last, and the distance driven since, with corrections of the position.
constexpr double same_exit_m = 0.3;
constexpr double rounding_m = 0.005;
constexpr SimDuration period = std::chrono::milliseconds{100};
constexpr SimDuration interval_min = std::chrono::milliseconds{20};

bool newer(std::uint32_t a, std::uint32_t b) { return static_cast<std::int32_t>(a - b) > 0; }

auto key_of(const wire::VehicleId& id) { return std::tie(id.manufacturer, id.serial_number); }

bool have_common(const std::vector<std::size_t>& a, const std::vector<std::size_t>& b) {
  return std::ranges::any_of(a, [&](std::size_t x) { return std::ranges::find(b, x) != b.end(); });
}

bool contains_all(const std::vector<std::size_t>& all, const std::vector<std::size_t>& some) {
  return std::ranges::all_of(some, [&](std::size_t x) { return std::ranges::find(all, x) != all.end(); });
}

}  // namespace

CrossingNegotiation::CrossingNegotiation(const zone::TrafficZone& zone, wire::VehicleId self, Model model)
    : zone_{zone}, self_{std::move(self)}, model_{model}, finder_{zone}, units_{zone.name} {
  COSIVA_EXPECT(model.fresh > period && model.members_max > 0 && model.near_m > 0.0);
}

bool CrossingNegotiation::on_message(SimTime now, const wire::VehicleId& sender,
                                     std::shared_ptr<const wire::CrossingClaims> message) {
  if (sender == self_) return true;
  if (message->vehicle != sender || message->map_id != zone_.name) return false;
  const auto name = [](const Member& m) { return key_of(m.last->vehicle); };
  auto known = std::ranges::lower_bound(members_, key_of(sender), {}, name);
  const bool is_new = known == members_.end() || known->last->vehicle != sender;
  if (!is_new && !newer(message->header_id, known->last->header_id)) return true;
  if (is_new) {
    // With a vehicle too many no claim is granted: see all_yield().
    if (members_.size() > model_.members_max) return true;
    known = members_.insert(known, Member{message, now, false, {}});
  }
  const bool same_claim =
      !is_new && known->last->claim && message->claim && known->last->claim->id == message->claim->id;
  known->yielded = known->yielded && same_claim;
  known->at = now;
  known->last = std::move(message);
  known->crossings.clear();
  next_.clock = std::max(next_.clock, known->last->clock);
  if (known->last->claim) {
    next_.clock = std::max(next_.clock, known->last->claim->stamp);
    for (std::size_t x = 0; x < zone_.crossings.size(); ++x)
      if (std::ranges::find(known->last->claim->crossings, zone_.crossings[x].name) !=
          known->last->claim->crossings.end())
        known->crossings.push_back(x);
  }
  return true;
}

std::vector<CrossingNegotiation::Chain> CrossingNegotiation::chains_on_path(const Agent& agent) {
  std::vector<CrossingSpan> spans;
  finder_.ahead(agent.vehicle().position().outlook(), reach_m, spans_max, spans);
  std::vector<Chain> chains;
  occupied_.clear();
  for (const CrossingSpan& span : spans) {
    if (chains.empty() || std::fabs(chains.back().exit_m - span.chain_exit_m) > 1e-9)
      chains.push_back({infinite, span.chain_exit_m, false, {}});
    Chain& chain = chains.back();
    chain.crossings.push_back(span.crossing);
    if (span.entry_m > 0.0) {
      chain.entry_m = std::min(chain.entry_m, span.entry_m);
    } else {
      chain.inside = true;
      occupied_.push_back(span.crossing);
    }
  }
  return chains;
}

void CrossingNegotiation::follow_claim(const Agent& agent, const std::vector<Chain>& chains) {
  if (!claim_) return;
  const auto same = std::ranges::find_if(chains, [&](const Chain& chain) {
    return contains_all(claim_->crossings, chain.crossings) && std::fabs(chain.exit_m - claim_->exit_m) < same_exit_m;
  });
  const VehicleState& vehicle = agent.vehicle();
  const bool on_path = same != chains.end();
  const bool waits = on_path && !same->inside && (!claim_->granted || vehicle.motion().stopped());
  const bool goes_on = vehicle.holds().bits() == 0 && !vehicle.progress().cancelling() && vehicle.order().active();
  if (on_path) claim_->exit_m = same->exit_m;
  if (on_path && (!waits || goes_on)) return;
  claim_.reset();
  changed_ = true;
}

void CrossingNegotiation::make_claim(const Agent& agent, const std::vector<Chain>& chains) {
  if (claim_ || chains.empty()) return;
  const Chain& next = chains.front();
  const VehicleState& vehicle = agent.vehicle();
  if (!next.inside) {
    const double speed_mps = vehicle.motion().speed_mps();
    const double braking_m = speed_mps * speed_mps / (2.0 * zone_.profiles.slow.braking_mps2);
    const double base_m = vehicle.order().distance_to_base_end_m();
    const bool ends_there = !vehicle.order().horizon_left() && base_m > next.entry_m;
    const bool leads_through = base_m >= next.exit_m - rounding_m || ends_there;
    const bool goes_on = vehicle.holds().bits() == 0 && !vehicle.progress().cancelling() && vehicle.order().active();
    if (!goes_on || !leads_through || next.entry_m > braking_m + model_.claims_within_m) return;
  }
  if (next.crossings.size() > wire::CrossingClaims::crossings_max) return;
  claim_ = Claim{++next_.claim, next.inside ? 0 : ++next_.clock, false, next.crossings, next.exit_m};
  changed_ = true;
}

std::uint32_t CrossingNegotiation::own_priority() const {
  return static_cast<std::uint32_t>(std::clamp(zone_.priority_of(wire::to_string(self_)), 0, zone::priority_max));
}

bool CrossingNegotiation::goes_first(const Member& member) const {
  const wire::CrossingClaims::Claim& theirs = *member.last->claim;
  const std::uint32_t priority = own_priority();
  if (theirs.stamp != claim_->stamp) return theirs.stamp < claim_->stamp;
  if (theirs.priority != priority) return theirs.priority > priority;
  return key_of(member.last->vehicle) < key_of(self_);
}

void CrossingNegotiation::yield_where_due() {
  for (Member& member : members_) {
    if (!member.last->claim || member.yielded) continue;
    const bool both = claim_ && have_common(claim_->crossings, member.crossings);
    if (both && (claim_->granted || !goes_first(member))) continue;
    if (have_common(occupied_, member.crossings)) continue;
    member.yielded = true;
    changed_ = true;
  }
}

bool CrossingNegotiation::all_yield(SimTime now) const {
  if (now - *started_at_ < model_.listens || members_.size() > model_.members_max) return false;
  return std::ranges::all_of(members_, [&](const Member& member) {
    const bool contends = member.last->claim && have_common(member.crossings, claim_->crossings);
    if (contends && member.yielded) return false;
    if (!contends && distance(member.last->position, *position_) > model_.near_m) return true;
    if (now - member.at >= model_.fresh || now < member.at) return false;
    return std::ranges::any_of(member.last->yields, [&](const wire::CrossingClaims::Yield& yield) {
      return yield.claim == claim_->id && yield.vehicle == self_;
    });
  });
}

bool CrossingNegotiation::occupied_by_another(SimTime now, const std::vector<std::size_t>& crossings) const {
  const auto disproved = [&](const wire::VehicleId& holder, std::size_t crossing) {
    const auto name = [](const Member& m) { return key_of(m.last->vehicle); };
    const auto known = std::ranges::lower_bound(members_, key_of(holder), {}, name);
    if (known == members_.end() || known->last->vehicle != holder) return false;
    return now >= known->at && now - known->at < model_.fresh &&
           std::ranges::find(known->crossings, crossing) == known->crossings.end();
  };
  return std::ranges::any_of(crossings, [&](std::size_t crossing) {
    return std::ranges::any_of(units_.holders(now, zone_.crossings[crossing].name),
                               [&](const wire::CrossingStatus::Vehicle& holder) {
                                 return holder.vehicle != self_ && !disproved(holder.vehicle, crossing);
                               });
  });
}

void CrossingNegotiation::update(SimTime now, const Agent& agent) {
  const PositionEstimator& position = agent.vehicle().position();
  if (!started_at_) {
    started_at_ = now;
    // A claim that a yield from before a restart names must not be made again, and messages are counted on.
    next_.claim = next_.header = static_cast<std::uint32_t>(now.time_since_epoch() / std::chrono::milliseconds{1});
  }
  if (!position.known() || position.off_path()) {
    // Which crossings the vehicle is in is not known: it sends nothing, and no other vehicle enters one near it.
    position_.reset();
    claim_.reset();
    barrier_m_ = position.known() ? infinite : 0.0;
    return;
  }
  position_ = cosiva::position(position.pose());
  const std::vector<Chain> chains = chains_on_path(agent);
  follow_claim(agent, chains);
  make_claim(agent, chains);
  yield_where_due();
  if (claim_ && !claim_->granted && all_yield(now) && !occupied_by_another(now, claim_->crossings)) {
    claim_->granted = true;
    changed_ = true;
  }
  barrier_m_ = infinite;
  for (const Chain& chain : chains) {
    const bool granted = claim_ && claim_->granted && std::fabs(chain.exit_m - claim_->exit_m) < 1e-9;
    // Inside of the first crossing of a chain there is no room for a stop before the next one.
    const bool occupied = granted && !chain.inside && occupied_by_another(now, chain.crossings);
    if (!granted || occupied) barrier_m_ = std::min(barrier_m_, chain.entry_m);
  }
  COSIVA_EXPECT(barrier_m_ > 0.0);
}

std::optional<wire::CrossingClaims> CrossingNegotiation::take_message(SimTime now) {
  if (!position_) return std::nullopt;
  const SimDuration since = sent_at_ ? now - *sent_at_ : SimDuration::max();
  const bool due = since >= period || since < SimDuration::zero() || (changed_ && since >= interval_min);
  if (!due) return std::nullopt;
  sent_at_ = now;
  changed_ = false;
  wire::CrossingClaims message;
  message.header_id = ++next_.header;
  message.timestamp = now;
  message.map_id = zone_.name;
  message.vehicle = self_;
  message.position = *position_;
  message.clock = next_.clock;
  if (claim_) {
    message.claim = wire::CrossingClaims::Claim{claim_->id, claim_->stamp, own_priority(), claim_->granted, {}};
    for (const std::size_t x : claim_->crossings) message.claim->crossings.push_back(zone_.crossings[x].name);
  }
  for (const Member& member : members_)
    if (member.yielded && member.last->claim && message.yields.size() < wire::CrossingClaims::yields_max)
      message.yields.push_back({member.last->vehicle, member.last->claim->id});
  return message;
}

}  // namespace cosiva::aiv
