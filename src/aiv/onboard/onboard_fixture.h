#pragma once

#include <algorithm>
#include <cmath>
#include <deque>
#include <functional>
#include <map>
#include <optional>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "cosiva/aiv/onboard/onboard_core.h"
#include "cosiva/aiv/testing/test_line_world.h"
#include "cosiva/aiv/testing/test_orders.h"
#include "cosiva/aiv/testing/test_senses.h"
#include "cosiva/aiv/testing/test_zone.h"
#include "cosiva/wire/module_link/module_link.h"
#include "cosiva/wire/own/link_check.h"
#include "cosiva/wire/own/own_messages.h"
#include "cosiva/wire/own/v2x.h"
#include "cosiva/wire/own/v2x_port.h"
#include "cosiva/wire/vda5050/codec.h"

namespace cosiva::aiv::test {

/// A vehicle's program between four boards and a broker, all of them simulated here: exact wheels, an obstacle sensor
/// for point obstacles, tags on demand. Every message that the program publishes is decoded; a message that does not
/// decode fails.
class OnboardFixture {
 public:
  struct Setup {
    bool zone_notified{true};
    std::optional<OnboardOptions::Start> start{OnboardOptions::Start{"loop_se", 0.0}};
    std::string persisted{};
    std::uint32_t session{77};
    zone::TrackPosition ground_truth{at(lacet4(), "loop_se", 0.0)};
    double odometer_m{0.0};
    std::optional<zone::ZoneConfiguration> zone{};  ///< announced at first; lacet4 without
    const zone::Circuit* floor{&lacet4().circuit};
    bool boards_up{true};
    bool broker_up{true};
    bool v2x{true};
    bool rali{true};
    bool direct{false};
    LinkLoss link_loss{LinkLoss::brake};
  };

  OnboardFixture() : OnboardFixture(Setup{}) {}
  explicit OnboardFixture(const Setup& setup) : session_{setup.session}, world{*setup.floor, setup.ground_truth} {
    world.odometer_m = setup.odometer_m;
    OnboardOptions options;
    if (setup.zone_notified) options.zone = setup.zone ? *setup.zone : lacet4_configuration();
    options.start = setup.start;
    options.v2x = setup.v2x;
    options.rali = setup.rali;
    options.v2x_direct = setup.direct;
    options.link_loss = setup.link_loss;
    core = std::make_unique<OnboardCore>(options);
    feed(wire::InputKind::configure, "aiv", to_json(options));
    if (!setup.persisted.empty()) feed(wire::InputKind::restore, "state", setup.persisted);
    if (setup.broker_up) link(true);
    if (setup.boards_up) {
      for (const wire::Board board : wire::all_boards)
        if (setup.rali || board != wire::Board::RALI) plug(board);
    }
  }

  // --- the world ----------------------------------------------------------------------------------------------------

  void plug(wire::Board board) {
    alive.insert(board);
    feed(wire::InputKind::port, wire::port_name(1, board), "up");
    send_from_board(board, wire::Hello{board, 1, 0xF00D, session_});
  }
  /// The board stops responding; its cable stays.
  void silence(wire::Board board) { alive.erase(board); }
  void send_from_board(wire::Board board, const wire::BoardMessage& message) {
    board_message_at[board] = now;
    feed(wire::InputKind::bytes, wire::port_name(1, board), encoders_[board].encode(message));
  }
  void receive(std::string_view topic, std::string payload, bool retained = false) {
    broker_message_at = now;
    feed(wire::InputKind::message, std::string(topic), std::move(payload), retained);
  }
  void order(const wire::Order& text) {
    receive(wire::vda_topic({"CoSiVA", "AIV1"}, "order"), wire::vda5050::encode(text));
  }
  void act(std::string type, std::string id, std::vector<wire::Parameter> parameters = {}) {
    wire::InstantActions message;
    message.header = header();
    message.actions.push_back({std::move(type), std::move(id), "", wire::BlockingType::none, std::move(parameters)});
    receive(wire::vda_topic({"CoSiVA", "AIV1"}, "instantActions"), wire::vda5050::encode(message));
  }
  [[nodiscard]] wire::Header header() const { return {1, now, "2.1.0", "CoSiVA", "AIV1"}; }
  void link(bool up) {
    linked_ = up;
    if (up) broker_message_at = now;
    feed(wire::InputKind::link, "broker", up ? "up" : "down");
  }

  void run(double seconds) {
    for (int i = 0; i < static_cast<int>(std::lround(seconds * 100.0)); ++i) step();
  }
  bool run_until(const std::function<bool()>& done, double seconds) {
    for (int i = 0; i < static_cast<int>(std::lround(seconds * 100.0)) && !done(); ++i) step();
    return done();
  }

  void step() {
    now += std::chrono::milliseconds{10};
    ++steps_;
    roll(0.01);
    const auto every = [&](int count) { return steps_ % count == 0; };
    if (linked_ && !broker_frozen) {
      if (server_heartbeats && every(10)) receive(wire::server_heartbeat_topic, R"({"headerId":1})");
      for (; !echoes_.empty() && echoes_.front() <= now; echoes_.pop_front())
        receive(wire::own_topic(wire::link_check_topic_prefix, {"CoSiVA", "AIV1"}), "{}");
    }
    for (const auto& [board, number] : std::exchange(requested_tests, {}))
      if (alive.contains(board)) send_from_board(board, wire::SelfTestResult{number, findings[board]});
    if (every(10)) {
      for (const wire::Board board : alive) send_from_board(board, wire::Heartbeat{0, 0, 0, self_test[board]});
    }
    if (alive.contains(wire::Board::PILS) && every(2)) {
      send_from_board(wire::Board::PILS, world.odometry());
    }
    if (alive.contains(wire::Board::DOBS) && every(6)) {
      send_from_board(wire::Board::DOBS, ranges_to(obstacles, world.pose()));
    }
    if (alive.contains(wire::Board::RALI) && every(50))
      send_from_board(wire::Board::RALI, wire::Power{7400, 300, 250, charge});
    if (every(2)) feed(wire::InputKind::tick, "", "");
  }

  // --- outputs of the program
  // -----------------------------------------------------------------------------------------

  void feed(wire::InputKind kind, std::string source, std::string payload, bool flag = false) {
    effects_.clear();
    core->handle({now, kind, std::move(source), std::move(payload), flag}, effects_);
    take(effects_);
  }
  void farewell() {
    effects_.clear();
    core->farewell(now, effects_);
    take(effects_);
  }

  [[nodiscard]] const wire::State& state() const { return states.back(); }
  /// A new process of the same vehicle, with the state that the old process saved.
  [[nodiscard]] Setup reborn() const {
    Setup setup;
    setup.persisted = persisted;
    setup.ground_truth = ground_truth.track_position(lacet4().circuit);
    setup.odometer_m = world.odometer_m;
    return setup;
  }
  /// The last command to the motors.
  [[nodiscard]] const wire::Drive& last_drive() const { return *drive_; }
  [[nodiscard]] std::vector<std::string> error_types() const {
    std::vector<std::string> types;
    for (const auto& error : state().errors) types.push_back(error.type);
    return types;
  }
  [[nodiscard]] std::optional<wire::ActionState> action(std::string_view id) const {
    const auto& all = state().action_states;
    const auto it = std::ranges::find(all, id, &wire::ActionState::action_id);
    return it == all.end() ? std::nullopt : std::optional(*it);
  }

 private:
  std::uint32_t session_;

 public:
  SimTime now{virtual_epoch};
  std::unique_ptr<OnboardCore> core;
  LineWorld world;
  AivMotion& ground_truth{world.ground_truth};
  double& speed_mps{world.speed_mps};
  bool server_heartbeats{false};
  bool broker_frozen{false};  ///< its connection stays open, and nothing passes
  int link_checks{0};         ///< published by the vehicle
  SimDuration echo_delay{};   ///< after which the broker returns a message of the vehicle to itself
  SimTime broker_message_at{};
  std::map<wire::Board, SimTime> board_message_at;
  std::uint16_t charge{900};
  std::set<wire::Board> alive;
  std::map<wire::Board, std::uint8_t> self_test;
  std::map<wire::Board, std::uint8_t> requested_tests;  ///< performed in the next step
  std::map<wire::Board, std::vector<wire::PartFinding>> findings;
  std::vector<Point2> obstacles;

  std::vector<wire::Publish> published;
  std::vector<wire::State> states;
  std::vector<wire::Visualization> visualizations;
  std::vector<wire::Connection> connections;
  std::vector<wire::Factsheet> factsheets;
  std::vector<wire::VirtualObstaclesAck> felts;
  std::vector<wire::DetectedObstacleReport> sightings;
  std::vector<wire::BoardsReport> boards_reports;
  std::vector<wire::Intent> intents;
  std::vector<wire::Intent> direct_intents;
  std::vector<std::string> listens;  ///< filters besides the subscriptions
  std::vector<SimTime> state_times;
  std::vector<std::string> displayed;
  std::string persisted;
  std::vector<wire::Log> logs;
  std::vector<std::string> undecodable;
  int drives{0};
  int requests{0};  ///< for Hello

 private:
  void roll(double dt) {
    constexpr auto watchdog = std::chrono::milliseconds{300};
    const bool driven = drive_ && now - driven_at_ <= watchdog;
    world.step(driven ? &*drive_ : nullptr, dt);
  }

  void take(const wire::Effects& effects) {
    for (const wire::Effect& effect : effects) {
      if (const auto* publish = std::get_if<wire::Publish>(&effect)) take(*publish);
      if (const auto* send = std::get_if<wire::SendBytes>(&effect)) take(*send);
      if (const auto* persist = std::get_if<wire::Persist>(&effect)) persisted = persist->bytes;
      if (const auto* line = std::get_if<wire::Log>(&effect)) logs.push_back(*line);
      if (const auto* listen = std::get_if<wire::Listen>(&effect)) listens = listen->filters;
    }
  }

  template <typename Message>
  void keep(Result<Message> decoded, std::vector<Message>& all, const wire::Publish& publish) {
    if (decoded)
      all.push_back(std::move(*decoded));
    else
      undecodable.push_back(publish.topic + ": " + to_string(decoded.error()));
  }

  void take(const wire::Publish& publish) {
    published.push_back(publish);
    static const wire::VehicleId id{"CoSiVA", "AIV1"};
    const auto topic = wire::parse_vda_topic(publish.topic);
    const std::string name = topic ? topic->name : "";
    if (name == "state") {
      keep(wire::vda5050::decode_state(publish.payload), states, publish);
      state_times.push_back(now);
    } else if (name == "visualization") {
      keep(wire::vda5050::decode_visualization(publish.payload), visualizations, publish);
    } else if (name == "connection") {
      keep(wire::vda5050::decode_connection(publish.payload), connections, publish);
    } else if (name == "factsheet") {
      keep(wire::vda5050::decode_factsheet(publish.payload), factsheets, publish);
    } else if (publish.topic == wire::own_topic(wire::link_check_topic_prefix, id)) {
      ++link_checks;
      echoes_.push_back(now + echo_delay);
    } else if (publish.topic == wire::own_topic(wire::virtual_obstacles_ack_topic_prefix, id)) {
      keep(wire::virtual_obstacles_ack_from_json(publish.payload), felts, publish);
    } else if (publish.topic == wire::own_topic(wire::detected_obstacle_topic_prefix, id)) {
      keep(wire::detected_obstacle_from_json(publish.payload), sightings, publish);
    } else if (publish.topic == wire::own_topic(wire::boards_topic_prefix, id)) {
      keep(wire::boards_report_from_json(publish.payload), boards_reports, publish);
    } else if (wire::parse_v2x_topic(publish.topic)) {
      keep(wire::intent_from_json(publish.payload), intents, publish);
    } else {
      undecodable.push_back("unexpected topic " + publish.topic);
    }
  }

  void take(const wire::SendBytes& send) {
    if (send.port == wire::v2x_port) {
      auto intent = wire::intent_from_json(send.bytes);
      if (intent)
        direct_intents.push_back(std::move(*intent));
      else
        undecodable.push_back(send.bytes);
      return;
    }
    std::vector<wire::BoardMessage> messages;
    decoders_[send.port].feed(send.bytes, messages);
    for (const auto& message : messages) {
      if (const auto* drive = std::get_if<wire::Drive>(&message)) {
        drive_ = *drive;
        driven_at_ = now;
        ++drives;
      }
      if (const auto* display = std::get_if<wire::Display>(&message)) displayed.push_back(display->text);
      if (std::holds_alternative<wire::Hello>(message)) ++requests;
      const auto* test = std::get_if<wire::SelfTestRequest>(&message);
      if (test == nullptr) continue;
      for (const wire::Board board : wire::all_boards)
        if (send.port == wire::port_name(1, board)) requested_tests[board] = test->number;
    }
  }

  int steps_{0};
  bool linked_{false};
  std::deque<SimTime> echoes_;  ///< when the broker returns the messages of the vehicle to itself
  std::map<wire::Board, wire::module_link::Encoder> encoders_;
  std::map<std::string, wire::module_link::Decoder> decoders_;
  std::optional<wire::Drive> drive_;
  SimTime driven_at_{};
  wire::Effects effects_;
};

}  // namespace cosiva::aiv::test
