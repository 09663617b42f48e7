#include "cosiva/virtual/server/core/zone_session.h"

#include <utility>

#include "cosiva/base/archive.h"
#include "cosiva/base/expect.h"

namespace cosiva::virtual_side {
namespace {

/// A broker sends its retained messages at once after a subscription.
constexpr SimDuration retained_within{std::chrono::milliseconds{300}};

/// With the first zone: a base that a vehicle reported before the zone was known counts from now on, not from its next
/// report on, which may be lost.
void adopt_orders(const ServerContext& context, OrderManager& orders, const std::string& zone) {
  for (VehicleIndex v = 0; v < context.registry.size(); ++v) {
    const AivProxy& proxy = context.registry[v];
    const std::string& map_id = proxy.position.map_id();
    if (!proxy.retired() && proxy.state() != nullptr && (map_id.empty() || map_id == zone)) orders.on_state(v, nullptr);
  }
}

}  // namespace

void ZoneSession::receive(const zone::ZoneConfiguration& configuration, Source source) {
  const ZoneEdits::Arrival arrival = edits_.arrives(configuration);
  if (source != Source::given && arrival != ZoneEdits::Arrival::echo) {
    context_.agents.physical_side.deliver(
        context_.traces, context_.now,
        {"zone", configuration.format + ", " + std::to_string(configuration.text.size()) + " bytes",
         configuration.origin, configuration.text});
  }
  const zone::ZoneConfiguration* had = context_.simulator.configuration();
  const bool in_force = had != nullptr && same_content(*had, configuration);
  // What waits was retained before this server published the zone that it receives here.
  const bool outdates_waiting = waiting_ && arrival == ZoneEdits::Arrival::echo;
  if (outdates_waiting && waiting_->format == configuration.format) waiting_.reset();
  const bool confirms = source == Source::retained && (in_force || arrival != ZoneEdits::Arrival::news);
  confirmed_ = confirmed_ || confirms || outdates_waiting;
  switch (arrival) {
    case ZoneEdits::Arrival::echo: return;
    case ZoneEdits::Arrival::stale:
      // A restarted physical side publishes its file; the edits made since then remain in force.
      if (edits_.edited(context_.simulator)) publish();
      return;
    case ZoneEdits::Arrival::news: break;
  }
  if (in_force || waits_for_others(configuration, source)) return;
  if (!take(configuration)) return;
  if (std::exchange(switched_here_, false)) context_.state_stale = true;
  edits_.begin(configuration, ZoneEdits::Origin::broker);
  restore_now();
}

bool ZoneSession::waits_for_others(const zone::ZoneConfiguration& configuration, Source source) {
  // A broker may retain one configuration for each format. They are received in any order: where the one in force is
  // among them, the others are outdated; otherwise the last one counts.
  if (source != Source::retained || context_.simulator.configuration() == nullptr ||
      context_.now - context_.link.up_since() >= retained_within)
    return false;
  waiting_ = configuration;
  return true;
}

void ZoneSession::take_waiting() {
  if (!waiting_ || context_.now - context_.link.up_since() < retained_within) return;
  const zone::ZoneConfiguration configuration = *std::exchange(waiting_, std::nullopt);
  if (!confirmed_) return receive(configuration, Source::published);
  context_.publisher.log('w', "the broker retains another zone besides the one in force, on " + configuration.origin +
                                  "; it is ignored. Clear that topic, or switch to it");
}

void ZoneSession::link_came_up() {
  waiting_.reset();
  confirmed_ = false;
}

void ZoneSession::publish_own() {
  if (context_.options.zone || switched_here_ || edits_.edited(context_.simulator)) publish();
}

bool ZoneSession::take(const zone::ZoneConfiguration& configuration) {
  const auto received = context_.simulator.receive(context_.now, configuration, step_recorder(context_));
  if (!received) {
    ++context_.messages_refused;
    refuse(configuration.origin, to_string(received.error()));
    return false;
  }
  refused_.reset();
  if (*received == Simulator::Reception::same) return true;
  const auto& zone = context_.simulator.zone();
  context_.publisher.log('i', "zone '" + zone->name + "': " + std::to_string(zone->waypoints.size()) + " waypoints, " +
                                  std::to_string(zone->crossings.size()) + " crossings");
  if (*received == Simulator::Reception::same_geometry)
    drive_on(zone);
  else
    start_over(zone);
  vehicles_.apply_priorities();
  augmented_.hosted.zone(context_.now, context_.simulator.rtm());
  COSIVA_EXPECT(map_ && map_->zone().name == zone->name);
  return true;
}

void ZoneSession::drive_on(const std::shared_ptr<const zone::TrafficZone>& zone) {
  // Positions, right of way and orders refer to the sections, which are the same.
  if (!map_ || !map_->take(zone)) return start_over(zone);
  master_.missions.renew();
}

void ZoneSession::start_over(const std::shared_ptr<const zone::TrafficZone>& zone) {
  // Every part drops its references into the old map before the map is destroyed.
  const std::string from = map_ ? map_->zone().name : std::string{};
  master_.deadlocks.forget();
  notify_all(nullptr);
  map_.emplace(zone);
  notify_all(&*map_);
  master_.maps.begin();
  if (!from.empty()) change_.begin(from);
  for (VehicleIndex v = 0; v < context_.registry.size(); ++v) {
    AivProxy& proxy = context_.registry[v];
    if (!proxy.here() || !proxy.position.pose() || !proxy.position.known()) continue;
    // Until its next report, the vehicle is shown on the new zone at its last position, stopped.
    twins_.put(v, context_.now, *proxy.position.pose(), wire::Velocity{});
  }
  if (from.empty()) adopt_orders(context_, master_.orders, map_->zone().name);
}

void ZoneSession::notify_all(const WaypointGraph* graph) {
  master_.traffic.set_map(graph);
  master_.missions.set_map(graph, master_.persisted_missions.take_closed(graph));
  master_.orders.set_map(graph);
  augmented_.pauses.set_map(graph);
  twins_.set_map(graph);
  change_.set_map(graph);
}

void ZoneSession::publish() {
  const zone::ZoneConfiguration* configuration = context_.simulator.configuration();
  if (!context_.link.up() || configuration == nullptr) return;
  const std::string topic = context_.topics.zone_prefix + configuration->format;
  edits_.published(*configuration);
  std::string payload = zone::to_payload(*configuration);
  context_.traces.add(context_.now, "AIV_Server", "*", "zone",
                      configuration->format + ", " + std::to_string(payload.size()) + " bytes", topic, payload);
  context_.publisher.publish(topic, std::move(payload), 1, true);
}

void ZoneSession::apply_edit(EditCommand::Kind kind, const zone::ZoneConfiguration& after) {
  context_.state_stale = true;
  if (kind == EditCommand::Kind::saved) {
    edits_.saved(after);
    return;
  }
  zone::ZoneConfiguration before = *context_.simulator.configuration();
  if (!take(after)) return;
  edits_.done(kind, std::move(before));
  publish();
}

void ZoneSession::switch_to(const zone::ZoneConfiguration& wanted) {
  const zone::ZoneConfiguration* in_force = context_.simulator.configuration();
  const std::string format = in_force == nullptr ? wanted.format : in_force->format;
  if (!take(wanted)) return;
  switched_here_ = true;
  context_.state_stale = true;
  waiting_.reset();
  edits_.begin(wanted, ZoneEdits::Origin::own);
  publish();
  // A program that subscribes later must not find two zones.
  if (context_.link.up() && format != wanted.format)
    context_.publisher.publish(context_.topics.zone_prefix + format, {}, 1, true);
}

Result<void> ZoneSession::check(const SwitchCommand& command) const {
  if (context_.simulator.configuration() != nullptr && same_content(*context_.simulator.configuration(), command.zone))
    return fail("switch.same", "this zone is in force already", "zone");
  // Every program has to be able to build what the server publishes.
  if (auto rtm = context_.simulator.build(command.zone, command.built); !rtm) return tl::unexpected(rtm.error());
  return {};
}

void ZoneSession::refuse(const std::string& origin, const std::string& why) {
  refused_ = Refused{context_.now, origin, why};
  context_.publisher.log('e', "zone configuration refused: " + why +
                                  (context_.simulator.zone() ? "; the previous zone stays in force" : ""));
}

void ZoneSession::restore(std::optional<JsonValue> edited, std::optional<zone::ZoneConfiguration> given) {
  if (given) restored_given_ = std::move(given);
  if (edited) restored_zone_ = std::move(edited);
  if (context_.simulator.zone()) restore_now();
}

void ZoneSession::restore_now() {
  if (!restored_zone_) return;
  const JsonValue memory = std::move(*std::exchange(restored_zone_, std::nullopt));
  ZoneEdits::Restored restored = ZoneEdits::restored(memory, *context_.simulator.configuration());
  // The edited zone had replaced the one that the options give at every start.
  const auto given = std::exchange(restored_given_, std::nullopt);
  if (restored.fit == ZoneEdits::Restored::Fit::another && given && context_.options.zone &&
      same_content(*given, *context_.options.zone) && same_content(*given, *context_.simulator.configuration())) {
    if (!take(restored.base)) return;
    change_.clear();
    switched_here_ = true;
    edits_.begin(restored.base, ZoneEdits::Origin::own);
    restored.fit = ZoneEdits::Restored::Fit::base;
  }
  if (restored.fit == ZoneEdits::Restored::Fit::another) {
    context_.publisher.log('w', "the zone is not the one that the persisted edits were made on; they are skipped");
    return;
  }
  const bool to_be_taken = restored.fit == ZoneEdits::Restored::Fit::base;
  if (to_be_taken && !take(restored.made)) return;
  if (!same_content(restored.made, restored.base)) edits_.restore(std::move(restored));
  if (to_be_taken) publish();
}

void ZoneSession::write_state(JsonWriter& json) const {
  if (switched_here_ || edits_.edited(context_.simulator)) edits_.write_persisted(json.key("zone"), context_.simulator);
  // After a restart the options give the zone from before the switch, which must not replace this one.
  if (switched_here_ && context_.options.zone) zone::write_json(json.key("given"), *context_.options.zone);
}

void ZoneSession::write(JsonWriter& json) const {
  json.key("zone").begin_object().key("name");
  if (context_.simulator.zone())
    json.value(context_.simulator.zone()->name);
  else
    json.null();
  json.field("revision", context_.simulator.zone_revision()).key("closed").begin_array();
  for (const std::string& name : master_.missions.closed().names(master_.missions.map())) json.value(name);
  json.end_array().key("refused");
  if (refused_) {
    json.begin_object()
        .field("origin", refused_->origin)
        .field("why", refused_->why)
        .field("at", to_milliseconds_scaled(refused_->at))
        .end_object();
  } else {
    json.null();
  }
  change_.write(json.key("switched"));
  json.end_object();
}

void ZoneSession::archive(Archive& archive) {
  bool has_map = map_.has_value();
  archive(has_map);
  if (archive.reads() && !archive.failed()) {
    if (has_map != (context_.simulator.zone() != nullptr)) return archive.fail("a waypoint graph without its zone");
    if (has_map) notify_all(&map_.emplace(context_.simulator.zone()));
  }
  archive(change_, edits_, refused_, switched_here_, waiting_, confirmed_, restored_zone_, restored_given_);
}

}  // namespace cosiva::virtual_side
