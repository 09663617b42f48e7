#include "cosiva/experiments/runs/world/world.h"

#include <charconv>
#include <deque>
#include <queue>
#include <utility>
#include <variant>

#include "cosiva/base/expect.h"
#include "cosiva/experiments/runs/scenario/scenario_player.h"
#include "cosiva/experiments/runs/world/fleet.h"
#include "cosiva/physical/plant/plant_options.h"
#include "cosiva/wire/messages/board.h"
#include "cosiva/wire/messages/topics.h"
#include "cosiva/wire/own/own_messages.h"
#include "cosiva/wire/own/v2x.h"
#include "cosiva/zone/rtm/rtm_builder.h"

namespace cosiva::experiments {
namespace {

using std::chrono::microseconds;
using std::chrono::milliseconds;

/// Transmission time of bytes between the on-board program and a board: a frame of 20 bytes at 115 200 Bd and its
/// handling.
constexpr SimDuration stream_delay = milliseconds{2};

/// Period of the check whether the fleet is complete, for a scenario to begin.
constexpr SimDuration check_period = milliseconds{100};

/// In a common cycle: after the boards' reports the vehicles decide one after another; after the vehicles' messages the
/// server decides.
constexpr SimDuration vehicles_after = milliseconds{3};
constexpr SimDuration vehicles_within = milliseconds{2};
constexpr SimDuration server_after = milliseconds{9};
constexpr SimDuration cycle_min = milliseconds{20};
constexpr SimDuration cycle_max = milliseconds{100};

/// The vehicle that a port belongs to: "12/PILS" belongs to 12.
std::uint32_t vehicle_of(std::string_view port) {
  std::uint32_t number = 0;
  std::from_chars(port.data(), port.data() + port.size(), number);
  return number;
}

}  // namespace

/// One core, with its network client and its timer.
struct Actor {
  std::string name;
  std::unique_ptr<wire::Core> core;
  std::unique_ptr<wire::CoreRunner> runner;
  wire::Network::ClientId client{};
  std::uint32_t generation{
      0};  ///< incremented at each start, so that timers of a dead core do not affect its successor
  SimDuration tick_offset{};
  std::string persisted;
  double radio_loss{0.0};  ///< of the ether around the vehicle, whichever process is running
  bool alive{false};
};

struct World::Impl {
  using ActorId = std::size_t;
  static constexpr ActorId plant_id = 0;
  static constexpr ActorId server_id = 1;
  static constexpr ActorId first_aiv_id = 2;

  struct Tick {
    SimTime at;
    std::uint64_t sequence;
    ActorId actor;
    std::uint32_t generation;
    bool operator>(const Tick& other) const { return at != other.at ? at > other.at : sequence > other.sequence; }
  };
  struct Bytes {
    SimTime at;
    ActorId to;
    std::uint32_t generation;
    std::string port;
    std::string bytes;
  };

  WorldOptions options;
  SimTime now{virtual_epoch};
  wire::Network network;
  std::vector<Actor> actors;
  std::vector<zone::TrackPosition> start_positions;
  std::vector<std::string> section_names;
  std::priority_queue<Tick, std::vector<Tick>, std::greater<>> ticks;
  std::deque<Bytes> streams;  ///< the delay is constant, so the order is first in, first out
  std::vector<wire::Network::Delivery> due;
  wire::Network::ClientId unknown_sender{};
  std::uint64_t sequence{0};
  Digest finished;  ///< of cores that were killed
  World::Tap tap;
  std::vector<std::string> log;
  std::optional<ScenarioPlayer> player;
  std::optional<SimTime> scenario_began;
  bool fleet_whole{false};  ///< since the server came up
  SimTime next_check{};     ///< next check of the fleet, or the next step
  World::OnStep on_step;

  explicit Impl(WorldOptions o) : options{std::move(o)}, network{options.seed, options.network} {}

  void feed(ActorId id, wire::InputKind kind, std::string source, std::string payload, bool flag = false,
            std::shared_ptr<const wire::InProcessMessage> typed = {}) {
    Actor& actor = actors[id];
    if (!actor.alive) return;
    const wire::Input input{now, kind, std::move(source), std::move(payload), flag, std::move(typed)};
    act(id, actor.runner->feed(input));
  }

  void act(ActorId id, const wire::Effects& effects) {
    for (const wire::Effect& effect : effects) {
      if (const auto* publish = std::get_if<wire::Publish>(&effect)) {
        if (tap) tap(now, actors[id].name, *publish);
        if (publish->topic == wire::plant_radio_topic) change_ether(publish->payload);
        network.publish(now, actors[id].client, *publish);
      } else if (const auto* send = std::get_if<wire::SendBytes>(&effect)) {
        send_bytes(id, *send);
      } else if (const auto* listen = std::get_if<wire::Listen>(&effect)) {
        network.listen(now, actors[id].client, listen->filters);
      } else if (const auto* persist = std::get_if<wire::Persist>(&effect)) {
        actors[id].persisted = persist->bytes;
      } else if (const auto* line = std::get_if<wire::Log>(&effect); line != nullptr && line->level != 'i') {
        if (log.size() < 10'000) log.push_back(to_iso8601(now) + " " + actors[id].name + " " + line->text);
      }
    }
  }

  void change_ether(const std::string& json) {
    const auto radio = wire::radio_from_json(json);
    if (!radio) return;
    for (ActorId id = first_aiv_id; id < actors.size(); ++id) {
      Actor& actor = actors[id];
      if (radio->vehicle != "*" && radio->vehicle != std::string(wire::our_manufacturer) + "/" + actor.name) continue;
      actor.radio_loss = radio->loss;
      if (actor.alive) network.set_loss(actor.client, radio->loss);
    }
  }

  void send_bytes(ActorId from, const wire::SendBytes& send) {
    const ActorId to = from == plant_id ? first_aiv_id + vehicle_of(send.port) - 1 : plant_id;
    if (to >= actors.size() || !actors[to].alive) return;
    streams.push_back({now + stream_delay, to, actors[to].generation, send.port, send.bytes});
  }

  void start(ActorId id, std::unique_ptr<wire::Core> core, std::string what, std::string configuration) {
    Actor& actor = actors[id];
    actor.core = std::move(core);
    actor.runner = std::make_unique<wire::CoreRunner>(*actor.core);
    actor.alive = true;
    ++actor.generation;
    feed(id, wire::InputKind::configure, std::move(what), std::move(configuration));
    if (!actor.persisted.empty()) feed(id, wire::InputKind::restore, "state", actor.persisted);
    ticks.push({first_tick(actor), sequence++, id, actor.generation});
    actor.client = network.connect(now, actor.core->subscriptions(), actor.core->will());
    network.set_loss(actor.client, actor.radio_loss);
    feed(id, wire::InputKind::link, "broker", "up");
  }

  /// A core that starts later joins the common cycle.
  [[nodiscard]] SimTime first_tick(const Actor& actor) const {
    const SimDuration period = actor.core->tick_period();
    const SimDuration since = options.cycle ? (now - virtual_epoch) % period : SimDuration::zero();
    return now - since + period + actor.tick_offset;
  }

  void kill(ActorId id) {
    Actor& actor = actors[id];
    if (!actor.alive) return;
    if (id >= first_aiv_id && options.as_values) {
      // The state was not written ten times per second; it is read from the dead core instead.
      std::string persisted = static_cast<const aiv::OnboardCore&>(*actor.core).persisted_bytes();
      if (!persisted.empty()) actor.persisted = std::move(persisted);
    }
    actor.alive = false;
    finished.add(actor.runner->digest().value());
    network.break_connection(now, actor.client);
    if (id >= first_aiv_id) notify_ports(id, plant_id, "down");
  }

  /// Informs `to` that the byte streams of an AIV's boards appeared or disappeared.
  void notify_ports(ActorId aiv, ActorId to, const char* what) {
    const auto number = static_cast<std::uint32_t>(aiv - first_aiv_id + 1);
    for (const wire::Board board : wire::all_boards) {
      feed(to, wire::InputKind::port, wire::port_name(number, board), what);
    }
  }

  void start_aiv(std::uint32_t number, bool first_time) {
    const ActorId id = first_aiv_id + number - 1;
    aiv::OnboardOptions onboard;
    onboard.number = number;
    onboard.id.serial_number = "AIV" + std::to_string(number);
    onboard.zone = options.zone;
    onboard.rtm = options.rtm;
    onboard.rules = options.rules;
    onboard.v2x = options.v2x;
    onboard.as_values = options.as_values;
    onboard.cycle = options.cycle.value_or(onboard.cycle);
    if (first_time) {
      const zone::TrackPosition position = start_positions[number - 1];
      onboard.start = {section_names[position.section], position.s_m};
    }
    std::string configuration = aiv::to_json(onboard);
    start(id, std::make_unique<aiv::OnboardCore>(std::move(onboard)), "aiv", std::move(configuration));
    notify_ports(id, plant_id, "up");
    notify_ports(id, id, "up");
  }

  void start_server() {
    options.server.cycle = options.cycle.value_or(options.server.cycle);
    options.server.as_values = options.as_values;
    std::string configuration = virtual_side::to_json(options.server);
    start(server_id, std::make_unique<virtual_side::ServerCore>(options.server), "server", std::move(configuration));
    fleet_whole = false;
    next_check = now + check_period;
  }

  [[nodiscard]] SimTime next_event() const {
    SimTime next = ticks.empty() ? SimTime::max() : ticks.top().at;
    if (!streams.empty()) next = std::min(next, streams.front().at);
    if (const auto due_at = network.next_due()) next = std::min(next, *due_at);
    if (player && !player->done() && actors[server_id].alive) next = std::min(next, next_check);
    return next;
  }

  void play() {
    if (!player || player->done() || !actors[server_id].alive || now < next_check) return;
    fleet_whole = fleet_whole || fleet_is_complete(server(), options.aivs);
    if (!fleet_whole) {
      next_check = now + check_period;
      return;
    }
    if (!scenario_began) player->begin(*(scenario_began = now));
    for (const Scenario::Step& due_step : player->due(now)) {
      if (on_step) on_step(now, due_step);
      feed(server_id, wire::InputKind::command, "scenario", due_step.command);
    }
    next_check = player->next_due().value_or(SimTime::max());
  }

  [[nodiscard]] const virtual_side::ServerCore& server() const {
    return static_cast<const virtual_side::ServerCore&>(*actors[server_id].core);
  }

  void step() {
    // One instant at a time, in a fixed order: bytes, messages, the scenario, ticks.
    while (!streams.empty() && streams.front().at <= now) {
      Bytes bytes = std::move(streams.front());
      streams.pop_front();
      if (actors[bytes.to].generation == bytes.generation) {
        feed(bytes.to, wire::InputKind::bytes, std::move(bytes.port), std::move(bytes.bytes));
      }
    }
    due.clear();
    network.take_due(now, due);
    for (auto& delivery : due) deliver(std::move(delivery));
    play();
    while (!ticks.empty() && ticks.top().at <= now) {
      const Tick tick = ticks.top();
      ticks.pop();
      const Actor& actor = actors[tick.actor];
      if (!actor.alive || actor.generation != tick.generation) continue;
      feed(tick.actor, wire::InputKind::tick, {}, {});
      ticks.push({tick.at + actor.core->tick_period(), sequence++, tick.actor, tick.generation});
    }
  }

  void deliver(wire::Network::Delivery delivery) {
    for (ActorId id = 0; id < actors.size(); ++id) {
      if (actors[id].alive && actors[id].client == delivery.to) {
        act(id, actors[id].runner->feed({now, wire::InputKind::message, std::move(delivery.topic),
                                         std::move(delivery.payload), delivery.retained, std::move(delivery.typed)}));
        return;
      }
    }
  }
};

World::World() = default;
World::~World() = default;

Result<std::unique_ptr<World>> World::make(WorldOptions options) {
  auto rtm = zone::RtmBuilder{options.rtm}.build(options.zone);
  if (!rtm) return tl::unexpected(rtm.error());
  options.rtm = *rtm;
  const zone::TrafficZone& zone = (*rtm)->zone();
  if (options.cycle && (*options.cycle < cycle_min || *options.cycle > cycle_max))
    return fail("world.cycle",
                "the common cycle must be from 20 to 100 ms, not " + std::to_string(to_seconds(*options.cycle)) + " s");
  physical::PlantOptions plant_options;
  plant_options.zone = options.zone;
  plant_options.rtm = options.rtm;
  plant_options.vehicles = options.aivs;
  plant_options.seed = options.seed;
  plant_options.noise = options.noise;
  plant_options.publish_ground_truth = options.ground_truth;
  plant_options.cycle = options.cycle.value_or(plant_options.cycle);
  auto plant = physical::PlantCore::make(std::move(plant_options));
  if (!plant) return tl::unexpected(plant.error());

  if (options.network.aside_prefix.empty()) options.network.aside_prefix = wire::v2x_topic_prefix;
  std::unique_ptr<World> world{new World};
  world->impl_ = std::make_unique<Impl>(std::move(options));
  Impl& inside = *world->impl_;
  inside.start_positions = zone.start_positions(inside.options.aivs);
  for (zone::SectionId id = 0; id < zone.circuit.size(); ++id) {
    inside.section_names.push_back(zone.circuit.part(id).name);
  }

  inside.actors.resize(Impl::first_aiv_id + inside.options.aivs);
  inside.actors[Impl::plant_id].name = "plant";
  inside.actors[Impl::server_id].name = "server";
  inside.actors[Impl::server_id].tick_offset = inside.options.cycle ? server_after : SimDuration{microseconds{500}};
  for (std::uint32_t number = 1; number <= inside.options.aivs; ++number) {
    Actor& actor = inside.actors[Impl::first_aiv_id + number - 1];
    actor.name = "AIV" + std::to_string(number);
    // Vehicles are switched on one after another; their timers are never in phase.
    actor.tick_offset = microseconds{1300} * number % milliseconds{20};
    if (inside.options.cycle) actor.tick_offset = vehicles_after + microseconds{130} * number % vehicles_within;
  }

  const std::string plant_configuration = physical::to_json((*plant)->options());
  inside.start(Impl::plant_id, std::move(*plant), "plant", plant_configuration);
  inside.start_server();
  for (std::uint32_t number = 1; number <= inside.options.aivs; ++number) inside.start_aiv(number, true);
  inside.unknown_sender = inside.network.connect(inside.now, {}, std::nullopt);
  return world;
}

void World::run_for(SimDuration duration) {
  const SimTime end = impl_->now + duration;
  for (SimTime next = impl_->next_event(); next <= end; next = impl_->next_event()) {
    COSIVA_EXPECT(next >= impl_->now);
    impl_->now = next;
    impl_->step();
  }
  impl_->now = end;
}

SimTime World::now() const { return impl_->now; }

void World::command_server(std::string json, std::shared_ptr<const wire::InProcessMessage> decoded) {
  impl_->feed(Impl::server_id, wire::InputKind::command, "world", std::move(json), false, std::move(decoded));
}

void World::command_plant(std::string json) {
  impl_->feed(Impl::plant_id, wire::InputKind::command, "world", std::move(json));
}

void World::play(const Scenario& scenario) {
  impl_->player.emplace(scenario);
  impl_->scenario_began.reset();
  impl_->next_check = impl_->now;
}
std::optional<SimTime> World::scenario_began() const { return impl_->scenario_began; }
bool World::scenario_done() const { return !impl_->player || impl_->player->done(); }
void World::on_step(OnStep action) { impl_->on_step = std::move(action); }

void World::publish(const wire::Publish& message) {
  if (message.topic == wire::plant_radio_topic) impl_->change_ether(message.payload);
  impl_->network.publish(impl_->now, impl_->unknown_sender, message);
}

void World::kill_aiv(std::uint32_t number) { impl_->kill(Impl::first_aiv_id + number - 1); }
void World::start_aiv(std::uint32_t number) { impl_->start_aiv(number, false); }
void World::kill_server() { impl_->kill(Impl::server_id); }
void World::start_server() { impl_->start_server(); }
void World::tap(Tap tap) { impl_->tap = std::move(tap); }

const physical::PlantCore& World::plant() const {
  return static_cast<const physical::PlantCore&>(*impl_->actors[Impl::plant_id].core);
}
const virtual_side::ServerCore& World::server() const { return impl_->server(); }
const aiv::OnboardCore& World::aiv(std::uint32_t number) const {
  return static_cast<const aiv::OnboardCore&>(*impl_->actors[Impl::first_aiv_id + number - 1].core);
}
const wire::Network& World::network() const { return impl_->network; }
const std::vector<std::string>& World::log() const { return impl_->log; }

Digest World::digest() const {
  Digest digest = impl_->finished;
  for (const Actor& actor : impl_->actors) {
    if (actor.alive) digest.add(actor.runner->digest().value());
  }
  return digest;
}

Digest World::estimates() const {
  Digest digest;
  for (const Actor& actor : impl_->actors) {
    if (actor.alive) actor.core->fold(digest);
  }
  return digest;
}

}  // namespace cosiva::experiments
