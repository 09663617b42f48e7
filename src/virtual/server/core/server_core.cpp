#include "cosiva/virtual/server/core/server_core.h"

#include <algorithm>
#include <iterator>
#include <utility>

#include "cosiva/base/json_writer.h"
#include "cosiva/virtual/server/core/inside.h"
#include "cosiva/wire/own/v2x.h"

namespace cosiva::virtual_side {
namespace {

constexpr SimDuration settle_min{std::chrono::milliseconds{300}};
constexpr SimDuration settle_max{std::chrono::seconds{2}};

std::string connection_json(std::string_view state, SimTime now) {
  JsonWriter json;
  json.begin_object().field("connectionState", state).field("timestamp", to_iso8601(now)).end_object();
  return json.take();
}

}  // namespace

ServerCore::Inside::Inside(ServerOptions given)
    : ServerContext{std::move(given)},
      MasterControl{.served = *this},
      AugmentedParts{.server = *this, .master = *this},
      InstrumentParts{.observed = *this} {}

void ServerCore::Inside::begin(SimTime) {
  begun = true;
  if (options.zone) zones.receive(*options.zone, ZoneSession::Source::given);
}

void ServerCore::Inside::on_message(const wire::Input& input) {
  if (input.source.starts_with(wire::v2x_topic_prefix)) return v2x.receive(input);
  if (BatteryDesk::is_ours(input.source)) return on_battery(input);
  if (GvsDesk::is_ours(input.source)) return on_gvs(input);
  if (ownership.receive(input)) return;
  if (!hosted.empty() && hosted.from_broker(now, input)) return;
  if (reports.receive(input)) return;
  const std::string_view topic{input.source};
  if (topic.starts_with(topics.zone_prefix)) {
    const std::string_view format = topic.substr(topics.zone_prefix.size());
    // An empty retained message takes a zone off the broker; the one that runs stays.
    if (!input.payload.empty())
      zones.receive(zone::from_payload(std::string(format), std::string(topic), input.payload),
                    input.flag ? ZoneSession::Source::retained : ZoneSession::Source::published);
  }
}

/// Every hall's page shows it: who changes batteries stands anywhere.
void ServerCore::Inside::on_battery(const wire::Input& input) {
  const auto news = batteries.on_message(input);
  if (news) {
    if (!news->empty()) traces.add(now, "battery test", "*", "battery", *news, input.source, input.payload);
    return;
  }
  refuse_unknown_sender(*this, input.source, to_string(news.error()));
}

void ServerCore::Inside::on_gvs(const wire::Input& input) {
  const auto news = gvs.on_message(now, input);
  if (!news) return refuse_unknown_sender(*this, input.source, to_string(news.error()));
  if (!news->empty()) traces.add(now, "GVS", "AIV_Server", "gvs", *news, input.source, input.payload);
}

void ServerCore::Inside::on_link(bool up) {
  if (up == link.up()) return;
  if (up)
    link.came_up(now);
  else
    link.went_down();
  hosted.link(now, up);
  if (!up) {
    zones.link_went_down();
    publisher.log('w', "lost the broker; vehicles stop by themselves until it is back");
    return;
  }
  link.up_since() = now;
  zones.link_came_up();
  areas.link_up();
  batteries.link_up();
  for (AivProxy& proxy : registry) proxy.state_since_link = false;
  std::string online = connection_json("ONLINE", now);
  traces.add(now, "AIV_Server", "*", "connection", "ONLINE", topics.connection, online);
  hosted.message(now, std::string(wire::server_connection_topic), online);
  publisher.publish(topics.connection, std::move(online), 1, true);
  zones.publish_own();
}

bool ServerCore::Inside::settled() const {
  const SimDuration since = now - link.up_since();
  if (since >= settle_max) return true;
  if (since < settle_min) return false;
  // A vehicle that drives on an order of our last life must be heard before anyone is sent into its way.
  return std::ranges::all_of(registry, [](const AivProxy& proxy) {
    return proxy.retired || proxy.connection != wire::ConnectionState::online || proxy.state_since_link;
  });
}

void ServerCore::Inside::settle() {
  link.set_synchronised();
  if (areas.several()) {
    world.drop_restored();
    ownership.publish_lost_owners();
  }
  world.place_restored();
  world.sign_off_orphans();
}

void ServerCore::Inside::on_tick() {
  if (auto heartbeat = link.take_heartbeat(now)) {
    traces.add(now, "AIV_Server", "*", "heartbeat", *heartbeat, topics.heartbeat, *heartbeat);
    hosted.message(now, std::string(wire::server_heartbeat_topic), *heartbeat);
    publisher.publish(topics.heartbeat, std::move(*heartbeat), 0, false);
  }
  hosted.tick(now);
  zones.take_waiting();
  if (link.up() && !link.synchronised() && settled()) settle();
  if (link.synchronised()) {
    follow_up.request_missing();
    traffic.set_time(now);
    zones.change().follow();
    orders.tick(options.drive, zones.change().may_send_orders(), options.lost_after);
    deadlocks.tick();
    ownership.claim_and_hand_over();
  }
  world.update();
  world.remove_passed_obstacles();
  actions.tick(registry, link.up());
  commands.tick();

  gvs.tick(now, !areas.several());
  BijectionMonitor& monitor = simulator.monitor();
  if (ticked_at) monitor.late(std::max(0.0, to_seconds(now - *ticked_at - options.cycle) * 1e3));
  ticked_at = now;
  for (const AivProxy& proxy : registry) {
    // One that said goodbye owes no reports.
    if (proxy.present && !proxy.augmented && proxy.connection != wire::ConnectionState::offline)
      monitor.age(proxy.entity, to_seconds(now - proxy.reported_at) * 1e3);
  }
  monitor.elapse(now);
}

ServerCore::ServerCore(ServerOptions options) : inside_{std::make_unique<Inside>(std::move(options))} {}
ServerCore::~ServerCore() = default;

void ServerCore::handle(const wire::Input& input, wire::Effects& effects) {
  Inside& in = *inside_;
  in.now = input.at;
  in.publisher.open(input.at, effects);
  if (!in.begun) in.begin(input.at);
  switch (input.kind) {
    case wire::InputKind::message: in.on_message(input); break;
    case wire::InputKind::tick: in.on_tick(); break;
    case wire::InputKind::link: in.on_link(input.payload == "up"); break;
    case wire::InputKind::command:
      in.traces.add(input.at, input.source.empty() ? "operator" : input.source, "AIV_Server", "command", input.payload,
                    {}, input.payload);
      in.router.run(input.payload);
      break;
    case wire::InputKind::recall: in.persisted.restore(input.payload); break;
    case wire::InputKind::configure:
    case wire::InputKind::bytes:
    case wire::InputKind::port: break;  // its options came with its construction; it has no streams
  }
  in.persisted.persist_if_stale();
}

std::vector<std::string> ServerCore::subscriptions() const {
  const std::string& prefix = inside_->topic_prefix;
  const std::string hosted = prefix + "v2/" + std::string(wire::virtual_manufacturer) + "/+/";
  std::vector<std::string> filters{prefix + "+/+/+/state",
                                   prefix + "+/+/+/visualization",
                                   prefix + "+/+/+/connection",
                                   prefix + "+/+/+/factsheet",
                                   wire::topics_below(wire::zone_topic_prefix, 1),
                                   wire::topics_below(wire::felt_topic_prefix, 2),
                                   wire::topics_below(wire::seen_topic_prefix, 2),
                                   wire::topics_below(wire::boards_topic_prefix, 2),
                                   wire::topics_below(wire::v2x_topic_prefix, wire::v2x_topic_levels),
                                   hosted + "order",
                                   hosted + "instantActions"};
  std::ranges::move(BatteryDesk::subscriptions(), std::back_inserter(filters));
  std::ranges::move(GvsDesk::subscriptions(), std::back_inserter(filters));
  if (!inside_->areas.several()) return filters;
  // Its zone comes with those of the other halls.
  std::erase(filters, wire::topics_below(wire::zone_topic_prefix, 1));
  const std::string hall{wire::hall_topic_prefix};
  filters.insert(filters.end(),
                 {hall + "+/zone/+", hall + "+/server/connection", wire::topics_below(wire::owner_topic_prefix, 2)});
  return filters;
}

std::optional<wire::Will> ServerCore::will() const {
  return wire::Will{{inside_->topics.connection, connection_json("CONNECTIONBROKEN", inside_->now), 1, true}};
}

void ServerCore::farewell(SimTime now, wire::Effects& effects) {
  inside_->publisher.open(now, effects);
  inside_->hosted.farewell(now);
  effects.emplace_back(wire::Publish{inside_->topics.connection, connection_json("OFFLINE", now), 1, true});
  inside_->traces.add(now, "AIV_Server", "*", "connection", "OFFLINE");
}

void ServerCore::fold(Digest& digest) const {
  const Inside& in = *inside_;
  in.simulator.fold(digest);
  in.traffic.fold(digest);
  in.orders.fold(digest);
  in.deadlocks.fold(digest);
  in.missions.fold(digest);
  in.commands.fold(digest);
  for (const AivProxy& proxy : in.registry) {
    digest.add(std::string_view{proxy.name});
    digest.add(std::uint64_t{proxy.number});
    digest.add(proxy.messages);
    digest.add(proxy.headers_missed);
    digest.add(proxy.refused);
    digest.add(proxy.outdated);
    digest.add(static_cast<std::int64_t>(proxy.priority));
    digest.add(static_cast<std::uint64_t>(proxy.retired) * 2 + static_cast<std::uint64_t>(proxy.paused_for_body));
  }
  in.hosted.fold(digest);
  in.virtual_obstacles.fold(digest);
  in.zones.edits().fold(digest);
  in.areas.fold(digest);
  in.gvs.fold(digest);
  digest.add(in.messages_refused);
  digest.add(in.traces.next());
}

SimDuration ServerCore::tick_period() const { return inside_->options.cycle; }

Result<void> ServerCore::check_command(std::string_view json) const { return inside_->router.check(json); }

std::string ServerCore::snapshot_json() const { return inside_->view.snapshot_json(); }
std::string ServerCore::summary_json() const { return inside_->view.summary_json(); }
ServerCore::PageRevision ServerCore::page_revision() const { return inside_->view.page_revision(); }
void ServerCore::positions(SimTime now, std::vector<PositionRecord>& out) const {
  inside_->position_view.positions(now, out);
}
void ServerCore::write_bijection(JsonWriter& json) const { inside_->simulator.monitor().write(json); }
std::string ServerCore::traces_json(std::uint64_t after, std::size_t limit) const {
  return inside_->traces.to_json(after, limit);
}
std::optional<std::string> ServerCore::trace_json(std::uint64_t n) const { return inside_->traces.one_json(n); }
std::string ServerCore::next_command_id() const { return inside_->commands.next_free_id(); }

std::uint64_t ServerCore::zone_revision() const { return inside_->simulator.zone_revision(); }
std::string ServerCore::zone_json() const { return inside_->simulator.zone_json(); }
std::string ServerCore::next_thing_id(std::string_view kind) const { return inside_->objects.next_id(kind); }
std::optional<std::string> ServerCore::battery_curve_json(const std::string& vehicle) const {
  return inside_->batteries.curve_json(vehicle);
}
std::shared_ptr<const zone::TrafficZone> ServerCore::zone() const { return inside_->simulator.zone(); }

std::optional<zone::ZoneConfiguration> ServerCore::zone_configuration() const {
  const zone::ZoneConfiguration* configuration = inside_->simulator.configuration();
  return configuration == nullptr ? std::nullopt : std::optional{*configuration};
}

}  // namespace cosiva::virtual_side
