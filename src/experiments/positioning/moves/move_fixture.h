#pragma once

#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "cosiva/aiv/estimation/next_position.h"
#include "cosiva/aiv/estimation/registry.h"
#include "cosiva/experiments/positioning/metrology/simulate.h"
#include "cosiva/experiments/positioning/moves/move_loop.h"
#include "cosiva/wire/vda5050/codec.h"
#include "cosiva/zone/rtm/rtm.h"
#include "cosiva/zone/testing/test_zones.h"

/// The AIV and the GVS of figures 16 and 17 for a MoveLoop: a vehicle of a simulation whose noise is known, which
/// drives each move exactly, and whose algorithms are those of the registry.
namespace cosiva::experiments::testing {

inline std::shared_ptr<const zone::TrafficZone> lacet4() {
  static const auto zone = zone::Rtm::initialise(zone::testing::configuration_file("lacet4.toml"))->shared_zone();
  return zone;
}

class MoveFixture {
 public:
  static constexpr double step_m = 0.1;

  explicit MoveFixture(std::vector<std::string> algorithms, double distance_m = 2.0, std::uint64_t seed = 1,
                       double noise = 1.0)
      : simulation{simulation_of(distance_m + 1.0, noise)} {
    simulate(simulation, seed, trial);
    const estimation::Registry registry;
    for (const std::string& name : algorithms) algorithms_.push_back(*registry.make(name, trial.setting));
    options = {{"CoSiVA", "AIV1"}, "q/1", std::move(algorithms), distance_m, step_m, seed, 500, 4};
  }

  /// Runs the loop to its end; false: it did not end within an hour.
  bool run(MoveLoop& loop) {
    for (SimTime now = virtual_epoch; now < virtual_epoch + std::chrono::hours{1};
         now += std::chrono::milliseconds{5}) {
      auto sent = loop.tick(now);
      for (Call& call : sent.calls) calls.push_back(std::move(call));
      if (loop.phase() == MoveLoop::Phase::done || loop.phase() == MoveLoop::Phase::failed) return true;
      for (const wire::Publish& message : sent.messages)
        if (!lost || !lost(message.topic)) receive(now, message, loop);
    }
    return false;
  }

  Simulation simulation;
  Trial trial;
  MoveLoopOptions options;
  std::vector<Call> calls;
  std::function<bool(const std::string& topic)> lost;  ///< messages to drop
  std::function<void(wire::EstimateResponse&)> plant;  ///< an error in the vehicle's responses
  std::size_t moved{0};                                ///< moves driven, the first of which only stops the vehicle

 private:
  static Simulation simulation_of(double distance_m, double noise) {
    auto track = estimation::Track::round(lacet4());
    Simulation simulation;
    simulation.track = std::make_shared<const estimation::Track>(std::move(*track));
    simulation.distance_m = distance_m;
    simulation.speed_mps = 0.5;
    simulation.odometry_hz = simulation.speed_mps / step_m;  // an odometry per move
    simulation.pitch_m = 0.537;                              // positions between two beacons are equally likely
    simulation.turns = false;
    simulation.sensors.line_sigma_m = 0.0;
    simulation.sensors.distance_variance_per_m = noise * 1e-4;
    simulation.sensors.fiducial_along_sigma_m = simulation.sensors.fiducial_across_sigma_m =
        std::fmax(noise, 1e-9) * 0.01;
    simulation.start_sigma_m = std::fmax(noise, 1e-9) * 0.01;
    return simulation;
  }

  void receive(SimTime now, const wire::Publish& message, MoveLoop& loop) {
    if (message.topic.starts_with(wire::estimate_request_topic_prefix)) {
      respond(now, *wire::estimate_request_from_json(message.payload), loop);
    } else if (message.topic.ends_with("/instantActions")) {
      const auto actions = wire::vda5050::decode_instant_actions(message.payload);
      const wire::Action& action = actions->actions.front();
      if (action.action_id != last_action_) ++moved;
      last_action_ = action.action_id;
      wire::State state;
      state.header = actions->header;
      state.action_states.push_back({action.action_id, "move", wire::ActionStatus::finished, ""});
      reply(now, wire::vda_topic(options.vehicle, "state"), wire::vda5050::encode(state), loop);
    } else {
      const auto request = wire::actual_position_request_from_json(message.payload);
      // The first move is not recorded; the run begins where it ends.
      const Pose2 X_MB = trial.moments[moved - 2].ground_truth;
      std::string topic = message.topic;
      topic.replace(topic.find("request"), 7, "response");
      reply(now, topic, to_json(wire::ActualPosition{request->session, request->sequence, now, X_MB, 0.0}), loop);
    }
  }

  void respond(SimTime now, const wire::EstimateRequest& request, MoveLoop& loop) {
    const std::size_t until = moved < 2 ? 0 : trial.moments[moved - 2].events;
    for (; taken_ < until; ++taken_) {
      for (const auto& algorithm : algorithms_) {
        if (const auto* odometry = std::get_if<estimation::Odometry>(&trial.events[taken_]))
          algorithm->predict(*odometry);
        else
          algorithm->rectify(std::get<estimation::Reading>(trial.events[taken_]));
      }
    }
    wire::EstimateResponse response{request.session, request.sequence, now, "lacet4", "", 0.0, {}, {}, {}};
    response.travelled_m = static_cast<double>(moved - 1) * step_m + 1e-9;
    const double along_m = static_cast<double>(moved - 1) * step_m;
    if (request.sequence == 1) {
      const auto at = simulation.track->position_at(0.0);
      wire::EstimateResponse::Start start;
      start.section = lacet4()->circuit.part(at.section).name;
      response.start = start;
    }
    for (std::size_t i = 0; i < algorithms_.size(); ++i) {
      auto& estimate = response.estimates.emplace_back();
      estimate.algorithm = request.algorithms[i];
      estimate.next = next_position(algorithms_[i]->estimate(), simulation.track.get(), along_m, request.move_m);
    }
    if (plant) plant(response);
    reply(now, wire::own_topic(wire::estimate_response_topic_prefix, options.vehicle), to_json(response), loop);
  }

  void reply(SimTime now, const std::string& topic, const std::string& payload, MoveLoop& loop) const {
    if (!lost || !lost(topic)) loop.on_message(now, topic, payload);
  }

  std::vector<std::unique_ptr<estimation::Algorithm>> algorithms_;
  std::size_t taken_{0};
  std::string last_action_;
};

/// Root of the mean of the squared distances between the estimates and the actual positions.
inline double rmse_m(const std::vector<MoveStep>& steps, std::size_t algorithm) {
  double sum = 0.0;
  for (const MoveStep& step : steps) {
    const double error_m = distance(step.estimated[algorithm], step.actual);
    sum += error_m * error_m;
  }
  return std::sqrt(sum / static_cast<double>(steps.size()));
}

}  // namespace cosiva::experiments::testing
