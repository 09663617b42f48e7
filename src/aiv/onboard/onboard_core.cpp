#include "cosiva/aiv/onboard/onboard_core.h"

#include <functional>
#include <utility>

#include "cosiva/aiv/experiments/battery_exchange.h"
#include "cosiva/aiv/onboard/action_cycle.h"
#include "cosiva/aiv/onboard/action_executor.h"
#include "cosiva/aiv/onboard/announced_zone.h"
#include "cosiva/aiv/onboard/boards_link.h"
#include "cosiva/aiv/onboard/drive_cycle.h"
#include "cosiva/aiv/onboard/driving_context.h"
#include "cosiva/aiv/onboard/estimation_service.h"
#include "cosiva/aiv/onboard/order_receiver.h"
#include "cosiva/aiv/onboard/position_store.h"
#include "cosiva/aiv/onboard/state_reporter.h"
#include "cosiva/aiv/onboard/supervision.h"
#include "cosiva/aiv/onboard/v2x_participant.h"
#include "cosiva/aiv/onboard/virtual_perception.h"
#include "cosiva/aiv/onboard/zone_selection.h"
#include "cosiva/aiv/partners/server_proxy.h"
#include "cosiva/aiv/partners/server_selection.h"
#include "cosiva/base/archive.h"
#include "cosiva/base/expect.h"
#include "cosiva/base/json_value.h"
#include "cosiva/wire/messages/travel_frame.h"
#include "cosiva/wire/own/v2x_port.h"
#include "cosiva/wire/vda5050/codec.h"

namespace cosiva::aiv {
namespace {

/// Longer than a board needs to respond, and than RALI needs between two readings.
constexpr SimDuration starting_up_max = std::chrono::milliseconds{700};

void log(wire::Effects& effects, char level, std::string text) {
  effects.emplace_back(wire::Log{level, std::move(text)});
}

/// The vehicle is stopped, and no order or command makes it drive.
/// @param context  null: no zone is known
bool is_idle(const DrivingContext* context, const OrderActions& actions) {
  if (actions.left()) return false;
  if (context == nullptr) return true;
  const VehicleState& vehicle = context->vehicle();
  return vehicle.motion().stopped() && !vehicle.order().active() && !vehicle.joining() && !vehicle.back_up().active();
}

V2xParticipant::Mode v2x_mode_of(const OnboardOptions& options) {
  return {.direct = options.v2x_direct,
          .as_values = options.as_values,
          .dense = options.v2x_direct || options.link_loss == LinkLoss::finish_base};
}

void report(const Result<void>& taken, wire::Effects& effects) {
  if (!taken) log(effects, 'w', to_string(taken.error()));
}

/// Subscribes to all topics besides subscriptions().
void subscribe(const V2xParticipant& v2x, const ServerSelection& server, wire::Effects& effects) {
  std::vector<std::string> filters = v2x.filters();
  const std::vector<std::string> of_server = server.filters();
  filters.insert(filters.end(), of_server.begin(), of_server.end());
  effects.emplace_back(wire::Listen{std::move(filters)});
}

}  // namespace

/// The parts of the program, and the dispatch of inputs to them.
struct OnboardCore::Parts {
  explicit Parts(OnboardOptions o)
      : options{std::move(o)},
        boards{options.number, options.as_values, options.rali},
        supervision{options.link_timeout, options.rali},
        server_proxy{options.id, options.interface_name, options.as_values},
        reporter{options},
        positions{options},
        v2x{options.id, options.v2x, v2x_mode_of(options)},
        drive_cycle{supervision, perception, v2x, boards, server_proxy},
        actions{*this},
        orders{{server_proxy, reporter, actions.instant, drive_cycle, zones, actions.of_order}, options.cycle} {}

  void archive(Archive& archive);
  void on_restore(const wire::Input& input, wire::Effects& effects);
  void on_link(const wire::Input& input, wire::Effects& effects);
  void on_port(const wire::Input& input);
  void on_bytes(const wire::Input& input, wire::Effects& effects);
  void on_frames(SimTime now, const wire::BoardFrames& frames, wire::Effects& effects);
  void on_message(const wire::Input& input, wire::Effects& effects);
  void on_tick(SimTime now, wire::Effects& effects);

  /// @param messages  of one board; `message_of` gives the content of each
  template <typename Messages, typename MessageOf>
  void on_board_messages(SimTime now, wire::Board board, const Messages& messages, MessageOf message_of,
                         wire::Effects& effects);
  void on_board(SimTime now, const wire::Hello& hello);
  void on_board(SimTime now, const wire::Odometry& odometry);
  void on_board(SimTime now, const wire::TagRead& tag);
  void on_board(SimTime now, const wire::Ranges& ranges);
  void on_board(SimTime now, const wire::Power& power);

  void on_virtual_bodies(const wire::Input& input, wire::Effects& effects);
  void on_owner(const wire::Input& input, wire::Effects& effects);
  void on_server_connection(const wire::Input& input, wire::Effects& effects);
  /// The virtual bodies of the server that the vehicle obeyed no longer exist, and it may be supervised no longer.
  void on_server_end();
  void on_zone(SimTime now, const zone::ZoneConfiguration& announced, std::shared_ptr<const zone::Rtm> built,
               wire::Effects& effects);
  void on_zone_message(const wire::Input& input, wire::Effects& effects);
  void enter_first_zone(SimTime now, const zone::Rtm& rtm, wire::Effects& effects);
  void end_zone_switch(SimTime now, wire::Effects& effects);

  void publish_detection(SimTime now, wire::Effects& effects);
  /// The boards respond a moment after the program: reported at once, their absence would raise six false alarms.
  [[nodiscard]] bool starting_up(SimTime now) const;
  [[nodiscard]] ReportSources sources(SimTime now) const;

  OnboardOptions options;
  BoardsLink boards;
  Supervision supervision;
  ServerProxy server_proxy;
  ServerSelection server;
  ZoneSelection zones;
  std::unique_ptr<DrivingContext> context;  ///< none before a zone is known
  StateReporter reporter;
  PositionStore positions;
  struct Experiments {
    EstimationService estimation;
    BatteryExchange battery;
  };
  Experiments experiments;
  V2xParticipant v2x;
  VirtualPerception perception;
  DriveCycle drive_cycle;
  struct Actions {
    /// @param parts  all that are declared before the actions
    explicit Actions(Parts& parts)
        : of_order{parts.options.actions, parts.reporter},
          instant{{parts.server_proxy, parts.reporter, parts.positions, parts.drive_cycle, parts.zones, parts.server,
                   parts.boards, of_order.actions()}} {}
    ActionCycle of_order;
    ActionExecutor instant;
  };
  Actions actions;
  OrderReceiver orders;
};

void OnboardCore::Parts::on_restore(const wire::Input& input, wire::Effects& effects) {
  auto restored = persisted_position_from_json(input.payload);
  if (!restored) return log(effects, 'w', "saved position not used: " + to_string(restored.error()));
  actions.of_order.actions().restore_loads(restored->loads);
  positions.restore(std::move(*restored), context.get());
}

void OnboardCore::Parts::on_link(const wire::Input& input, wire::Effects& effects) {
  const bool up = input.payload == "up";
  server_proxy.set_online(up);
  if (!up) return;
  supervision.on_broker_message(input.at);
  server_proxy.publish(input.at, wire::ConnectionState::online, effects);
  if (context) reporter.publish_factsheet(input.at, context->zone(), server_proxy, effects);
  reporter.request_report();
  perception.request_response();
}

void OnboardCore::Parts::on_port(const wire::Input& input) {
  const auto board = boards.board_of(input.source);
  if (!board) return;
  const bool up = input.payload == "up";
  boards.on_port(*board, up);
  if (!up) supervision.forget_board(*board);
}

void OnboardCore::Parts::on_bytes(const wire::Input& input, wire::Effects& effects) {
  if (const auto* frames = wire::frames_of(input.typed.get())) return on_frames(input.at, *frames, effects);
  if (const auto source = wire::v2x_source(input.source)) {
    if (context && options.v2x_direct) v2x.on_direct(input.at, *source, input, *context, effects);
    return;
  }
  const auto board = boards.board_of(input.source);
  if (!board) return;
  on_board_messages(input.at, *board, boards.on_bytes(*board, input.payload), std::identity{}, effects);
}

void OnboardCore::Parts::on_frames(SimTime now, const wire::BoardFrames& frames, wire::Effects& effects) {
  for (std::size_t next = 0; next < frames.frames().size();) {
    const auto of_board = frames.run_of_board(next);
    next += of_board.size();
    boards.on_frames(of_board);
    on_board_messages(now, of_board.front().board, of_board, &wire::BoardFrames::Frame::message, effects);
    // As after each board's bytes; after the last board's frames handle() does.
    if (next < frames.frames().size() && reporter.state_due(now))
      reporter.publish_state(sources(now), starting_up(now), server_proxy, effects);
  }
}

template <typename Messages, typename MessageOf>
void OnboardCore::Parts::on_board_messages(SimTime now, wire::Board board, const Messages& messages,
                                           MessageOf message_of, wire::Effects& effects) {
  for (const auto& each : messages) {
    supervision.on_board_message(now, board);
    std::visit(
        [&](const auto& m) {
          // Heartbeats belong to the link, and commands are not messages of a board.
          if constexpr (requires { on_board(now, m); }) on_board(now, m);
        },
        std::invoke(message_of, each));
  }
  if (const auto restarted = boards.take_restarted()) reporter.report_restart(*restarted, effects);
  if (boards.take_new_ranges()) publish_detection(now, effects);
  experiments.estimation.publish(server_proxy, effects);
}

void OnboardCore::Parts::on_message(const wire::Input& input, wire::Effects& effects) {
  switch (server_proxy.deliver(input.source, server.topics())) {
    case ServerMessage::none: break;
    case ServerMessage::heartbeat:
      // A retained heartbeat is of unknown age.
      if (!input.flag && !input.payload.empty()) supervision.on_server_heartbeat(input.at);
      break;
    case ServerMessage::virtual_obstacles: on_virtual_bodies(input, effects); break;
    case ServerMessage::order: orders.on_order(input, context.get(), effects); break;
    case ServerMessage::instant_actions:
      actions.instant.on_message(input.at, input.payload, context.get(), effects);
      break;
    case ServerMessage::connection: on_server_connection(input, effects); break;
    case ServerMessage::estimate_request:
      experiments.estimation.on_request(input.at, input.payload, server_proxy, effects);
      break;
    case ServerMessage::battery_change: report(experiments.battery.on_request(input.payload), effects); break;
    case ServerMessage::battery_fitted: report(experiments.battery.on_fitted(input.payload), effects); break;
    case ServerMessage::owner: on_owner(input, effects); break;
    case ServerMessage::zone: on_zone_message(input, effects); break;
  }
}

void OnboardCore::Parts::on_zone_message(const wire::Input& input, wire::Effects& effects) {
  if (const auto* announced = dynamic_cast<const AnnouncedZone*>(input.typed.get()))
    return on_zone(input.at, announced->rtm()->configuration(), announced->rtm(), effects);
  // An empty message clears the topic of a format that the zone no longer has.
  if (input.payload.empty()) return;
  on_zone(input.at,
          zone::from_payload(input.source.substr(server.topics().zone_prefix.size()), input.source, input.payload),
          nullptr, effects);
}

void OnboardCore::Parts::on_board(SimTime, const wire::Hello& hello) {
  if (hello.board != wire::Board::PILS) return;
  const bool powered_up_anew = positions.on_pils_hello(hello.session);
  if (!context) return;
  if (powered_up_anew) context->vehicle().estimator().on_odometer_reset();
  positions.find_position(*context);
}

void OnboardCore::Parts::on_board(SimTime now, const wire::Odometry& odometry) {
  if (!context) return;
  experiments.estimation.on_odometry(now, context->zone().circuit.indirect() ? turned_round(odometry) : odometry,
                                     *context);
  if (!context->vehicle().position().pose_known()) positions.find_position(*context);
}

void OnboardCore::Parts::on_board(SimTime now, const wire::TagRead& tag) {
  if (!context) return;
  const PositionEstimator& position = context->vehicle().position();
  const auto last_number = [&position] {
    const auto& last_tag = position.last_tag();
    return last_tag ? std::optional{last_tag->number} : std::nullopt;
  };
  const auto last = last_number();
  experiments.estimation.on_tag(now, tag, *context);
  const auto fix = context->vehicle().on_tag(tag);
  // A beacon every few centimetres is no event; a tag is (A13), and so is the correction of a wrong estimate.
  if (last_number() != last || fix.kind == FixKind::relocated) reporter.request_report();
}

void OnboardCore::Parts::on_board(SimTime, const wire::Ranges& ranges) {
  if (!context) return;
  const bool indirect = context->zone().circuit.indirect();
  if (points_forwards(ranges) == indirect) return;  // the fan points backwards: the vehicle does not drive meanwhile
  context->vehicle().on_ranges(indirect ? turned_round(ranges) : ranges);
}

void OnboardCore::Parts::on_board(SimTime now, const wire::Power& power) {
  experiments.battery.on_power(now, power);
  if (context) context->agent().on_charge(power.charge());
}

void OnboardCore::Parts::on_virtual_bodies(const wire::Input& input, wire::Effects& effects) {
  if (!context || !perception.on_bodies(input.at, input, *context, effects)) return;
  drive_cycle.run(input.at, *context, effects);
  perception.acknowledge(input.at, *context, server_proxy, effects);
}

void OnboardCore::Parts::on_owner(const wire::Input& input, wire::Effects& effects) {
  if (!server.on_owner(input.payload, effects)) return;
  if (server.has_area())
    supervision.expect_server(input.at);
  else
    supervision.server_left();
  on_server_end();
  perception.request_response();
  subscribe(v2x, server, effects);
}

void OnboardCore::Parts::on_server_connection(const wire::Input& input, wire::Effects& effects) {
  constexpr std::size_t bytes_max = 4096;
  const auto json = JsonValue::parse(input.payload, bytes_max);
  const auto state = json ? json->text("connectionState") : std::nullopt;
  if (!state) return log(effects, 'w', "the server's connection message has no connectionState");
  if (*state != wire::vda5050::to_string(wire::ConnectionState::offline)) return;
  supervision.server_left();
  on_server_end();
}

void OnboardCore::Parts::on_server_end() {
  if (!is_idle(context.get(), actions.of_order.actions()))
    return;  // the message may be wrong: the bodies expire, and the watchdog stays armed
  (void)supervision.release_server();
  if (context) context->virtual_bodies().forget();
}

void OnboardCore::Parts::on_zone(SimTime now, const zone::ZoneConfiguration& announced,
                                 std::shared_ptr<const zone::Rtm> built, wire::Effects& effects) {
  using enum ZoneSelection::Verdict;
  const auto [verdict, rtm] =
      zones.on_announced(announced, std::move(built), context ? &context->zone() : nullptr, effects);
  if (verdict == unchanged) return;
  reporter.request_report();
  if (verdict == first) return enter_first_zone(now, *rtm, effects);
  if (!context) return;
  context->vehicle().hold(Hold::zone_change, zones.pending() != nullptr);
  if (verdict != edited) return;
  context->adopt_fiducials(rtm->zone());
  zones.enforce(*rtm);
  const zone::TrafficZone& zone = context->zone();
  log(effects, 'i',
      "tags and beacons of '" + zone.name + "' as announced: " + std::to_string(zone.tags.size()) + " tags");
}

void OnboardCore::Parts::enter_first_zone(SimTime now, const zone::Rtm& rtm, wire::Effects& effects) {
  COSIVA_EXPECT(!context);
  context = std::make_unique<DrivingContext>(rtm.zone(), options);
  zones.enforce(rtm);
  if (boards.power()) context->agent().on_charge(boards.power()->charge());
  positions.on_first_zone(*context, effects);
  actions.instant.on_first_zone(now, *context, effects);
  reporter.publish_factsheet(now, context->zone(), server_proxy, effects);
}

void OnboardCore::Parts::end_zone_switch(SimTime now, wire::Effects& effects) {
  // Without odometry the vehicle may still be braking.
  if (!zones.pending() || !context->vehicle().motion().stopped() || supervision.board_lost(now, wire::Board::PILS))
    return;
  actions.instant.end_waits(context->vehicle());
  const std::string from = context->zone().name;
  context = std::make_unique<DrivingContext>(zones.pending()->zone(), options, context->agent());
  zones.enforce(*zones.pending());
  actions.of_order.on_zone_switched();
  actions.instant.on_zone_switched();
  experiments.estimation.on_zone_switched();
  perception.on_zone_switched();
  v2x.on_zone_switched();
  positions.on_zone_switched(*context);
  reporter.request_report();
  reporter.publish_factsheet(now, context->zone(), server_proxy, effects);
  const PositionEstimator& position = context->vehicle().position();
  const auto off_by = std::to_string(position.off_path_estimator().off_by_m()) + " m";
  const bool away = position.pose_known() && !position.known();
  log(effects, away ? 'w' : 'i',
      "zone '" + context->zone().name + "' in force after '" + from + "'" +
          (away                   ? ", whose nearest path passes " + off_by + " from here: off-route"
           : position.near_path() ? ", " + off_by + " off its nearest path"
                                  : ""));
}

void OnboardCore::Parts::on_tick(SimTime now, wire::Effects& effects) {
  boards.on_tick(now, effects);
  if (supervision.take_link_check(now)) server_proxy.publish(now, wire::LinkCheck{}, effects);
  if (is_idle(context.get(), actions.of_order.actions()) && supervision.release_server() && context)
    context->virtual_bodies().forget();
  if (context) {
    actions.of_order.run(now, *context, effects);
    drive_cycle.run(now, *context, effects);
    actions.instant.end_waits(context->vehicle());
    end_zone_switch(now, effects);
    positions.keep_loads(actions.of_order.actions().loads().loads());
    positions.on_tick(now, *context, effects);
    reporter.update_display(now, context->agent(), boards, effects);
    reporter.publish_visualization(now, *context, server_proxy, effects);
    if (v2x.update_cell(*context)) subscribe(v2x, server, effects);
    v2x.publish_intent(now, *context, server_proxy.online(), effects);
    v2x.publish_claims(now, *context, effects);
  }
  if (const auto ready = experiments.battery.take_ready(now, !context || context->vehicle().motion().stopped()))
    server_proxy.publish(*ready, effects);
  if (reporter.boards_report_due(now) && !starting_up(now))
    reporter.publish_boards_report(sources(now), boards.ranges(), v2x.proxies(), server_proxy, effects);
  reporter.compare_flags(flags_of(sources(now)));
}

void OnboardCore::Parts::publish_detection(SimTime now, wire::Effects& effects) {
  if (!context || !context->vehicle().position().known()) return;
  const VehicleState& vehicle = context->vehicle();
  const zone::TrafficZone& zone = context->zone();
  const Pose2 X_BS{0.5 * zone.vehicle.length_m, 0.0, 0.0};
  // The sensor is at the vehicle's leading end, in either direction.
  const wire::Ranges& ranges = *boards.ranges();
  auto detection =
      context->sighting().on_frame(now, vehicle.watch().scan(), zone.circuit.indirect() ? turned_round(ranges) : ranges,
                                   vehicle.position().pose() * X_BS, vehicle.watch().reach_m());
  if (!detection) return;
  detection->map_id = zone.name;
  server_proxy.publish(now, std::move(*detection), effects);
}

bool OnboardCore::Parts::starting_up(SimTime now) const {
  return boards.uptime(now) < starting_up_max && (supervision.any_board_lost(now) || (options.rali && !boards.power()));
}

ReportSources OnboardCore::Parts::sources(SimTime now) const {
  return {now,
          context ? &context->agent() : nullptr,
          zones.maps(),
          zones.refusal(),
          boards,
          supervision,
          actions.instant.book(),
          reporter.warnings(),
          boards.power(),
          &actions.of_order.actions()};
}

OnboardCore::OnboardCore(OnboardOptions options) : parts_{std::make_unique<Parts>(std::move(options))} {}
OnboardCore::~OnboardCore() = default;

void OnboardCore::handle(const wire::Input& input, wire::Effects& effects) {
  Parts& parts = *parts_;
  now_ = input.at;
  switch (input.kind) {
    case wire::InputKind::configure:
      parts.boards.start(now_);
      if (parts.options.zone) parts.on_zone(now_, *parts.options.zone, parts.options.rtm, effects);
      break;
    case wire::InputKind::restore: parts.on_restore(input, effects); break;
    case wire::InputKind::proposal:
    case wire::InputKind::persisted:
    case wire::InputKind::snapshot: return;  // of a store, which gives them to no core
    case wire::InputKind::link: parts.on_link(input, effects); break;
    case wire::InputKind::port: parts.on_port(input); break;
    case wire::InputKind::bytes: parts.on_bytes(input, effects); break;
    case wire::InputKind::message:
      parts.supervision.on_broker_message(now_);
      // Intents are no reason to report: they come often, and change nothing that a state contains.
      if (input.source.starts_with(wire::v2x_topic_prefix)) {
        if (parts.context) parts.v2x.on_intent(now_, input, *parts.context, effects);
        return;
      }
      parts.on_message(input, effects);
      break;
    case wire::InputKind::tick: parts.on_tick(now_, effects); break;
    case wire::InputKind::command: break;  // no operator commands a vehicle from its own machine
  }
  COSIVA_EXPECT(parts.zones.maps().empty() == (parts.context == nullptr));
  // A state is due after one input in fifty.
  if (parts.reporter.state_due(now_))
    parts.reporter.publish_state(parts.sources(now_), parts.starting_up(now_), parts.server_proxy, effects);
  parts.boards.flush(effects);
}

std::vector<std::string> OnboardCore::subscriptions() const {
  // The owner comes first: of the zones that a broker retains, a restored position belongs to the owner's.
  const ServerProxyTopics& topics = parts_->server_proxy.topics();
  return {topics.owner,
          topics.order,
          topics.instant_actions,
          topics.virtual_obstacles,
          topics.estimate_request,
          topics.battery_change,
          topics.battery_fitted,
          topics.link_check,
          std::string(wire::server_heartbeat_topic),
          std::string(wire::server_connection_topic),
          wire::topics_below(wire::zone_topic_prefix, 1)};
}

std::optional<wire::Will> OnboardCore::will() const { return parts_->server_proxy.will(now_); }

void OnboardCore::farewell(SimTime now, wire::Effects& effects) {
  now_ = now;
  if (const auto& context = parts_->context) {
    const auto braking = context->zone().profiles.medium.braking_mps2;
    const wire::Drive stop{0, 0, static_cast<std::uint16_t>(1000.0 * braking), 0};
    parts_->boards.send(wire::Board::PILS, stop, effects);
    parts_->positions.save_now(*context, effects);
  }
  parts_->server_proxy.publish(now, wire::ConnectionState::offline, effects);
  parts_->boards.flush(effects);
}

void OnboardCore::fold(Digest& digest) const {
  digest.add(std::string_view{parts_->options.id.serial_number});
  digest.add(std::uint64_t{parts_->context != nullptr});
  parts_->actions.of_order.fold(digest);
  if (!parts_->context) return;
  const DrivingContext& context = *parts_->context;
  const VehicleState& vehicle = context.vehicle();
  const PositionEstimator& position = vehicle.position();
  digest.add(std::uint64_t{position.known()});
  if (position.known()) {
    digest.add(std::uint64_t{position.track_position().section});
    digest.add(position.track_position().s_m);
  }
  if (position.off_path() && position.pose_known()) {
    const Pose2 X_MB = position.pose();
    digest.add(X_MB.x_m);
    digest.add(X_MB.y_m);
    digest.add(X_MB.heading_rad);
  }
  digest.add(position.travelled_m());
  digest.add(vehicle.motion().speed_mps());
  digest.add(std::uint64_t{vehicle.holds().bits()});
  digest.add(std::string_view{vehicle.order().ids().order_id});
  digest.add(std::uint64_t{vehicle.order().ids().order_update_id});
  digest.add(std::uint64_t{vehicle.order().last_node().sequence_id});
  digest.add(std::uint64_t{context.agent().decision().braking_for_virtual});
  context.virtual_bodies().fold(digest);
  context.sighting().fold(digest);
  context.neighbours().fold(digest);
}

SimDuration OnboardCore::tick_period() const { return parts_->options.cycle; }

std::string OnboardCore::persisted_bytes() const { return parts_->positions.saved_json(); }

const OnboardOptions& OnboardCore::options() const { return parts_->options; }

std::vector<std::string> OnboardCore::ports() const { return parts_->boards.ports(); }

std::optional<Pose2> OnboardCore::estimated_pose() const {
  const auto& context = parts_->context;
  if (!context || !context->vehicle().position().pose_known()) return std::nullopt;
  return body_pose(context->zone(), context->vehicle().position().pose());
}

double OnboardCore::estimated_speed_mps() const {
  return parts_->context ? parts_->context->vehicle().motion().speed_mps() : 0.0;
}

void OnboardCore::Parts::archive(Archive& archive) {
  archive(boards, supervision, server_proxy, server, zones);
  bool in_zone = context != nullptr;
  archive(in_zone);
  if (archive.reads()) {
    context.reset();
    const zone::ZoneConfiguration* configuration = zones.configuration();
    if (!archive.failed() && in_zone != (configuration != nullptr)) archive.fail("a vehicle without its zone");
    const auto rtm = archive.failed() || !in_zone ? nullptr : zone::rtm_from(archive, *configuration);
    if (rtm) context = std::make_unique<DrivingContext>(rtm->zone(), options);
  }
  if (context) archive(*context);
  archive(reporter, positions, experiments.estimation, v2x, perception, actions.of_order, actions.instant);
}

void OnboardCore::archive(Archive& archive) { archive(*parts_, now_); }

}  // namespace cosiva::aiv
