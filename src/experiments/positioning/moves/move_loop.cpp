#include "cosiva/experiments/positioning/moves/move_loop.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <limits>
#include <utility>

#include "cosiva/base/expect.h"
#include "cosiva/wire/vda5050/codec.h"

namespace cosiva::experiments {
namespace {

using std::chrono::milliseconds;

/// A vehicle that drove before the run gets its restart from the server first.
constexpr SimDuration start_after = milliseconds{500};
/// A message was lost: a vehicle responds with its next odometry and its next state, a GVS with its next image.
constexpr SimDuration estimate_repeat_after = milliseconds{250};
constexpr SimDuration move_repeat_after = milliseconds{1000};
/// A vehicle that reports the move as running has it; only a restarted program needs it again.
constexpr SimDuration move_known_for = milliseconds{4000};
constexpr SimDuration position_repeat_after = milliseconds{1000};
constexpr const char* simulator = "Simulator";

std::string text_of(double value, const char* unit = "") {
  std::array<char, 32> text{};
  std::snprintf(text.data(), text.size(), "%.3f%s", value, unit);
  return text.data();
}

std::string text_of(const Pose2& pose) {
  return "(" + text_of(pose.x_m) + ", " + text_of(pose.y_m) + ", " + text_of(pose.heading_rad) + ")";
}

}  // namespace

MoveLoop::MoveLoop(MoveLoopOptions options, const GroundTruthSource& source)
    : options_{std::move(options)}, source_{source} {
  COSIVA_EXPECT(!options_.algorithms.empty() && options_.step_m > 0.0 &&
                source.kind() != GroundTruthSource::Kind::named);
}

std::string MoveLoop::source_name() const { return source_.kind() == GroundTruthSource::Kind::gvs ? "GVS" : "plant"; }

void MoveLoop::enter(SimTime now, Phase phase) {
  phase_ = phase;
  progressed_ = now;
  sent_.reset();
  COSIVA_EXPECT(phase != Phase::moving || estimated_.size() == options_.algorithms.size());
}

void MoveLoop::fail_run(std::string why) {
  phase_ = Phase::failed;
  fault_ = std::move(why);
}

void MoveLoop::send(SimTime now, std::string to, std::string text, wire::Publish message) {
  outgoing_.calls.push_back({now, simulator, std::move(to), std::move(text)});
  outgoing_.messages.push_back(std::move(message));
}

void MoveLoop::receive(SimTime now, std::string from, std::string text) {
  outgoing_.calls.push_back({now, std::move(from), simulator, std::move(text)});
}

void MoveLoop::request_estimate(SimTime now) {
  std::string names;
  for (const std::string& name : options_.algorithms) names += (names.empty() ? "" : ", ") + name;
  const wire::EstimateRequest request{options_.session,   sequence_,        options_.algorithms, options_.seed,
                                      options_.particles, options_.horizon, options_.step_m};
  send(now, to_string(options_.vehicle), "nextEstimatedPosition(" + names + ")",
       {wire::own_topic(wire::estimate_request_topic_prefix, options_.vehicle), to_json(request), 0, false});
}

void MoveLoop::command_move(SimTime now) {
  wire::InstantActions message;
  message.header = {moves_, now, std::string(wire::vda5050::version), options_.vehicle.manufacturer,
                    options_.vehicle.serial_number};
  message.actions.push_back({"move",
                             options_.session + "/" + std::to_string(moves_),
                             "",
                             wire::BlockingType::none,
                             {{"distance", options_.step_m}}});
  send(now, to_string(options_.vehicle), "move(" + text_of(options_.step_m, " m") + ")",
       {wire::vda_topic(options_.vehicle, "instantActions"), wire::vda5050::encode(message), 0, false});
}

void MoveLoop::request_position(SimTime now) {
  send(now, source_name(), "actualAIVposition(" + to_string(options_.vehicle) + ")",
       {wire::own_topic(source_.request_prefix(), options_.vehicle),
        to_json(wire::ActualPositionRequest{options_.session, sequence_}), 0, false});
}

MoveLoop::Sent MoveLoop::tick(SimTime now) {
  const auto due = [&](SimDuration repeat_after) {
    if (sent_ && now - *sent_ < repeat_after) return false;
    repeated_ += sent_ ? 1U : 0U;
    sent_ = now;
    return true;
  };
  switch (phase_) {
    case Phase::starting:
      if (progressed_ == SimTime{}) progressed_ = now;
      if (now - progressed_ < start_after) break;
      ++moves_;
      enter(now, Phase::stopping);
      break;
    case Phase::stopping:
    case Phase::moving:
      if (due(move_repeat_after)) command_move(now);
      break;
    case Phase::estimating:
      if (due(estimate_repeat_after)) request_estimate(now);
      break;
    case Phase::locating:
      if (due(position_repeat_after)) request_position(now);
      break;
    case Phase::done:
    case Phase::failed: break;
  }
  return std::exchange(outgoing_, {});
}

void MoveLoop::on_message(SimTime now, std::string_view topic, std::string_view payload) {
  if (const auto of = wire::parse_own_topic(wire::estimate_response_topic_prefix, topic)) {
    if (*of != options_.vehicle || phase_ != Phase::estimating) return;
    const auto response = wire::estimate_response_from_json(payload);
    if (response && response->session == options_.session && response->sequence == sequence_)
      on_estimate(now, *response);
  } else if (const auto located = wire::parse_own_topic(source_.response_prefix(), topic)) {
    if (*located != options_.vehicle || phase_ != Phase::locating) return;
    const auto position = wire::actual_position_from_json(payload);
    if (position && position->session == options_.session && position->sequence == sequence_)
      on_position(now, *position);
  } else if (const auto vda = wire::parse_vda_topic(topic); vda && vda->name == "state") {
    if (vda->vehicle != options_.vehicle || (phase_ != Phase::moving && phase_ != Phase::stopping)) return;
    if (const auto state = wire::vda5050::decode_state(payload)) on_state(now, *state);
  }
}

void MoveLoop::on_estimate(SimTime now, const wire::EstimateResponse& response) {
  if (!response.fault.empty()) return fail_run(response.fault);
  if (response.start) start_ = response.start;
  map_id_ = response.map_id;
  odometer_.travelled_m = response.travelled_m;
  for (const auto& input : response.inputs) {
    if (const auto* odometry = std::get_if<wire::EstimateResponse::Odometry>(&input))
      odometer_.since_fiducial_m += std::fabs(odometry->distance_m);
    else
      odometer_.since_fiducial_m = 0.0;
  }
  if (!steps_.empty()) {
    steps_.back().travelled_m = odometer_.travelled_m;
    steps_.back().since_fiducial_m = odometer_.since_fiducial_m;
  }
  estimated_.clear();
  for (std::size_t i = 0; i < options_.algorithms.size(); ++i) {
    if (i >= response.estimates.size() || response.estimates[i].algorithm != options_.algorithms[i])
      return fail_run("the vehicle sent no estimate of " + options_.algorithms[i]);
    const auto& estimate = response.estimates[i];
    if (!estimate.fault.empty()) return fail_run(estimate.algorithm + ": " + estimate.fault);
    if (!estimate.next)
      return fail_run("the vehicle sent no next position of " + estimate.algorithm + ": it may be of another version");
    estimated_.push_back(*estimate.next);
    receive(now, to_string(options_.vehicle),
            "PE" + (options_.algorithms.size() > 1 ? std::to_string(i + 1) : std::string{}) + " = " +
                text_of(*estimate.next));
  }
  if (odometer_.travelled_m >= options_.distance_m && !steps_.empty()) return enter(now, Phase::done);
  ++moves_;
  enter(now, Phase::moving);
}

void MoveLoop::on_state(SimTime now, const wire::State& state) {
  const std::string id = options_.session + "/" + std::to_string(moves_);
  const auto action = std::ranges::find(state.action_states, id, &wire::ActionState::action_id);
  if (action == state.action_states.end()) return;
  if (action->status == wire::ActionStatus::failed) {
    // Before the first iteration a restart of the server's may end the move; the vehicle is stopped again.
    if (phase_ != Phase::stopping) return fail_run("the move failed: " + action->result_description);
    ++moves_;
    return enter(now, Phase::stopping);
  }
  if (action->status != wire::ActionStatus::finished) {
    sent_ = now + move_known_for;
    return;
  }
  if (phase_ == Phase::stopping) {
    ++sequence_;
    return enter(now, Phase::estimating);
  }
  receive(now, to_string(options_.vehicle), "moved");
  enter(now, Phase::locating);
}

void MoveLoop::on_position(SimTime now, const wire::ActualPosition& position) {
  receive(now, source_name(), "PA = " + text_of(position.X_MB));
  steps_.push_back({position.at, position.X_MB, std::exchange(estimated_, {}), 0.0, 0.0});
  ++sequence_;
  enter(now, Phase::estimating);
}

Result<LiveRun> MoveLoop::finish(const std::shared_ptr<const zone::TrafficZone>& zone) const {
  if (steps_.empty() || !start_)
    return fail("moves.steps", "the vehicle made no move of the run", to_string(options_.vehicle));
  LiveRun run;
  run.vehicle = options_.vehicle;
  run.trial.name = options_.session + ", " + to_string(options_.vehicle);
  estimation::Setting& setting = run.trial.setting;
  setting.seed = options_.seed;
  setting.start = start_->X_MB;
  // There is no limit of these estimates: their vehicle had not moved yet.
  setting.start_known = false;
  if (start_->section) {
    const auto section = zone->circuit.find(*start_->section);
    if (!section) return fail("live.zone", "there is no section '" + *start_->section + "'", zone->name);
    auto track = estimation::Track::round(zone, *section);
    if (!track) return tl::unexpected(track.error());
    setting.track = std::make_shared<const estimation::Track>(std::move(*track));
  }
  for (const std::string& name : options_.algorithms) run.published.push_back({name, {}, {}, {}});
  double before_m = 0.0;
  for (const MoveStep& step : steps_) {
    run.trial.events.emplace_back(estimation::Odometry{step.travelled_m - before_m, 0.0, 1.0});
    before_m = step.travelled_m;
    Moment moment{run.trial.events.size(),
                  to_seconds(step.at - steps_.front().at),
                  step.actual,
                  step.travelled_m,
                  step.since_fiducial_m,
                  std::nullopt};
    moment.section =
        zone->circuit.section(zone->circuit.locate(position(step.actual), step.actual.heading_rad).position.section)
            .kind();
    run.trial.moments.push_back(moment);
    for (std::size_t i = 0; i < step.estimated.size(); ++i) {
      estimation::Estimate& estimate = run.published[i].estimates.emplace_back();
      estimate.pose = step.estimated[i];
      estimate.covariance.setConstant(std::numeric_limits<double>::quiet_NaN());
    }
  }
  return run;
}

}  // namespace cosiva::experiments
