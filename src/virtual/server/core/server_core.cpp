#include "cosiva/virtual/server/core/server_core.h"

#include <algorithm>
#include <utility>

#include "cosiva/base/archive.h"
#include "cosiva/base/expect.h"
#include "cosiva/base/json_writer.h"
#include "cosiva/virtual/server/context/server_parts.h"
#include "cosiva/virtual/server/core/broker_session.h"
#include "cosiva/virtual/server/core/command_router.h"
#include "cosiva/virtual/server/core/message_intake.h"
#include "cosiva/virtual/server/core/ownership.h"
#include "cosiva/virtual/server/core/persisted_state.h"
#include "cosiva/virtual/server/core/report_follow_up.h"
#include "cosiva/virtual/server/core/server_view.h"
#include "cosiva/virtual/server/core/virtual_world.h"
#include "cosiva/virtual/server/core/zone_session.h"
#include "cosiva/virtual/server/reports/twin_placement.h"
#include "cosiva/virtual/server/reports/vehicle_lifecycle.h"
#include "cosiva/virtual/server/reports/vehicle_reports.h"
#include "cosiva/wire/runtime/snapshot.h"

namespace cosiva::virtual_side {
namespace {

constexpr std::string_view core_name = "server";
constexpr SimDuration earlier_commands_wait_max{std::chrono::seconds{5}};

std::uint64_t digest_of(const ServerOptions& options) {
  Digest digest;
  digest.add(std::string_view{to_json(options)});
  return digest.value();
}

}  // namespace

/// The server's parts, and the order in which an input reaches them.
struct ServerCore::Impl {
  ServerParts parts;
  VehicleLifecycle vehicles{parts.context, parts.master, parts.augmented};
  TwinPlacement twins{parts.context, parts.master};
  ZoneSession zones{parts.context, parts.master, parts.augmented, vehicles, twins};
  VehicleReports reports{parts.context, parts.master, parts.augmented, parts.instruments, vehicles, twins};
  Ownership ownership{parts.context, parts.master, vehicles, twins, reports, zones};
  VirtualWorld world{parts.context, parts.augmented, vehicles};
  CommandRouter router{parts.context, parts.master, parts.augmented, parts.instruments, vehicles, zones, world};
  PersistedState persisted{parts.context, parts.master, parts.augmented, vehicles, zones, world};
  ReportFollowUp follow_up{parts.context, parts.master, zones};
  MessageIntake intake{parts.context, parts.augmented, parts.instruments, ownership, reports, zones};
  BrokerSession broker{parts.context, parts.augmented, parts.instruments, zones, ownership, world};
  ServerView view{parts.context, parts.master, parts.augmented, zones, parts.instruments};
  std::optional<SimTime> ticked_at{};
  struct Beginning {
    std::optional<SimTime> at{};
    bool takes_earlier_commands{false};
  };
  Beginning beginning{};

  void archive(Archive& archive);
  void on_command(const wire::Input& input);
  void on_tick();
  void drive();
  void account_for_cycle();
};

/// What follows from the options is not stored. The zone comes before everything that refers to its waypoint graph.
void ServerCore::Impl::archive(Archive& archive) {
  ServerContext& context = parts.context;
  archive(context.now, context.link, context.areas, context.traces, context.publisher, context.registry,
          context.simulator, context.state_stale, context.messages_refused);
  UnknownSenders& unknown = context.unknown_senders;
  archive(unknown.logged, unknown.logged_at, unknown.unlogged, unknown.excess, unknown.excess_at);
  archive(zones);
  MasterControl& master = parts.master;
  archive(master.traffic, master.actions, master.missions, master.persisted_missions, master.awaited, master.orders,
          master.deadlocks, master.maps, master.intentions, master.command_ids, master.commands, master.enforcer);
  AugmentedParts& augmented = parts.augmented;
  archive(augmented.hosted, augmented.restored, augmented.pauses, augmented.virtual_obstacles);
  archive(context.agents);
  archive(parts.instruments.batteries, parts.instruments.gvs, parts.instruments.reports);
  archive(vehicles, persisted, ticked_at, beginning.at, beginning.takes_earlier_commands);
}

void ServerCore::Impl::on_command(const wire::Input& input) {
  const std::string_view from = input.source.empty() ? std::string_view{"operator"} : std::string_view{input.source};
  parts.context.traces.add(input.at, from, "AIV_Server", "command", input.payload, {}, input.payload);
  // An input from a journal, a scenario or the command line is text only.
  const auto* decoded = dynamic_cast<const DecodedCommand*>(input.typed.get());
  if (decoded != nullptr) return router.run(*decoded, input.flag);
  router.run(DecodedCommand{input.payload}, input.flag);
}

void ServerCore::Impl::on_tick() {
  ServerContext& context = parts.context;
  broker.send_heartbeat();
  parts.augmented.hosted.tick(context.now);
  vehicles.remove_expired();
  zones.take_waiting();
  broker.synchronise_if_due();
  if (context.link.synchronised()) drive();
  world.update();
  world.remove_passed_obstacles();
  parts.master.actions.tick(context.registry, context.link.up());
  parts.master.commands.tick();
  InstrumentParts& instruments = parts.instruments;
  instruments.gvs.tick(context.now, !context.areas.several());
  instruments.presence.tick(context.now);
  instruments.reports.tick(context.now);
  if (const auto left = instruments.presence.departed(context.now))
    vehicles.depart(*left, "GVS", "the camera has detected no vehicle at its position for 5 s");
  account_for_cycle();
}

void ServerCore::Impl::drive() {
  const ServerContext& context = parts.context;
  follow_up.request_missing();
  parts.master.traffic.set_time(context.now);
  zones.change().follow();
  parts.master.enforcer.tick();
  const bool drive = parts.master.awaited.have_reported() && context.options.drive;
  parts.master.orders.tick(drive, zones.change().may_send_orders(), context.options.lost_after);
  parts.master.deadlocks.tick();
  ownership.claim_and_hand_over();
}

void ServerCore::Impl::account_for_cycle() {
  const ServerContext& context = parts.context;
  BijectionMonitor& monitor = parts.context.simulator.monitor();
  if (ticked_at)
    monitor.late(std::max(0.0, to_milliseconds_by_seconds(context.now - *ticked_at - context.options.cycle)));
  ticked_at = context.now;
  for (const AivProxy& proxy : context.registry) {
    // A vehicle that reported OFFLINE is not expected to report.
    if (proxy.twin_link.present() && !proxy.augmented() && proxy.connection.state() != wire::ConnectionState::offline)
      monitor.age(proxy.twin_link.entity(), to_milliseconds_by_seconds(context.now - proxy.reports.reported_at()));
  }
  monitor.elapse(context.now);
}

ServerCore::ServerCore(ServerOptions options)
    : impl_{new Impl{.parts = {.context = {.options = std::move(options)}}}} {}
ServerCore::~ServerCore() = default;

void ServerCore::handle(const wire::Input& input, wire::Effects& effects) {
  Impl& impl = *impl_;
  ServerContext& context = impl.parts.context;
  context.now = input.at;
  context.publisher.open(input.at, effects);
  const bool first = !impl.beginning.at;
  if (first) impl.beginning.at = input.at;
  if (first && context.options.zone) impl.zones.receive(*context.options.zone, ZoneSession::Source::given);
  switch (input.kind) {
    case wire::InputKind::message: impl.intake.receive(input); break;
    case wire::InputKind::tick: impl.on_tick(); break;
    case wire::InputKind::link: impl.broker.on_link(input.payload == "up"); break;
    case wire::InputKind::command: impl.on_command(input); break;
    case wire::InputKind::restore: impl.persisted.restore(input.payload); break;
    case wire::InputKind::configure:
    case wire::InputKind::bytes:
    case wire::InputKind::port: break;  // the options are given at construction, and the server has no streams
    case wire::InputKind::proposal:
    case wire::InputKind::persisted:
    case wire::InputKind::snapshot: break;  // of a store, which gives them to no core
  }
  impl.persisted.persist_if_stale();
  impl.beginning.takes_earlier_commands = impl.beginning.takes_earlier_commands ||
                                          context.now - *impl.beginning.at > earlier_commands_wait_max ||
                                          (context.link.synchronised() && context.simulator.zone() != nullptr);
  COSIVA_EXPECT(context.now == input.at && context.publisher.now() == input.at);
}

std::vector<std::string> ServerCore::subscriptions() const { return impl_->broker.subscriptions(); }
std::optional<wire::Will> ServerCore::will() const { return impl_->broker.will(); }
bool ServerCore::takes_earlier_command(std::string_view json) const {
  if (!impl_->beginning.takes_earlier_commands) return false;
  return impl_->parts.context.simulator.zone() != nullptr || !needs_zone(DecodedCommand{json});
}
void ServerCore::farewell(SimTime now, wire::Effects& effects) { impl_->broker.farewell(now, effects); }

void ServerCore::fold(Digest& digest) const {
  const ServerContext& context = impl_->parts.context;
  const MasterControl& master = impl_->parts.master;
  const AugmentedParts& augmented = impl_->parts.augmented;
  context.simulator.fold(digest);
  master.traffic.fold(digest);
  master.orders.fold(digest);
  master.deadlocks.fold(digest);
  master.missions.fold(digest);
  master.commands.fold(digest);
  master.command_ids.fold(digest);
  for (const AivProxy& proxy : context.registry) {
    digest.add(std::string_view{proxy.name()});
    digest.add(std::uint64_t{proxy.identity.number()});
    digest.add(proxy.counters.messages());
    digest.add(proxy.counters.missed());
    digest.add(proxy.counters.refused());
    digest.add(proxy.counters.outdated());
    if (proxy.counters.dropped() > 0) digest.add(proxy.counters.dropped());
    digest.add(static_cast<std::int64_t>(proxy.settings.priority()));
    digest.add(static_cast<std::uint64_t>(proxy.retired()) * 2 +
               static_cast<std::uint64_t>(proxy.settings.paused_for_body()));
  }
  augmented.hosted.fold(digest);
  augmented.virtual_obstacles.fold(digest);
  impl_->zones.edits().fold(digest);
  context.areas.fold(digest);
  impl_->parts.instruments.gvs.fold(digest);
  digest.add(context.messages_refused);
  digest.add(context.traces.next());
}

std::map<std::string, std::string> snapshot_layout(const ServerCore& server) {
  std::string bytes;
  Archive::Layout layout;
  Archive archive{bytes, layout};
  archive(*server.impl_);
  return layout;
}

Result<std::string> ServerCore::snapshot() const {
  std::string content;
  Archive archive{content};
  archive(*impl_);
  if (const auto stored = archive.finish(); !stored) return fail("snapshot.unsupported", stored.error().message);
  Digest state;
  fold(state);
  const std::uint64_t options = digest_of(impl_->parts.context.options);
  return wire::Snapshot{{std::string(core_name), snapshot_format, options, state.value()}, std::move(content)}.text();
}

Result<void> ServerCore::continue_from(std::string_view bytes) {
  if (impl_->beginning.at) return fail("snapshot.late", "the server has taken inputs already");
  const ServerOptions& options = impl_->parts.context.options;
  const auto snapshot = wire::Snapshot::read(bytes);
  if (!snapshot) return tl::unexpected(snapshot.error());
  if (auto fits = snapshot->check(core_name, snapshot_format, digest_of(options)); !fits) return fits;
  ServerCore other{options};
  Archive archive{std::string_view{snapshot->content()}};
  zone::provide_rtm(archive, options.rtm);
  archive(*other.impl_);
  if (const auto whole = archive.finish(); !whole) return fail("snapshot.damaged", whole.error().message);
  Digest state;
  other.fold(state);
  if (state.value() != snapshot->head().state)
    return fail("snapshot.state", "the state of the snapshot has another digest than the server that made it");
  impl_ = std::move(other.impl_);
  return {};
}

SimDuration ServerCore::tick_period() const { return impl_->parts.context.options.cycle; }

Result<void> ServerCore::check_command(const DecodedCommand& command) const { return impl_->router.check(command); }
bool ServerCore::was_given(const DecodedCommand& command) const {
  return command.identity() && impl_->parts.master.command_ids.find(*command.identity()) == CommandIds::Known::same;
}

std::string ServerCore::snapshot_json() const { return impl_->view.snapshot_json(); }
std::string ServerCore::summary_json() const { return impl_->view.summary_json(); }
ServerCore::PageRevision ServerCore::page_revision() const { return impl_->view.page_revision(); }
void ServerCore::positions(SimTime now, std::vector<PositionRecord>& out) const { impl_->view.positions(now, out); }
void ServerCore::write_bijection(JsonWriter& json) const { impl_->parts.context.simulator.monitor().write(json); }
std::string ServerCore::traces_json(std::uint64_t after, std::size_t limit) const {
  return impl_->parts.context.traces.to_json(after, limit);
}
std::optional<std::string> ServerCore::trace_json(std::uint64_t n) const {
  return impl_->parts.context.traces.one_json(n);
}
std::uint64_t ServerCore::zone_revision() const { return impl_->parts.context.simulator.zone_revision(); }
std::string ServerCore::zone_json() const { return impl_->parts.context.simulator.drawing().json; }
std::string ServerCore::next_virtual_object_id(std::string_view kind) const {
  return impl_->parts.augmented.objects.next_id(kind);
}
std::optional<std::string> ServerCore::battery_curve_json(const std::string& vehicle) const {
  return impl_->parts.instruments.batteries.curve_json(vehicle);
}
std::vector<wire::StopTarget> ServerCore::stop_targets() const {
  std::vector<wire::StopTarget> targets;
  const Registry& registry = impl_->parts.context.registry;
  for (const AivProxy& proxy : registry) {
    if (proxy.retired() || proxy.augmented() || proxy.membership.handed_over()) continue;
    targets.push_back({proxy.name(), proxy.id(), proxy.identity.actions_topic(),
                       wire::vda_topic(proxy.id(), "state", registry.interface_name()), proxy.received.version(),
                       impl_->parts.master.intentions.of(proxy.name()).stopped, proxy.is_cosiva()});
  }
  return targets;
}

std::shared_ptr<const zone::TrafficZone> ServerCore::zone() const { return impl_->parts.context.simulator.zone(); }

std::optional<zone::ZoneConfiguration> ServerCore::zone_configuration() const {
  const zone::ZoneConfiguration* configuration = impl_->parts.context.simulator.configuration();
  return configuration == nullptr ? std::nullopt : std::optional{*configuration};
}

}  // namespace cosiva::virtual_side
