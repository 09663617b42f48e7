#include "cosiva/physical/plant/plant_core.h"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <string>
#include <utility>

#include "cosiva/base/archive.h"
#include "cosiva/base/digest.h"
#include "cosiva/base/expect.h"
#include "cosiva/base/json_value.h"
#include "cosiva/base/json_writer.h"
#include "cosiva/physical/plant/collisions.h"
#include "cosiva/physical/plant/floor.h"
#include "cosiva/physical/plant/ground_truth_publisher.h"
#include "cosiva/physical/plant/obstacles.h"
#include "cosiva/physical/plant/vehicle.h"
#include "cosiva/physical/plant/zone_exchange.h"
#include "cosiva/wire/in_process/board_frames.h"
#include "cosiva/wire/messages/topics.h"
#include "cosiva/wire/own/actual_position.h"
#include "cosiva/wire/runtime/snapshot.h"
#include "cosiva/zone/rtm/rtm_builder.h"

namespace cosiva::physical {
namespace {

/// After a longer gap the tick was not late: the machine was suspended. The vehicles were stopped meanwhile.
constexpr SimDuration tick_gap_max = std::chrono::seconds{1};
/// However late a tick is, the emulated plant advances by no more than this. The boards have not received the commands
/// sent meanwhile, so all vehicles would drive blind, which no real vehicle does because its emulating computer is
/// busy.
constexpr SimDuration blind_max = std::chrono::milliseconds{50};

/// Of a command entered by hand, which may contain a zone file, and of a command over the broker, which need not: a
/// zone has its own topic there. The largest message is a changeBattery with the whole type: lipo850 takes 5.7 kB.
constexpr std::size_t command_bytes_max = 32U << 20U;
constexpr std::size_t message_bytes_max = 64U << 10U;

constexpr SimDuration persist_period = std::chrono::milliseconds{100};
constexpr std::string_view core_name = "plant";

/// How long a body may move straight on: the usual cycle; in a slower cycle twice that, for half the work.
SimDuration step_max(const PlantOptions& options) {
  constexpr SimDuration usual = std::chrono::milliseconds{10};
  return options.cycle > 2 * usual ? 2 * usual : usual;
}

/// A zone is the same wherever its file was.
zone::ZoneConfiguration without_origin(zone::ZoneConfiguration configuration) {
  configuration.origin = "the plant's state";
  return configuration;
}

std::uint64_t digest_of(PlantOptions options) {
  options.zone = without_origin(std::move(options.zone));
  Digest digest;
  digest.add(to_json(options));
  return digest.value();
}

struct PortAddress {
  std::uint32_t vehicle;
  wire::Board board;
};
std::optional<PortAddress> parse_port(std::string_view name) {
  std::uint32_t number = 0;
  const auto [end, error] = std::from_chars(name.data(), name.data() + name.size(), number);
  if (error != std::errc{} || end == name.data() + name.size() || *end != '/') return std::nullopt;
  const std::string_view rest = name.substr(static_cast<std::size_t>(end - name.data()) + 1);
  for (const wire::Board board : wire::all_boards) {
    if (rest == to_string(board)) return PortAddress{number, board};
  }
  return std::nullopt;
}

}  // namespace

/// Invariant: there is one body pose for each vehicle, taken after the last motion.
struct PlantCore::Impl {
  Impl(PlantOptions given, const zone::Rtm& read, const std::vector<zone::TrackPosition>& positions)
      : options{std::move(given)},
        floor{std::make_shared<Floor>(options.zone, read.shared_zone(), options.noise.tag_range_m)},
        fan{read.zone().vehicle},
        watch{read.zone().vehicle},
        obstacles{read.zone()},
        exchange{options.zone, read.shared_zone(), options.publish_zone},
        persistence{digest_of(options)} {
    vehicles.reserve(positions.size());
    const auto cells = PowerTrain::usual_table();
    for (std::uint32_t i = 0; i < positions.size(); ++i)
      vehicles.emplace_back(i + 1, floor, positions[i], options.noise, options.equipment_of(i + 1), options.seed, cells,
                            step_max(options));
    if (options.as_values)
      for (Vehicle& vehicle : vehicles) vehicle.boards().pass_values();
    bodies.resize(vehicles.size());
    record_bodies();
  }

  PlantOptions options;
  std::shared_ptr<Floor> floor;  ///< the newest: vehicles that still move may be on older ones
  RangeFan fan;                  ///< for bodies as they were at the start: no map changes a body
  CollisionWatch watch;
  std::vector<Vehicle> vehicles;
  std::vector<BodyPose> bodies;  ///< as of now, one per vehicle
  Obstacles obstacles;
  ZoneExchange exchange;
  std::vector<CollisionWatch::Pair> contacts;
  std::vector<Collision> collisions;
  std::optional<SimTime> powered_at;
  SimTime now{};
  bool broker_up{false};
  GroundTruthPublisher ground_truth;
  struct Persistence {
    std::uint64_t options;   ///< digest of those that the plant was made with
    bool other_zone{false};  ///< the zone in force is not theirs
    Every timer{persist_period};
  };
  Persistence persistence;

  void power_up(SimTime at);
  void record_bodies();
  void tick(SimTime at, wire::Effects& effects);
  void watch_contacts();
  void scan(std::size_t index);
  [[nodiscard]] std::string name_of(CollisionWatch::BodyKey key) const;

  void on_link(const wire::Input& input);
  void on_message(const wire::Input& input, wire::Effects& effects);
  void on_port(const wire::Input& input, wire::Effects& effects);
  void on_bytes(const wire::Input& input, wire::Effects& effects);
  void on_command(std::string_view json, std::size_t bytes_max, wire::Effects& effects);
  [[nodiscard]] std::optional<Error> obey(const JsonValue& command, wire::Effects& effects);
  [[nodiscard]] Result<Vehicle*> vehicle_of(const JsonValue& command);
  [[nodiscard]] std::optional<Error> change_battery(const JsonValue& given);
  [[nodiscard]] std::optional<Error> set_load(const JsonValue& given);
  [[nodiscard]] std::optional<Error> set_fault(const JsonValue& given);
  void take_over(const ZoneExchange::News& news);
  void change_floors();
  [[nodiscard]] std::string persisted_bytes();
  [[nodiscard]] Result<void> restore(std::string_view persisted);
  void archive(Archive& archive);
  void archive_zone(Archive& archive);
  void archive_floor(Archive& archive, Vehicle& vehicle);
  [[nodiscard]] std::shared_ptr<Floor> floor_of(const zone::ZoneConfiguration& configuration) const;
  void persist(wire::Effects& effects);
};

PlantCore::PlantCore() = default;
PlantCore::~PlantCore() = default;

Result<std::unique_ptr<PlantCore>> PlantCore::make(PlantOptions options) {
  auto rtm = zone::RtmBuilder{options.rtm}.build(options.zone);
  if (!rtm) return tl::unexpected(rtm.error());
  const zone::TrafficZone& zone = (*rtm)->zone();
  if (options.vehicles == 0) return fail("plant.vehicles", "a plant needs at least one vehicle");
  auto positions = zone.start_positions(options.vehicles);
  if (positions.size() != options.vehicles) {
    return fail("plant.vehicles", "zone '" + zone.name + "' has room for " + std::to_string(positions.size()) +
                                      " vehicles, requested were " + std::to_string(options.vehicles));
  }
  std::unique_ptr<PlantCore> core{new PlantCore};
  core->impl_ = std::make_unique<Impl>(std::move(options), **rtm, positions);
  return core;
}

void PlantCore::handle(const wire::Input& input, wire::Effects& effects) {
  Impl& in = *impl_;
  if (!in.powered_at) in.power_up(input.at);
  switch (input.kind) {
    case wire::InputKind::tick: return in.tick(input.at, effects);
    case wire::InputKind::bytes: return in.on_bytes(input, effects);
    case wire::InputKind::port: return in.on_port(input, effects);
    case wire::InputKind::link: return in.on_link(input);
    case wire::InputKind::message: return in.on_message(input, effects);
    case wire::InputKind::command: return in.on_command(input.payload, command_bytes_max, effects);
    case wire::InputKind::restore:
      if (const auto restored = in.restore(input.payload); !restored)
        effects.emplace_back(
            wire::Log{'w', "the vehicles are at their start positions: " + to_string(restored.error())});
      return;
    case wire::InputKind::configure:  // its options came through make()
    case wire::InputKind::proposal:
    case wire::InputKind::persisted:
    case wire::InputKind::snapshot: return;
  }
}

std::vector<std::string> PlantCore::subscriptions() const {
  return {std::string(wire::plant_command_topic), wire::topics_below(wire::zone_topic_prefix, 1),
          wire::topics_below(wire::plant_position_request_topic_prefix, 2)};
}

void PlantCore::farewell(SimTime /*now*/, wire::Effects& /*effects*/) {
  // The zone stays retained on purpose: a server that starts later still receives it.
}

void PlantCore::fold(Digest& digest) const {
  for (const Vehicle& vehicle : impl_->vehicles) {
    const Pose2 pose = body_pose(vehicle);
    digest.add(pose.x_m);
    digest.add(pose.y_m);
    digest.add(pose.heading_rad);
    digest.add(vehicle.motion().speed_mps());
    digest.add(vehicle.trip().distance_m());
    digest.add(vehicle.power().pack().charge());
    digest.add(std::string_view{vehicle.boards().display()});
  }
  for (const Collision& collision : impl_->collisions) {
    digest.add(collision.at);
    digest.add(std::string_view{collision.a});
    digest.add(std::string_view{collision.b});
  }
}

SimDuration PlantCore::tick_period() const { return impl_->options.cycle; }

const PlantOptions& PlantCore::options() const { return impl_->options; }

std::vector<std::string> PlantCore::ports() const {
  std::vector<std::string> names;
  for (const Vehicle& vehicle : impl_->vehicles) {
    for (const wire::Board board : wire::all_boards)
      if (vehicle.boards().has(board)) names.push_back(vehicle.boards().port(board));
  }
  return names;
}

std::vector<TrueVehicle> PlantCore::vehicles() const {
  std::vector<TrueVehicle> ground_truth;
  ground_truth.reserve(impl_->vehicles.size());
  for (const Vehicle& vehicle : impl_->vehicles) {
    const LineVehicle& motion = vehicle.motion();
    const PowerTrain& power = vehicle.power();
    ground_truth.push_back({vehicle.number(),
                            body_pose(vehicle),
                            motion.speed_mps(),
                            vehicle.trip().distance_m(),
                            vehicle.trip().laps(),
                            vehicle.power().pack().charge(),
                            vehicle.powered(impl_->now),
                            vehicle.boards().display(),
                            motion.following() ? std::optional{motion.track_position()} : std::nullopt,
                            {power.pack().voltage_v(), power.pack().current_a(), power.pack().temperature_c(),
                             power.load_w(), power.cut_off()}});
  }
  return ground_truth;
}

const std::vector<Collision>& PlantCore::collisions() const { return impl_->collisions; }

std::map<std::string, std::string> persisted_layout(PlantCore& plant) {
  std::string bytes;
  Archive::Layout layout;
  Archive archive{bytes, layout};
  archive(*plant.impl_);
  return layout;
}

std::string PlantCore::persisted_bytes() const { return impl_->persisted_bytes(); }

std::string PlantCore::summary_json() const {
  std::uint64_t laps = 0;
  double longest_wait_s = 0.0;
  JsonWriter json;
  json.begin_object().key("vehicles").begin_array();
  for (const Vehicle& vehicle : impl_->vehicles) {
    const Pose2 pose = body_pose(vehicle);
    laps += vehicle.trip().laps();
    longest_wait_s = std::max(longest_wait_s, vehicle.trip().longest_wait_s());
    json.begin_object().field("number", vehicle.number()).field("x", pose.x_m).field("y", pose.y_m);
    json.field("heading", pose.heading_rad).field("speed", vehicle.motion().speed_mps());
    json.field("distance", vehicle.trip().distance_m()).field("laps", vehicle.trip().laps());
    json.field("charge", vehicle.power().pack().charge())
        .field("longest_wait_s", vehicle.trip().longest_wait_s())
        .end_object();
  }
  json.end_array().key("collisions").begin_array();
  for (const Collision& collision : impl_->collisions) {
    json.begin_object().field("at", to_iso8601(collision.at)).field("a", collision.a).field("b", collision.b);
    json.end_object();
  }
  json.end_array().field("laps", laps).field("longest_wait_s", longest_wait_s).end_object();
  return json.take();
}

void PlantCore::Impl::power_up(SimTime at) {
  powered_at = at;
  now = at;
  ground_truth.start(at);
  persistence.timer.start(at);
  for (Vehicle& vehicle : vehicles) vehicle.power_up(at, options.seed);
}

void PlantCore::Impl::record_bodies() {
  COSIVA_EXPECT(bodies.size() == vehicles.size());
  for (std::size_t i = 0; i < vehicles.size(); ++i) bodies[i] = vehicles[i].motion().body();
}

void PlantCore::Impl::tick(SimTime at, wire::Effects& effects) {
  SimDuration dt = at - now;
  if (dt > tick_gap_max || dt < SimDuration::zero()) {
    effects.emplace_back(wire::Log{'w', "the plant's clock jumped by " + std::to_string(to_seconds(dt)) +
                                            " s; the vehicles were stopped meanwhile"});
    dt = SimDuration::zero();
  }
  dt = std::min(dt, std::max(blind_max, options.cycle));
  now = at;
  change_floors();
  for (Vehicle& vehicle : vehicles) vehicle.move(at, dt);
  record_bodies();
  watch_contacts();
  for (std::size_t i = 0; i < vehicles.size(); ++i) {
    if (vehicles[i].boards().wants_scan(at)) scan(i);
    vehicles[i].speak(at, fan.ranges(), effects);
  }
  exchange.tick(at, effects);
  ground_truth.tick(at, broker_up && options.publish_ground_truth, vehicles, obstacles, collisions.size(), effects);
  if (persistence.timer.take(at)) persist(effects);
}

void PlantCore::Impl::watch_contacts() {
  contacts.clear();
  watch.detect_contacts(bodies, obstacles.discs(), contacts);
  for (const auto& pair : contacts) collisions.push_back({now, name_of(pair.a), name_of(pair.b)});
}

void PlantCore::Impl::scan(std::size_t index) {
  fan.aim(bodies[index]);
  for (std::size_t other = 0; other < bodies.size(); ++other) {
    if (other != index) fan.see(bodies[other]);
  }
  for (const auto& obstacle : obstacles.all()) fan.see(obstacle.disc);
}

std::string PlantCore::Impl::name_of(CollisionWatch::BodyKey key) const {
  if ((key & CollisionWatch::obstacle_bit) == 0) return "AIV" + std::to_string(key + 1);
  return obstacles.name_of(key);
}

void PlantCore::Impl::take_over(const ZoneExchange::News& news) {
  options.zone = exchange.configuration();
  persistence.other_zone = true;
  // The vehicles' readers use this very floor; from the next tick on they find the new tags.
  if (news.same_geometry) {
    floor->configuration = options.zone;
    floor->tags = TagMap{*news.zone, options.noise.tag_range_m};
    for (Vehicle& vehicle : vehicles) vehicle.on_tags_changed();
    return;
  }
  floor = std::make_shared<Floor>(options.zone, news.zone, options.noise.tag_range_m);
  obstacles.set_zone(*news.zone);
  change_floors();
}

/// A stopped vehicle is put on the newest floor before any command to drive can arrive.
void PlantCore::Impl::change_floors() {
  for (Vehicle& vehicle : vehicles) {
    if (vehicle.floor() == floor) continue;
    vehicle.await_floor();
    if (vehicle.is_stopped()) vehicle.set_zone(floor);
  }
}

std::string PlantCore::Impl::persisted_bytes() {
  std::string content;
  Archive writer{content};
  archive(writer);
  COSIVA_EXPECT(writer.finish());
  return wire::Snapshot{{std::string(core_name), persisted_format, persistence.options, 0}, std::move(content)}.text();
}

void PlantCore::Impl::persist(wire::Effects& effects) {
  if (!options.as_values) effects.emplace_back(wire::Persist{persisted_bytes()});
}

Result<void> PlantCore::Impl::restore(std::string_view persisted) {
  const auto snapshot = wire::Snapshot::read(persisted);
  if (!snapshot) return tl::unexpected(snapshot.error());
  if (auto fits = snapshot->check(core_name, persisted_format, persistence.options); !fits) return fits;
  Archive reader{std::string_view{snapshot->content()}};
  archive(reader);
  // The bytes are those that a plant of this format wrote, unless two formats have one number.
  COSIVA_EXPECT(reader.finish());
  record_bodies();
  return {};
}

void PlantCore::Impl::archive(Archive& archive) {
  archive_zone(archive);
  for (Vehicle& vehicle : vehicles) {
    archive_floor(archive, vehicle);
    archive(vehicle);
  }
  archive(obstacles, collisions);
}

void PlantCore::Impl::archive_zone(Archive& archive) {
  archive(persistence.other_zone);
  if (!persistence.other_zone) return;
  zone::ZoneConfiguration in_force = without_origin(options.zone);
  archive(in_force);
  if (!archive.reads()) return;
  options.zone = std::move(in_force);
  floor = floor_of(options.zone);
  exchange = ZoneExchange{options.zone, floor->zone, options.publish_zone};
  obstacles.set_zone(*floor->zone);
}

/// A vehicle that still moves when the zone is switched is on the floor before.
void PlantCore::Impl::archive_floor(Archive& archive, Vehicle& vehicle) {
  bool on_newest = vehicle.floor() == floor;
  archive(on_newest);
  if (on_newest) {
    if (archive.reads() && vehicle.floor() != floor) vehicle.set_zone(floor);
    return;
  }
  zone::ZoneConfiguration before = without_origin(vehicle.floor()->configuration);
  archive(before);
  if (archive.reads()) vehicle.set_zone(floor_of(before));
}

std::shared_ptr<Floor> PlantCore::Impl::floor_of(const zone::ZoneConfiguration& configuration) const {
  const auto rtm = zone::Rtm::initialise(configuration);
  COSIVA_EXPECT(rtm);  // the plant had this zone
  return std::make_shared<Floor>(configuration, rtm->shared_zone(), options.noise.tag_range_m);
}

void PlantCore::Impl::on_link(const wire::Input& input) {
  broker_up = input.payload == "up";
  exchange.on_link(broker_up, input.at);
}

void PlantCore::Impl::on_message(const wire::Input& input, wire::Effects& effects) {
  if (input.source == wire::plant_command_topic) return on_command(input.payload, message_bytes_max, effects);
  if (const auto vehicle = wire::parse_own_topic(wire::plant_position_request_topic_prefix, input.source)) {
    if (!options.publish_ground_truth) return;
    if (auto position = GroundTruthPublisher::actual_position(input.at, *vehicle, input.payload, vehicles))
      effects.emplace_back(std::move(*position));
    return;
  }
  if (!input.source.starts_with(wire::zone_topic_prefix)) return;
  if (const auto news = exchange.on_message(input.source, input.payload, input.at, effects)) take_over(*news);
}

void PlantCore::Impl::on_port(const wire::Input& input, wire::Effects& effects) {
  const auto address = parse_port(input.source);
  if (!address || address->vehicle < 1 || address->vehicle > vehicles.size()) {
    effects.emplace_back(wire::Log{'w', "no vehicle has a port '" + input.source + "'"});
    return;
  }
  vehicles[address->vehicle - 1].boards().connect(address->board, input.payload == "up");
}

void PlantCore::Impl::on_bytes(const wire::Input& input, wire::Effects& effects) {
  const auto* frames = wire::frames_of(input.typed.get());
  if (frames != nullptr && frames->vehicle() >= 1 && frames->vehicle() <= vehicles.size())
    return vehicles[frames->vehicle() - 1].boards().on_frames(input.at, *frames);
  const auto address = parse_port(input.source);
  if (!address || address->vehicle < 1 || address->vehicle > vehicles.size()) {
    effects.emplace_back(wire::Log{'w', "bytes for '" + input.source + "', which no vehicle has"});
    return;
  }
  vehicles[address->vehicle - 1].boards().on_bytes(input.at, address->board, input.payload);
}

void PlantCore::Impl::on_command(std::string_view json, std::size_t bytes_max, wire::Effects& effects) {
  const auto command = JsonValue::parse(json, bytes_max);
  const auto error = command ? obey(*command, effects) : std::optional(command.error());
  if (error) effects.emplace_back(wire::Log{'w', "plant command refused: " + to_string(*error)});
  if (!error) persist(effects);
}

std::optional<Error> PlantCore::Impl::obey(const JsonValue& command, wire::Effects& effects) {
  if (const JsonValue* given = command.find("addObstacle")) return obstacles.add(*given, bodies);
  if (const auto id = command.text("removeObstacle")) return obstacles.remove(*id);
  if (const JsonValue* given = command.find("switch")) {
    auto configuration = zone::zone_configuration_from_json(*given);
    if (!configuration) return configuration.error();
    const auto news = exchange.switch_to(std::move(*configuration), effects);
    if (!news) return news.error();
    take_over(*news);
    return std::nullopt;
  }
  if (const JsonValue* given = command.find("changeBattery")) return change_battery(*given);
  if (const JsonValue* given = command.find("setLoad")) return set_load(*given);
  if (const JsonValue* given = command.find("setFault")) return set_fault(*given);
  return Error{"plant.command",
               R"(expected {"addObstacle":{"id","x","y","radius"}}, {"removeObstacle":"id"}, {"changeBattery":{…}}, )"
               R"({"setLoad":{…}}, {"setFault":{…}} or {"switch":{"format","origin","text"}})",
               {}};
}

Result<Vehicle*> PlantCore::Impl::vehicle_of(const JsonValue& command) {
  const auto number = command.number("vehicle");
  if (!number || !(*number >= 1.0 && *number <= static_cast<double>(vehicles.size())))
    return fail("plant.vehicle", "give a vehicle's number, from 1 to " + std::to_string(vehicles.size()), "vehicle");
  return &vehicles[static_cast<std::size_t>(*number) - 1];
}

/// What a person does to a vehicle. The vehicle's own program confirms the change, as it reads its RALI (A37).
std::optional<Error> PlantCore::Impl::change_battery(const JsonValue& given) {
  const auto vehicle = vehicle_of(given);
  if (!vehicle) return vehicle.error();
  const auto change = battery_change_from_json(given);
  if (!change) return change.error();
  (*vehicle)->power().change(*change);
  return std::nullopt;
}

std::optional<Error> PlantCore::Impl::set_load(const JsonValue& given) {
  const auto vehicle = vehicle_of(given);
  if (!vehicle) return vehicle.error();
  const auto factor = given.number("factor");
  if (!factor || !(*factor >= 0.1 && *factor <= 10.0))
    return Error{"plant.load", "give a factor from 0.1 to 10", "factor"};
  (*vehicle)->power().set_load_factor(*factor);
  return std::nullopt;
}

std::optional<Error> PlantCore::Impl::set_fault(const JsonValue& given) {
  const auto vehicle = vehicle_of(given);
  if (!vehicle) return vehicle.error();
  const auto fault = vehicle_fault_from_json(given);
  if (!fault) return fault.error();
  (*vehicle)->inject(now, *fault);
  return std::nullopt;
}

}  // namespace cosiva::physical
