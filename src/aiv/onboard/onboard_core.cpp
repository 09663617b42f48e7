#include "aiv/onboard/onboard_core.h"

#include <utility>

#include "aiv/onboard/inside.h"

namespace cosiva::aiv {

void OnboardCore::Inside::on_configure(wire::Effects& effects) {
  if (options.zone) use_zone(*options.zone, effects);
}

void OnboardCore::Inside::on_recall(const wire::Input& input, wire::Effects& effects) {
  auto recalled = memory_from_json(input.payload);
  if (!recalled) {
    log(effects, 'w', "memory not used: " + to_string(recalled.error()));
    return;
  }
  memory = std::move(*recalled);
  if (agent) {
    agent->hold(Hold::paused, memory->paused);
    agent->impose(memory->imposed);
  }
  find_place();
}

void OnboardCore::Inside::on_link(const wire::Input& input, wire::Effects& effects) {
  const bool up = input.payload == "up";
  supervision.broker(input.at, up);
  session.set_online(up);
  if (!up) return;
  session.publish(input.at, wire::ConnectionState::online, effects);
  publish_factsheet(input.at, effects);
  state_due = true;
  owes_answer = true;
}

void OnboardCore::Inside::on_port(const wire::Input& input) {
  const auto board = boards.board_of(input.source);
  if (!board) return;
  const bool up = input.payload == "up";
  boards.on_port(*board, up);
  if (!up) supervision.board_gone(*board);
}

void OnboardCore::Inside::on_bytes(const wire::Input& input, wire::Effects& effects) {
  const auto board = boards.board_of(input.source);
  if (!board) return;
  for (const wire::BoardMessage& message : boards.on_bytes(*board, input.payload)) {
    supervision.board_heard(input.at, *board);
    std::visit([this](const auto& m) { on_board(m); }, message);
  }
  if (std::exchange(looked, false)) tell_seen(effects);
  tell_estimate(effects);
}

void OnboardCore::Inside::on_message(const wire::Input& input, wire::Effects& effects) {
  if (input.source == topics.heartbeat) {
    if (!input.flag) supervision.server_heard(input.at);
  } else if (input.source == session.ahead_topic()) {
    on_ahead(input, effects);
  } else if (input.source == session.order_topic()) {
    on_order(input, effects);
  } else if (input.source == session.instant_actions_topic()) {
    on_instant_actions(input, effects);
  } else if (input.source == topics.connection) {
    on_server_connection(input, effects);
  } else if (input.source == session.estimate_request_topic()) {
    on_estimate_request(input, effects);
  } else if (input.source == session.owner_topic()) {
    on_owner(input, effects);
  } else if (input.source.starts_with(topics.zone_prefix)) {
    on_zone(input, effects);
  }
}

void OnboardCore::Inside::on_board(const wire::Hello& hello) {
  if (hello.board != wire::Board::PILS) return;
  if (pils_session && *pils_session != hello.session && agent) agent->on_odometer_reset();
  pils_session = hello.session;
  find_place();
}

void OnboardCore::Inside::on_board(const wire::Odometry& odometry) {
  if (!agent) return;
  roll(odometry);
  if (!agent->position().pose_known()) find_place();
}

void OnboardCore::Inside::on_board(const wire::TagRead& tag) {
  if (!agent) return;
  const auto last = agent->position().last_tag();
  if (estimating.busy() && agent->position().pose_known())
    estimating.on_tag(tag.number, now - std::chrono::milliseconds{tag.age_ms}, *zone, agent->position().pose());
  const auto fix = agent->on_tag(tag);
  // A beacon every few centimetres is no event; a tag is (A13), and so is a belief that was wrong.
  if (agent->position().last_tag() != last || fix.kind == PositionEstimator::FixKind::relocated) state_due = true;
}

void OnboardCore::Inside::on_board(const wire::Ranges& reading) {
  ranges = reading;
  looked = true;
  if (agent) agent->on_ranges(reading);
}

void OnboardCore::Inside::on_board(const wire::Power& reading) {
  power = reading;
  if (agent) agent->on_charge(reading.charge());
}

void OnboardCore::Inside::on_tick(wire::Effects& effects) {
  if (beat.take(now)) boards.beat(uptime_ms(), effects);
  if (agent) {
    drive(effects);
    end_waits();
    end_switch(effects);
    if (!agent->take_traversed().empty()) state_due = true;
    if (agent->take_lost_order()) {
      refuse("orderError", "order", "the vehicle found itself off its order's way and dropped it",
             {{"orderId", agent->order().order_id()}}, effects);
    }
    const bool due = remember.take(now);
    remember_place(due, effects);
    was_standing = agent->standing();
    show(effects);
    if (visualize.take(now) && agent->position().pose_known())
      session.publish(now, compose_visualization(*agent, zone->name), effects);
    if (options.v2x) {
      listen_around(effects);
      tell_intent(effects);
    }
  }
  if (!waking() && report_boards.take(now)) session.publish(now, compose_boards_report(sources(), ranges), effects);
  const ReportFlags flags_now = flags_of(sources());
  if (flags_now != flags) state_due = true;
  flags = flags_now;
}

void OnboardCore::Inside::supervise() {
  const bool pils_lost = supervision.board_lost(now, wire::Board::PILS);
  if (pils_lost) agent->on_odometry_lost();
  const auto faulty = [&](wire::Board board) { return boards.health(board).self_test != 0; };
  agent->hold(Hold::broker_lost, supervision.broker_lost(now));
  agent->hold(Hold::server_lost, supervision.server_lost(now));
  agent->hold(Hold::board_lost, supervision.any_board_lost(now));
  // It could go on without power readings or tags, not without wheels or eyes.
  agent->hold(Hold::board_faulty, faulty(wire::Board::PILS) || faulty(wire::Board::DOBS));
}

void OnboardCore::Inside::show(wire::Effects& effects) {
  if (!display.take(now)) return;
  std::string text = display_text(options.id.serial_number, *agent);
  if (text == shown) return;
  boards.send(wire::Board::PRAV, wire::Display{text}, effects);
  shown = std::move(text);
}

bool OnboardCore::Inside::waking() const {
  return now - started < waking_max && (supervision.any_board_lost(now) || !power);
}

void OnboardCore::Inside::publish_state_if_due(wire::Effects& effects) {
  if (!session.online()) return;
  if (!state_sent && waking()) return;
  const SimDuration since = state_sent ? now - *state_sent : SimDuration::max();
  if (since < (state_due ? state_interval_min : options.state_period) && since >= SimDuration::zero()) return;
  session.publish(now, compose_state(sources()), effects);
  state_sent = now;
  state_due = false;
}

void OnboardCore::Inside::publish_factsheet(SimTime at, wire::Effects& effects) {
  if (!agent) return;
  session.publish(at, make_factsheet(*zone, {options.state_period, state_interval_min, options.visualization_period}),
                  effects);
}

ReportSources OnboardCore::Inside::sources() const {
  return {now, agent ? &*agent : nullptr, maps, zone_refused, boards, supervision, actions, warnings, power};
}

OnboardCore::OnboardCore(OnboardOptions options) : inside_{std::make_unique<Inside>(std::move(options))} {}
OnboardCore::~OnboardCore() = default;

void OnboardCore::handle(const wire::Input& input, wire::Effects& effects) {
  Inside& in = *inside_;
  in.now = input.at;
  switch (input.kind) {
    case wire::InputKind::configure:
      in.started = input.at;
      in.on_configure(effects);
      break;
    case wire::InputKind::recall: in.on_recall(input, effects); break;
    case wire::InputKind::link: in.on_link(input, effects); break;
    case wire::InputKind::port: in.on_port(input); break;
    case wire::InputKind::bytes: in.on_bytes(input, effects); break;
    case wire::InputKind::message:
      // What others say is no reason to report: it comes often, and changes nothing that a state says.
      if (input.source.starts_with(wire::v2x_topic_prefix)) return in.on_intent(input, effects);
      in.on_message(input, effects);
      break;
    case wire::InputKind::tick: in.on_tick(effects); break;
    case wire::InputKind::command: break;  // nobody commands a vehicle from its own machine
  }
  in.publish_state_if_due(effects);
}

std::vector<std::string> OnboardCore::subscriptions() const {
  // Whose it is comes first: of the zones that a broker keeps, the one of its hall is the one that its memory is of.
  return {inside_->session.owner_topic(),
          inside_->session.order_topic(),
          inside_->session.instant_actions_topic(),
          inside_->session.ahead_topic(),
          inside_->session.estimate_request_topic(),
          std::string(wire::server_heartbeat_topic),
          std::string(wire::server_connection_topic),
          wire::topics_below(wire::zone_topic_prefix, 1)};
}

std::optional<wire::Will> OnboardCore::will() const { return inside_->session.will(inside_->now); }

void OnboardCore::farewell(SimTime now, wire::Effects& effects) {
  Inside& in = *inside_;
  in.now = now;
  if (in.agent) {
    const auto braking = in.zone->profiles.medium.braking_mps2;
    in.boards.send(wire::Board::PILS, wire::Drive{0, 0, static_cast<std::uint16_t>(1000.0 * braking), 0}, effects);
    in.must_remember = true;
    in.remember_place(true, effects);
  }
  in.session.publish(now, wire::ConnectionState::offline, effects);
}

void OnboardCore::fold(Digest& digest) const {
  const Inside& in = *inside_;
  digest.add(std::string_view{in.options.id.serial_number});
  digest.add(std::uint64_t{in.agent.has_value()});
  if (!in.agent) return;
  const Agent& agent = *in.agent;
  digest.add(std::uint64_t{agent.position().known()});
  if (agent.position().known()) {
    digest.add(std::uint64_t{agent.position().place().section});
    digest.add(agent.position().place().s_m);
  }
  if (agent.position().off_line() && agent.position().pose_known()) {
    const Pose2 X_MB = agent.position().pose();
    digest.add(X_MB.x_m);
    digest.add(X_MB.y_m);
    digest.add(X_MB.heading_rad);
  }
  digest.add(agent.position().travelled_m());
  digest.add(agent.speed_mps());
  digest.add(std::uint64_t{agent.holds()});
  digest.add(std::string_view{agent.order().order_id()});
  digest.add(std::uint64_t{agent.order().order_update_id()});
  digest.add(std::uint64_t{agent.order().last_node_sequence_id()});
  digest.add(std::uint64_t{agent.braking_for_felt()});
  in.felt->fold(digest);
  in.sighting.fold(digest);
  in.neighbours->fold(digest);
}

SimDuration OnboardCore::tick_period() const { return inside_->options.cycle; }

std::string OnboardCore::kept_memory() const { return inside_->kept ? to_json(*inside_->kept) : std::string{}; }

const OnboardOptions& OnboardCore::options() const { return inside_->options; }

std::vector<std::string> OnboardCore::ports() const { return inside_->boards.ports(); }

std::optional<Pose2> OnboardCore::believed_pose() const {
  const auto& agent = inside_->agent;
  return agent && agent->position().pose_known() ? std::optional{agent->position().pose()} : std::nullopt;
}

double OnboardCore::believed_speed_mps() const { return inside_->agent ? inside_->agent->speed_mps() : 0.0; }

}  // namespace cosiva::aiv
