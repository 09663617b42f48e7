#include "cosiva/experiments/runs/world/world.h"

#include <algorithm>
#include <charconv>
#include <deque>
#include <queue>
#include <utility>
#include <variant>

#include "cosiva/base/expect.h"
#include "cosiva/experiments/runs/scenario/scenario_player.h"
#include "cosiva/experiments/runs/world/core_store.h"
#include "cosiva/experiments/runs/world/ether.h"
#include "cosiva/experiments/runs/world/fault_injection.h"
#include "cosiva/experiments/runs/world/fleet.h"
#include "cosiva/physical/plant/plant_options.h"
#include "cosiva/physical/roadside/crossing_unit.h"
#include "cosiva/wire/messages/board.h"
#include "cosiva/wire/messages/topics.h"
#include "cosiva/wire/own/gvs.h"
#include "cosiva/wire/own/own_messages.h"
#include "cosiva/wire/own/v2x.h"
#include "cosiva/wire/own/v2x_port.h"
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

/// The clock of a process: set once, at the start of the process.
struct ProcessClock {
  SimDuration next_offset{};  ///< of the next process
  double next_fast_ppm{0.0};
  SimDuration offset{};
  double fast_ppm{0.0};
  SimTime started{};

  void start(SimTime now) {
    started = now;
    offset = next_offset;
    fast_ppm = next_fast_ppm;
  }
  [[nodiscard]] SimTime read(SimTime now) const {
    const auto since = static_cast<double>((now - started).count());
    return now + offset + SimDuration{static_cast<SimDuration::rep>(since * fast_ppm * 1e-6)};
  }
};

/// One core, with its network client and its timer.
struct Actor {
  std::string name;
  wire::VehicleId v2x_id;  ///< of a vehicle or a crossing unit: its name on the direct link
  std::unique_ptr<wire::Core> core;
  std::unique_ptr<wire::CoreRunner> runner;
  wire::Network::ClientId client{};
  std::uint32_t generation{
      0};  ///< incremented at each start, so that timers of a dead core do not affect its successor
  SimDuration tick_offset{};
  std::string persisted;
  double radio_loss{0.0};  ///< of the ether around the vehicle, whichever process is running
  bool alive{false};
  bool linked{false};
  std::vector<std::string> listens;
  std::vector<wire::Publish> unsent;             ///< QoS 1, while there is no link
  std::optional<std::uint64_t> effects_to_live;  ///< of the present process
  /// Of a server; null: its state alone survives a crash.
  std::shared_ptr<CoreStore> store;
  /// Commands that an earlier process accepted and that the core was not given yet, and behind them those accepted
  /// since; of a server only.
  std::deque<std::pair<std::string, CoreStore::Decided>> earlier_commands;
  ProcessClock clock;
};

namespace {

/// A core that starts later joins the common cycle.
SimTime first_tick(const Actor& actor, SimTime now, bool common_cycle) {
  const SimDuration period = actor.core->tick_period();
  const SimDuration since = common_cycle ? (now - virtual_epoch) % period : SimDuration::zero();
  return now - since + period + actor.tick_offset;
}

void publish_from(Actor& actor, SimTime now, wire::Network& network, const wire::Publish& message) {
  if (actor.linked)
    network.publish(now, actor.client, message);
  else if (message.qos > 0)
    actor.unsent.push_back(message);
}

/// Fails as physical::PlantCore::make() does.
Result<std::unique_ptr<physical::PlantCore>> make_plant(const WorldOptions& options) {
  physical::PlantOptions plant;
  plant.zone = options.zone;
  plant.rtm = options.rtm;
  plant.vehicles = options.aivs;
  plant.seed = options.seed;
  plant.noise = options.noise;
  plant.equipment = options.equipment;
  plant.publish_ground_truth = options.ground_truth;
  plant.as_values = options.as_values;
  plant.cycle = options.cycle.value_or(plant.cycle);
  return physical::PlantCore::make(std::move(plant));
}

}  // namespace

namespace {

struct MadeUnit {
  std::unique_ptr<physical::CrossingUnit> core;
  std::string configuration;
};

/// Fails as physical::CrossingUnit::make() does.
Result<MadeUnit> make_unit(const WorldOptions& options, std::size_t i) {
  physical::CrossingUnitOptions unit;
  unit.rtm = options.rtm;
  unit.crossing = options.units[i].crossing;
  unit.direct = options.radio.has_value();
  unit.emulated = true;
  unit.off = options.units[i].off;
  std::string configuration = physical::to_json(unit);
  auto core = physical::CrossingUnit::make(std::move(unit));
  if (!core) return tl::unexpected(core.error());
  return MadeUnit{std::move(*core), std::move(configuration)};
}

/// The antennas of crossing units.
Antennas antennas_of(const WorldOptions& options, std::size_t first_unit_id) {
  Antennas antennas{*options.reach};
  const auto& crossings = options.rtm->zone().crossings;
  for (std::size_t i = 0; i < options.units.size(); ++i) {
    const auto known = std::ranges::find(crossings, options.units[i].crossing, &zone::Crossing::name);
    COSIVA_EXPECT(known != crossings.end());
    antennas.position_at(first_unit_id + i, Antennas::Kind::unit, known->centre);
  }
  return antennas;
}

}  // namespace

/// Which actor is which process: the plant, the first server, the vehicles, the servers of other control areas, and the
/// crossing units.
struct ActorTable {
  using ActorId = std::size_t;
  static constexpr ActorId plant_id = 0;
  static constexpr ActorId server_id = 1;
  static constexpr ActorId first_aiv_id = 2;

  std::uint32_t aivs;
  std::size_t others{};              ///< servers of other control areas
  std::vector<CoreStore*> stores{};  ///< of all servers that have one

  [[nodiscard]] ActorId first_other() const { return first_aiv_id + aivs; }
  [[nodiscard]] ActorId first_unit_id() const { return first_other() + others; }
  [[nodiscard]] bool is_aiv(ActorId id) const { return id >= first_aiv_id && id < first_other(); }
  [[nodiscard]] bool is_unit(ActorId id) const { return id >= first_unit_id(); }
  [[nodiscard]] bool is_server(ActorId id) const {
    return id == server_id || (id >= first_other() && id < first_unit_id());
  }
  [[nodiscard]] Process process_of(ActorId id) const {
    if (is_unit(id)) return static_cast<Process>(first_unit + id - first_unit_id());
    return static_cast<Process>(id < first_other() ? id - server_id : first_other_server + id - first_other());
  }
  [[nodiscard]] ActorId actor_of(Process process) const {
    if (process == plant_process) return plant_id;
    if (experiments::is_unit(process)) return first_unit_id() + process - first_unit;
    return process < first_other_server ? server_id + process : first_other() + process - first_other_server;
  }
};

namespace {

/// Where messages pass as values, the state was not written ten times per second: it is read from the dead core.
std::string persisted_bytes(const ActorTable& table, ActorTable::ActorId id, const wire::Core& core) {
  if (id == ActorTable::plant_id) return static_cast<const physical::PlantCore&>(core).persisted_bytes();
  return table.is_aiv(id) ? static_cast<const aiv::OnboardCore&>(core).persisted_bytes() : std::string{};
}

}  // namespace

struct World::Impl {
  using ActorId = ActorTable::ActorId;
  static constexpr ActorId plant_id = ActorTable::plant_id;
  static constexpr ActorId server_id = ActorTable::server_id;
  static constexpr ActorId first_aiv_id = ActorTable::first_aiv_id;

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
    std::shared_ptr<const wire::InProcessMessage> typed;  ///< null: the content is the next of Streams::texts
  };
  struct StreamText {
    std::string port;
    std::string bytes;
  };

  WorldOptions options;
  SimTime now{virtual_epoch};
  wire::Network network;
  std::vector<Actor> actors;
  ActorTable table;
  struct Starts {
    std::vector<zone::TrackPosition> positions;
    std::vector<std::string> section_names;
  };
  Starts starts;
  std::priority_queue<Tick, std::vector<Tick>, std::greater<>> ticks;
  struct Streams {
    std::deque<Bytes> bytes;       ///< the delay is constant, so the order is first in, first out
    std::deque<StreamText> texts;  ///< likewise, of the streams that carry no values
    Ether ether;                   ///< between vehicles
  };
  Streams streams;
  struct Delivering {
    std::vector<std::optional<ActorId>> receivers;  ///< by the client of the network; none: outside the platform
    wire::Input input;                              ///< reused, so that a delivery allocates nothing
  };
  Delivering delivering;
  std::uint64_t sequence{0};
  Digest finished;  ///< of cores that were killed
  /// Called by the run; each may be empty.
  struct Handlers {
    World::Tap published;
    World::OnStep step;
    World::ServerObserver server;
  };
  Handlers handlers;
  std::vector<std::string> log;
  std::optional<ScenarioPlayer> player;
  std::optional<SimTime> scenario_began;
  bool fleet_whole{false};  ///< since the server came up
  SimTime next_check{};     ///< next check of the fleet, or the next step

  class Faults;
  std::unique_ptr<Faults> faults;

  explicit Impl(WorldOptions o);
  void name_actors();

  void feed(ActorId id, wire::InputKind kind, std::string source, std::string payload, bool flag = false,
            std::shared_ptr<const wire::InProcessMessage> typed = {}) {
    Actor& actor = actors[id];
    if (!actor.alive) return;
    handle(id, {actor.clock.read(now), kind, std::move(source), std::move(payload), flag, std::move(typed)});
  }

  /// An input without texts, in the reused record.
  void feed_again(ActorId id, wire::InputKind kind, std::shared_ptr<const wire::InProcessMessage> typed) {
    const Actor& actor = actors[id];
    if (!actor.alive) return;
    delivering.input.at = actor.clock.read(now);
    delivering.input.kind = kind;
    delivering.input.source.clear();
    delivering.input.payload.clear();
    delivering.input.flag = false;
    delivering.input.typed = std::move(typed);
    handle(id, delivering.input);
    delivering.input.typed.reset();
  }

  void handle(ActorId id, const wire::Input& input) {
    if (id != plant_id && observer().on_input) observer().on_input(table.process_of(id), input);
    const wire::Effects& effects = actors[id].runner->feed(input);
    if (id == server_id && handlers.server) handlers.server(input, effects);
    act(id, effects);
    if (!actors[id].earlier_commands.empty()) give_earlier_commands(id);
  }

  void give_earlier_commands(ActorId server) {
    Actor& actor = actors[server];
    auto& waiting = actor.earlier_commands;
    while (!waiting.empty() && actor.alive && actor.core->takes_earlier_command(waiting.front().first)) {
      const auto [json, decided] = std::move(waiting.front());
      waiting.pop_front();
      give_stored(server, json, decided);
    }
  }

  /// Gives a server a command whose record is durable.
  void give_stored(ActorId server, const std::string& json, const CoreStore::Decided& decided) {
    if (!actors[server].alive) return;
    feed(server, wire::InputKind::command, "http", json, true);
    if (actors[server].alive && decided) decided({});
  }

  [[nodiscard]] const FaultInjection::Observer& observer() const;
  [[nodiscard]] bool broker_running() const;

  void act(ActorId id, const wire::Effects& effects) {
    const FaultInjection::Observer& watched = observer();
    for (const wire::Effect& effect : effects) {
      Actor& actor = actors[id];
      if (actor.effects_to_live && --*actor.effects_to_live == 0) {
        kill(id);
        return;
      }
      if (id != plant_id && watched.on_effect) watched.on_effect(table.process_of(id), effect);
      if (const auto* publish = std::get_if<wire::Publish>(&effect)) {
        if (handlers.published) handlers.published(now, actor.name, *publish);
        if (publish->topic == wire::plant_radio_topic) change_ether(publish->payload);
        if (id == plant_id || !watched.passes || watched.passes(table.process_of(id), *publish))
          publish_from(actor, now, network, *publish);
      } else if (const auto* send = std::get_if<wire::SendBytes>(&effect)) {
        if (wire::v2x_port_number(send->port) || wire::v2x_source(send->port))
          streams.ether.broadcast(now, id, actors[id].v2x_id, *send);
        else
          send_bytes(id, *send);
      } else if (const auto* listen = std::get_if<wire::Listen>(&effect)) {
        actor.listens = listen->filters;
        if (actor.linked) network.listen(now, actor.client, listen->filters);
      } else if (const auto* persist = std::get_if<wire::Persist>(&effect)) {
        actor.persisted = persist->bytes;
        if (actor.store)
          actor.store->append(now, {actor.clock.read(now), wire::InputKind::persisted, {}, persist->bytes, false});
      } else if (const auto* line = std::get_if<wire::Log>(&effect); line != nullptr && line->level != 'i') {
        if (log.size() < 10'000) log.push_back(to_iso8601(now) + " " + actor.name + " " + line->text);
      }
    }
  }

  void change_ether(const std::string& json) {
    const auto radio = wire::radio_from_json(json);
    if (!radio) return;
    for (ActorId id = first_aiv_id; id < actors.size(); ++id) {
      Actor& actor = actors[id];
      if (radio->vehicle == "*" ? !table.is_aiv(id) : radio->vehicle != wire::to_string(actor.v2x_id)) continue;
      actor.radio_loss = radio->loss;
      if (actor.linked) network.set_loss(actor.client, radio->loss);
      streams.ether.set_loss(id, radio->loss);
    }
  }

  void send_bytes(ActorId from, const wire::SendBytes& send) {
    const ActorId to = from == plant_id ? first_aiv_id + vehicle_of(send.port) - 1 : plant_id;
    if (to >= table.first_other() || !actors[to].alive) return;
    streams.bytes.push_back({now + stream_delay, to, actors[to].generation, send.typed});
    if (!send.typed) streams.texts.push_back({send.port, send.bytes});  // values identify their vehicle
  }

  void start(ActorId id, std::unique_ptr<wire::Core> core, std::string what, std::string configuration) {
    Actor& actor = actors[id];
    actor.core = std::move(core);
    actor.runner = std::make_unique<wire::CoreRunner>(*actor.core, recorder(id));
    actor.alive = true;
    ++actor.generation;
    actor.clock.start(now);
    actor.listens.clear();
    actor.unsent.clear();
    CoreStore::Left left;
    if (actor.store)
      left = actor.store->left();
    else if (!actor.persisted.empty())
      left.persisted = actor.persisted;
    feed(id, wire::InputKind::configure, std::move(what), std::move(configuration));
    if (left.persisted) feed(id, wire::InputKind::restore, "state", std::move(*left.persisted));
    for (wire::Input& command : left.accepted) actor.earlier_commands.emplace_back(std::move(command.payload), nullptr);
    give_earlier_commands(id);
    if (table.is_aiv(id) || table.is_unit(id)) streams.ether.join(now, id, actor.radio_loss);
    ticks.push({first_tick(actor, now, options.cycle.has_value()), sequence++, id, actor.generation});
    link(id);
  }

  [[nodiscard]] wire::CoreRunner::Recorder recorder(ActorId id) {
    if (!actors[id].store) return {};
    return [this, store = actors[id].store.get()](const wire::Input& input) { store->append(now, input); };
  }

  void link(ActorId id) {
    Actor& actor = actors[id];
    if (!actor.alive || !broker_running() || actor.linked) return;
    actor.client = connect(id, actor.core->subscriptions(), actor.core->will());
    actor.linked = true;
    network.set_loss(actor.client, actor.radio_loss);
    if (!actor.listens.empty()) network.listen(now, actor.client, actor.listens);
    for (const wire::Publish& message : std::exchange(actor.unsent, {})) network.publish(now, actor.client, message);
    feed(id, wire::InputKind::link, "broker", "up");
  }

  void kill(ActorId id) {
    Actor& actor = actors[id];
    if (!actor.alive) return;
    if (options.as_values)
      if (std::string bytes = persisted_bytes(table, id, *actor.core); !bytes.empty())
        actor.persisted = std::move(bytes);
    actor.alive = false;
    actor.effects_to_live.reset();
    finished.add(actor.runner->digest().value());
    if (std::exchange(actor.linked, false)) network.break_connection(now, actor.client);
    streams.ether.leave(now, id);
    actor.earlier_commands.clear();
    if (actor.store) actor.store->on_killed();
    if (table.is_aiv(id)) notify_ports(id, plant_id, "down");
    for (ActorId aiv = first_aiv_id; id == plant_id && aiv < table.first_other(); ++aiv) notify_ports(aiv, aiv, "down");
    if (observer().on_killed) observer().on_killed(table.process_of(id));
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
    onboard.rali = number > options.equipment.size() || options.equipment[number - 1].rali;
    onboard.v2x_direct = options.radio.has_value();
    onboard.as_values = options.as_values;
    onboard.cycle = options.cycle.value_or(onboard.cycle);
    if (first_time) {
      const zone::TrackPosition position = starts.positions[number - 1];
      onboard.start = {starts.section_names[position.section], position.s_m};
    }
    if (options.adapt_aiv) options.adapt_aiv(onboard);
    std::string configuration = aiv::to_json(onboard);
    start(id, std::make_unique<aiv::OnboardCore>(std::move(onboard)), "aiv", std::move(configuration));
    if (!actors[plant_id].alive) return;
    notify_ports(id, plant_id, "up");
    notify_ports(id, id, "up");
  }

  void start_server(ActorId id = server_id) {
    COSIVA_EXPECT(table.is_server(id));
    virtual_side::ServerOptions& server =
        id == server_id ? options.server : options.other_servers[id - table.first_other()].options;
    server.cycle = options.cycle.value_or(server.cycle);
    server.as_values = options.as_values;
    std::string configuration = virtual_side::to_json(server);
    start(id, std::make_unique<virtual_side::ServerCore>(server), "server", std::move(configuration));
    if (id != server_id) return;
    fleet_whole = false;
    next_check = now + check_period;
  }

  [[nodiscard]] SimTime next_event() const {
    SimTime next = ticks.empty() ? SimTime::max() : ticks.top().at;
    if (!streams.bytes.empty()) next = std::min(next, streams.bytes.front().at);
    if (const auto due_at = network.next_due()) next = std::min(next, *due_at);
    if (const auto due_at = streams.ether.next_due()) next = std::min(next, *due_at);
    for (CoreStore* const store : table.stores) {
      if (const auto due_at = store->next_due()) next = std::min(next, std::max(now, *due_at));
    }
    if (player && !player->done() && actors[server_id].alive) next = std::min(next, next_check);
    return next;
  }

  void play() {
    if (player->done() || !actors[server_id].alive || now < next_check) return;
    fleet_whole = fleet_whole || fleet_is_complete(server(), options.aivs);
    if (!fleet_whole) {
      next_check = now + check_period;
      return;
    }
    if (!scenario_began) player->begin(*(scenario_began = now));
    for (const Scenario::Step& due_step : player->due(now)) {
      if (handlers.step) handlers.step(now, due_step);
      feed(server_id, wire::InputKind::command, "scenario", due_step.command);
    }
    next_check = player->next_due().value_or(SimTime::max());
  }

  [[nodiscard]] const virtual_side::ServerCore& server(ActorId id = server_id) const {
    COSIVA_EXPECT(table.is_server(id));
    return static_cast<const virtual_side::ServerCore&>(*actors[id].core);
  }

  void step() {
    // One instant at a time, in a fixed order: bytes, messages, the scenario, ticks.
    while (!streams.bytes.empty() && streams.bytes.front().at <= now) {
      Bytes bytes = std::move(streams.bytes.front());
      streams.bytes.pop_front();
      const bool receiver_runs = actors[bytes.to].generation == bytes.generation;
      if (bytes.typed) {
        if (receiver_runs) feed_again(bytes.to, wire::InputKind::bytes, std::move(bytes.typed));
        continue;
      }
      StreamText text = std::move(streams.texts.front());
      streams.texts.pop_front();
      if (receiver_runs) feed(bytes.to, wire::InputKind::bytes, std::move(text.port), std::move(text.bytes));
    }
    if (const auto due_at = network.next_due(); due_at && *due_at <= now)
      network.deliver_due(now, [this](wire::Network::Delivery& delivery) { deliver(delivery); });
    streams.ether.deliver_due(now, [this](ActorId to, wire::Network::Delivery& delivery) {
      feed(to, wire::InputKind::bytes, delivery.topic, delivery.payload, false, std::move(delivery.typed));
    });
    for (CoreStore* const store : table.stores) {
      if (const auto due_at = store->next_due(); due_at && *due_at <= now) store->work(now);
    }
    if (player) play();
    while (!ticks.empty() && ticks.top().at <= now) {
      const Tick tick = ticks.top();
      ticks.pop();
      const Actor& actor = actors[tick.actor];
      if (!actor.alive || actor.generation != tick.generation) continue;
      feed_again(tick.actor, wire::InputKind::tick, {});
      ticks.push({tick.at + actor.core->tick_period(), sequence++, tick.actor, tick.generation});
    }
  }

  void deliver(wire::Network::Delivery& delivery) {
    const auto receiver = delivering.receivers[delivery.to];
    if (!receiver) return;
    const Actor& actor = actors[*receiver];
    if (!actor.alive || !actor.linked || actor.client != delivery.to) return;
    delivering.input.at = actor.clock.read(now);
    delivering.input.kind = wire::InputKind::message;
    std::swap(delivering.input.source, delivery.topic);
    if (!delivery.payload.empty() || !delivering.input.payload.empty())
      std::swap(delivering.input.payload, delivery.payload);
    delivering.input.flag = delivery.retained;
    delivering.input.typed = std::move(delivery.typed);
    handle(*receiver, delivering.input);
    delivering.input.typed.reset();
  }

  [[nodiscard]] wire::Network::ClientId connect(std::optional<ActorId> receiver, std::vector<std::string> filters,
                                                std::optional<wire::Will> will) {
    const auto client = network.connect(now, std::move(filters), std::move(will));
    COSIVA_EXPECT(client == delivering.receivers.size());
    delivering.receivers.push_back(receiver);
    return client;
  }
};

/// Invariant: a process that is linked is running.
class World::Impl::Faults final : public FaultInjection {
 public:
  explicit Faults(Impl& world) : world_{world} {}

  [[nodiscard]] const Observer& observer() const { return observer_; }
  void connect_unknown_sender() { unknown_sender_ = world_.connect(std::nullopt, {}, std::nullopt); }

  bool running(Process process) const override { return actor(process).alive; }
  bool linked(Process process) const override { return actor(process).linked; }
  void kill_at_effect(Process process, std::uint64_t n) override {
    COSIVA_EXPECT(actor(process).alive);
    actor(process).effects_to_live = n > 0 ? std::optional{n} : std::nullopt;
  }
  void break_link(Process process) override {
    if (!std::exchange(actor(process).linked, false)) return;
    world_.network.break_connection(world_.now, actor(process).client);
    world_.feed(actor_of(process), wire::InputKind::link, "broker", "down");
  }
  void restore_link(Process process) override { world_.link(actor_of(process)); }
  void block(Process process, wire::Network::Blocked blocked) override {
    if (actor(process).linked) world_.network.set_blocked(world_.now, actor(process).client, blocked);
  }
  void set_network(wire::NetworkFaults injected) override {
    injected.aside_prefix = world_.options.network.aside_prefix;
    injected.instrument_prefix = world_.options.network.instrument_prefix;
    world_.network.set_faults(std::move(injected));
  }
  void stop_broker() override {
    broker_running_ = false;
    world_.network.stop(world_.now);
    for (ActorId id = 0; id < world_.actors.size(); ++id)
      if (std::exchange(world_.actors[id].linked, false)) world_.feed(id, wire::InputKind::link, "broker", "down");
  }
  void start_broker() override {
    broker_running_ = true;
    connect_unknown_sender();
    world_.link(plant_id);
  }
  bool broker_running() const override { return broker_running_; }
  void set_clock(Process process, SimDuration offset, double drift_ppm) override {
    actor(process).clock.next_offset = offset;
    actor(process).clock.next_fast_ppm = drift_ppm;
  }
  void publish_from_outside(const wire::Publish& message) override {
    if (message.topic == wire::plant_radio_topic) world_.change_ether(message.payload);
    world_.network.publish(world_.now, unknown_sender_, message);
  }
  void publish_from(Process process, const wire::Publish& message) override {
    if (actor(process).linked) world_.network.publish(world_.now, actor(process).client, message);
  }
  void kill(Process process) override { world_.kill(actor_of(process)); }
  void start(Process process) override;
  void set_boards(Process aiv, bool open) override {
    COSIVA_EXPECT(is_aiv(aiv));
    world_.notify_ports(actor_of(aiv), plant_id, open ? "up" : "down");
    world_.notify_ports(actor_of(aiv), actor_of(aiv), open ? "up" : "down");
  }
  void command(Process server, std::string json, std::function<void(const Result<void>&)> decided) override;
  void observe(Observer observer) override { observer_ = std::move(observer); }

 private:
  void start_plant();
  void start_unit(Process process);
  [[nodiscard]] ActorId actor_of(Process process) const { return world_.table.actor_of(process); }
  [[nodiscard]] Actor& actor(Process process) const {
    COSIVA_EXPECT(actor_of(process) < world_.actors.size());
    return world_.actors[actor_of(process)];
  }

  Impl& world_;
  bool broker_running_{true};
  Observer observer_;
  wire::Network::ClientId unknown_sender_{};
};

void World::Impl::Faults::start(Process process) {
  COSIVA_EXPECT(!running(process));
  if (process == plant_process) return start_plant();
  if (is_aiv(process)) return world_.start_aiv(process, false);
  if (is_unit(process)) return start_unit(process);
  world_.start_server(actor_of(process));
}

void World::Impl::Faults::start_plant() {
  auto plant = make_plant(world_.options);
  COSIVA_EXPECT(plant);
  std::string configuration = physical::to_json((*plant)->options());
  world_.start(plant_id, std::move(*plant), "plant", std::move(configuration));
  for (Process aiv = 1; aiv <= world_.options.aivs; ++aiv)
    if (running(aiv)) set_boards(aiv, true);
}

void World::Impl::Faults::start_unit(Process process) {
  auto unit = make_unit(world_.options, process - first_unit);
  COSIVA_EXPECT(unit);  // World::make has checked the crossings
  world_.start(actor_of(process), std::move(unit->core), "unit", std::move(unit->configuration));
}

void World::Impl::Faults::command(Process process, std::string json, std::function<void(const Result<void>&)> decided) {
  COSIVA_EXPECT(is_server(process));
  const ActorId id = actor_of(process);
  Actor& server = actor(process);
  CoreStore* const store = server.store.get();
  if (!server.alive) return;
  if (store == nullptr || virtual_side::is_stop(virtual_side::DecodedCommand{json})) {
    world_.feed(id, wire::InputKind::command, "http", std::move(json));
    if (store == nullptr) return decided({});
    if (server.alive) store->confirm(world_.now, std::move(decided));
    return;
  }
  wire::Input proposal{server.clock.read(world_.now), wire::InputKind::proposal, "http", json, false};
  store->propose(world_.now, std::move(proposal),
                 [this, id, generation = server.generation, json = std::move(json),
                  decided = std::move(decided)](const Result<void>& stored) {
                   Actor& receiver = world_.actors[id];
                   if (!receiver.alive || receiver.generation != generation) return;
                   if (!stored) return decided(stored);
                   if (receiver.earlier_commands.empty()) return world_.give_stored(id, json, decided);
                   receiver.earlier_commands.emplace_back(json, decided);
                 });
}

World::Impl::Impl(WorldOptions o)
    : options{std::move(o)},
      network{options.seed, options.network},
      table{options.aivs, options.other_servers.size()},
      streams{.bytes = {}, .texts = {}, .ether = {options.seed, options.radio}},
      faults{std::make_unique<Faults>(*this)} {
  if (!options.reach) return;
  streams.ether.limit(
      [this, antennas = antennas_of(options, table.first_unit_id()), at = SimTime{}](ActorId from, ActorId to) mutable {
        // All that is due at one moment is delivered at the same positions.
        if (std::exchange(at, now) != now) {
          const auto& plant = static_cast<const physical::PlantCore&>(*actors[plant_id].core);
          for (const physical::TrueVehicle& vehicle : plant.vehicles())
            antennas.position_at(first_aiv_id + vehicle.number - 1, Antennas::Kind::vehicle, position(vehicle.X_MB));
        }
        return antennas.reach(from, to);
      });
}

const FaultInjection::Observer& World::Impl::observer() const { return faults->observer(); }
bool World::Impl::broker_running() const { return faults->broker_running(); }

void World::Impl::name_actors() {
  actors.resize(table.first_unit_id() + options.units.size());
  actors[plant_id].name = "plant";
  Actor& server = actors[server_id];
  server.name = "server";
  server.tick_offset = options.cycle ? server_after : SimDuration{microseconds{500}};
  server.store = options.server_store;
  for (std::uint32_t number = 1; number <= options.aivs; ++number) {
    Actor& actor = actors[first_aiv_id + number - 1];
    actor.name = "AIV" + std::to_string(number);
    actor.v2x_id = {std::string(wire::our_manufacturer), actor.name};
    // Vehicles are switched on one after another; their timers are never in phase.
    actor.tick_offset = microseconds{1300} * number % milliseconds{20};
    if (options.cycle) actor.tick_offset = vehicles_after + microseconds{130} * number % vehicles_within;
  }
  for (std::size_t i = 0; i < options.other_servers.size(); ++i) {
    Actor& other = actors[table.first_other() + i];
    other.name = "server " + options.other_servers[i].options.area;
    other.tick_offset = server.tick_offset;
    other.store = options.other_servers[i].store;
  }
  for (std::size_t i = 0; i < options.units.size(); ++i) {
    Actor& unit = actors[table.first_unit_id() + i];
    unit.name = "unit " + options.units[i].crossing;
    unit.v2x_id = {std::string(wire::unit_manufacturer), options.units[i].crossing};
    unit.tick_offset = microseconds{700} * static_cast<int>(i + 1) % milliseconds{100};
  }
  for (const Actor& actor : actors)
    if (actor.store) table.stores.push_back(actor.store.get());
}

World::World() = default;
World::~World() = default;

Result<std::unique_ptr<World>> World::make(WorldOptions options) {
  COSIVA_EXPECT(!options.as_values || !options.server_store);
  for (const OtherServer& other : options.other_servers)
    COSIVA_EXPECT(!options.server.area.empty() && !other.options.area.empty() && (!options.as_values || !other.store));
  auto rtm = zone::RtmBuilder{options.rtm}.build(options.zone);
  if (!rtm) return tl::unexpected(rtm.error());
  options.rtm = *rtm;
  const zone::TrafficZone& zone = (*rtm)->zone();
  if (options.cycle && (*options.cycle < cycle_min || *options.cycle > cycle_max))
    return fail("world.cycle",
                "the common cycle must be from 20 to 100 ms, not " + std::to_string(to_seconds(*options.cycle)) + " s");
  for (std::size_t i = 0; i < options.units.size(); ++i)
    if (const auto unit = make_unit(options, i); !unit) return tl::unexpected(unit.error());
  auto plant = make_plant(options);
  if (!plant) return tl::unexpected(plant.error());

  if (options.network.aside_prefix.empty()) options.network.aside_prefix = wire::v2x_topic_prefix;
  options.network.instrument_prefix = wire::reference_poses_topic;
  std::unique_ptr<World> world{new World};
  world->impl_ = std::make_unique<Impl>(std::move(options));
  Impl& inside = *world->impl_;
  inside.starts.positions = zone.start_positions(inside.options.aivs);
  for (zone::SectionId id = 0; id < zone.circuit.size(); ++id) {
    inside.starts.section_names.push_back(zone.circuit.part(id).name);
  }

  inside.name_actors();

  const std::string plant_configuration = physical::to_json((*plant)->options());
  inside.start(Impl::plant_id, std::move(*plant), "plant", plant_configuration);
  inside.start_server();
  for (std::size_t i = 0; i < inside.options.other_servers.size(); ++i)
    inside.start_server(inside.table.first_other() + i);
  for (std::uint32_t number = 1; number <= inside.options.aivs; ++number) inside.start_aiv(number, true);
  for (std::size_t i = 0; i < inside.options.units.size(); ++i)
    inside.faults->start(static_cast<Process>(first_unit + i));
  inside.faults->connect_unknown_sender();
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
void World::on_step(OnStep action) { impl_->handlers.step = std::move(action); }

void World::kill_aiv(std::uint32_t number) { impl_->kill(Impl::first_aiv_id + number - 1); }
void World::start_aiv(std::uint32_t number) { impl_->start_aiv(number, false); }
void World::kill_server() { impl_->kill(Impl::server_id); }
void World::start_server() { impl_->start_server(); }
FaultInjection& World::faults() { return *impl_->faults; }
void World::tap(Tap tap) { impl_->handlers.published = std::move(tap); }
void World::observe_server(ServerObserver observer) { impl_->handlers.server = std::move(observer); }

const physical::PlantCore& World::plant() const {
  return static_cast<const physical::PlantCore&>(*impl_->actors[Impl::plant_id].core);
}
const virtual_side::ServerCore& World::server(Process process) const {
  COSIVA_EXPECT(is_server(process));
  return impl_->server(impl_->table.actor_of(process));
}
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
