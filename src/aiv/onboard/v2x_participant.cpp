#include "cosiva/aiv/onboard/v2x_participant.h"

#include <algorithm>
#include <utility>

#include "cosiva/base/archive.h"
#include "cosiva/base/expect.h"
#include "cosiva/wire/in_process/received_intents.h"

namespace cosiva::aiv {
namespace {

/// No other vehicle is near: just often enough that an arriving vehicle is found in time.
constexpr SimDuration alone_period = std::chrono::seconds{1};
constexpr SimDuration moving_period = std::chrono::milliseconds{200};
constexpr SimDuration stopped_period = std::chrono::milliseconds{500};
/// A change is published at once, but never more often than this.
constexpr SimDuration intent_interval_min = std::chrono::milliseconds{100};

}  // namespace

V2xParticipant::V2xParticipant(wire::VehicleId id, bool enabled, Mode mode)
    : id_{std::move(id)}, name_{wire::to_string(id_)}, enabled_{enabled}, mode_{mode}, proxies_{id_, mode.as_values} {}

bool V2xParticipant::update_cell(const DrivingContext& context) {
  const PositionEstimator& estimator = context.vehicle().position();
  if (!enabled_ || !estimator.pose_known()) return false;
  const Point2 here = position(estimator.pose());
  const std::string& map_id = context.zone().name;
  if (cell_ && cell_map_ == map_id && wire::outside_cell_m(*cell_, here) <= wire::v2x_cell_slack_m) return false;
  cell_ = wire::cell_of(here);
  cell_map_ = map_id;
  return true;
}

std::vector<std::string> V2xParticipant::filters() const {
  if (!enabled_ || !cell_) return {};
  return wire::v2x_filters(cell_map_, *cell_);
}

void V2xParticipant::refuse(const wire::Input& input, std::string kind, const std::string& why,
                            wire::Effects& effects) {
  constexpr std::size_t source_bytes = 120;
  errors_.report(std::move(kind), "intent on '" + input.source.substr(0, source_bytes) + "' not used: " + why, effects);
}

void V2xParticipant::on_intent(SimTime now, const wire::Input& input, DrivingContext& context, wire::Effects& effects) {
  // A retained intent is of unknown age. An intent that comes before the pose is known was not subscribed to.
  if (!enabled_ || input.flag || !context.vehicle().position().pose_known()) return;
  const wire::V2xTopic* topic = wire::received_v2x_topic(input.source);
  if (!topic) return;
  auto intent = wire::received_intent(input);
  if (!intent)
    return refuse(input, intent.error().code + " " + intent.error().location, to_string(intent.error()), effects);
  use(now, *topic, std::move(*intent), input, context, effects);
}

void V2xParticipant::on_direct(SimTime now, const wire::V2xSource& source, const wire::Input& input,
                               DrivingContext& context, wire::Effects& effects) {
  if (!enabled_) return;
  if (source.port == wire::v2x_port) on_direct_intent(now, source.sender, input, context, effects);
  if (source.port == wire::claims_port) on_claims(now, source.sender, input, context, effects);
  if (source.port == wire::unit_port) on_status(now, source.sender, input, context, effects);
}

void V2xParticipant::on_direct_intent(SimTime now, const wire::VehicleId& sender, const wire::Input& input,
                                      DrivingContext& context, wire::Effects& effects) {
  if (!context.vehicle().position().pose_known()) return;
  auto intent = wire::received_intent(input);
  if (!intent)
    return refuse(input, intent.error().code + " " + intent.error().location, to_string(intent.error()), effects);
  const wire::Cell cell = wire::cell_of(position((*intent)->pose));
  use(now, {{}, cell, sender}, std::move(*intent), input, context, effects);
}

void V2xParticipant::on_claims(SimTime now, const wire::VehicleId& sender, const wire::Input& input,
                               DrivingContext& context, wire::Effects& effects) {
  CrossingNegotiation* const negotiation = context.negotiation();
  if (negotiation == nullptr) return;
  auto claims = wire::received_claims(input.payload);
  if (!claims)
    return refuse(input, claims.error().code + " " + claims.error().location, to_string(claims.error()), effects);
  if (!negotiation->on_message(now, sender, std::move(*claims)))
    refuse(input, "claims", "claims of another vehicle or map than their sender's", effects);
}

void V2xParticipant::on_status(SimTime now, const wire::VehicleId& sender, const wire::Input& input,
                               DrivingContext& context, wire::Effects& effects) {
  CrossingNegotiation* const negotiation = context.negotiation();
  if (negotiation == nullptr) return;
  auto status = wire::received_status(input.payload);
  if (!status)
    return refuse(input, status.error().code + " " + status.error().location, to_string(status.error()), effects);
  if (!negotiation->on_status(now, sender, std::move(*status)))
    refuse(input, "unit", "a crossing's status of another unit or map than its sender's", effects);
}

void V2xParticipant::publish_claims(SimTime now, DrivingContext& context, wire::Effects& effects) {
  CrossingNegotiation* const negotiation = context.negotiation();
  if (!enabled_ || negotiation == nullptr) return;
  if (const auto claims = negotiation->take_message(now))
    effects.emplace_back(wire::SendBytes{std::string(wire::claims_port), to_json(*claims)});
}

void V2xParticipant::use(SimTime now, const wire::V2xTopic& topic, std::shared_ptr<const wire::Intent> intent,
                         const wire::Input& input, DrivingContext& context, wire::Effects& effects) {
  const Point2 here = position(context.vehicle().position().pose());
  const auto verdict = context.neighbours().receive(now, topic, intent, here);
  using enum Neighbours::Verdict;
  if (verdict == first) requested_ = true;
  if (verdict == taken || verdict == first) {
    proxies_.deliver(now, topic.vehicle);
    if (BaseWatch* const base_watch = context.base_watch()) base_watch->on_intent(now, std::move(intent));
    return;
  }
  // The network repeats and reorders messages, and the vehicle's own intents come back by its subscriptions: no fault.
  // Everyone in the reach of the radio receives what is sent directly.
  const bool own_intent = verdict == own && topic.vehicle == id_;
  const bool far_by_radio = verdict == far && input.kind == wire::InputKind::bytes;
  if (verdict == old || own_intent || far_by_radio) return;
  refuse(input, std::string(to_string(verdict)), std::string(to_string(verdict)), effects);
}

Others V2xParticipant::survey(SimTime now, DrivingContext& context) const {
  const Agent& agent = context.agent();
  const PositionEstimator& position = agent.vehicle().position();
  if (!agent.heeds_others() || !position.known() || position.off_path()) return {};
  return context.neighbours().around(now, agent);
}

void V2xParticipant::publish_intent(SimTime now, DrivingContext& context, bool online, wire::Effects& effects) {
  const Agent& agent = context.agent();
  const bool reaches_others = online || mode_.direct;
  if (!enabled_ || !reaches_others || !cell_ || !agent.vehicle().position().pose_known()) return;
  const SimDuration since = published_at_ ? now - *published_at_ : SimDuration::max();
  if (since >= SimDuration::zero() && since < intent_interval_min) return;
  Neighbours& neighbours = context.neighbours();
  neighbours.age(now);
  const bool alone = neighbours.empty();
  const SimDuration usual_period = agent.vehicle().motion().stopped() ? stopped_period : moving_period;
  const SimDuration period = alone ? alone_period : mode_.dense ? intent_interval_min : usual_period;
  const bool due = requested_ || since >= period || since < SimDuration::zero();
  if (!due && alone) return;
  const zone::TrafficZone& zone = context.zone();
  const auto priority = static_cast<std::uint32_t>(std::clamp(zone.priority_of(name_), 0, zone::priority_max));
  const auto& crossings = context.crossings();
  if (!due && last_intent_.priority == priority && !is_news(last_intent_, agent, zone, crossings)) return;
  wire::Intent intent = compose_intent(agent, zone, crossings);
  intent.vehicle = id_;
  intent.priority = priority;
  COSIVA_EXPECT(since >= intent_interval_min || since < SimDuration::zero());
  requested_ = false;
  published_at_ = now;
  last_intent_ = intent;
  proxies_.send(now, *cell_, std::move(intent), {.broker = online, .direct = mode_.direct}, effects);
}

void V2xParticipant::archive(Archive& archive) {
  archive(cell_, cell_map_, last_intent_, published_at_, requested_, errors_, proxies_);
}

}  // namespace cosiva::aiv
