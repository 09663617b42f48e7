// What the on-board program tells the algorithms that somebody qualifies (figures 16 and 17), and answers for them.
#include "aiv/onboard/inside.h"

namespace cosiva::aiv {

void OnboardCore::Inside::on_estimate_request(const wire::Input& input, wire::Effects& effects) {
  auto request = wire::estimate_request_from_json(input.payload);
  if (!request) {
    // Whoever asks wrongly does so often.
    if (!std::exchange(estimate_complained, true))
      log(effects, 'w', "a request for estimates that cannot be read: " + to_string(request.error()));
    return;
  }
  estimating.ask(input.at, std::move(*request));
  tell_estimate(effects);
}

std::optional<Estimating::Belief> OnboardCore::Inside::belief() const {
  const PositionEstimator& position = agent->position();
  if (!position.pose_known()) return std::nullopt;
  Estimating::Belief belief{zone, position.pose(), std::nullopt, position.sigma_m()};
  if (position.known() && !position.off_line()) belief.place = position.place();
  return belief;
}

void OnboardCore::Inside::roll(const wire::Odometry& odometry) {
  const SimTime at = pils_clock.stamp(now, odometry.board_ms);
  if (!estimating.busy()) return agent->on_odometry(odometry);
  const PositionEstimator& position = agent->position();
  const double travelled_m = position.travelled_m();
  const auto before = belief();
  agent->on_odometry(odometry);
  Estimating::Step step{at, position.travelled_m() - travelled_m, 0.0, 1e-3 * odometry.speed_mmps, belief()};
  if (before && step.belief) {
    // There is no gyroscope: it turns as its line does, where it believes to be on it, and as its wheels say off it.
    step.turn_rad = wrap_angle(step.belief->X_MB.heading_rad - before->X_MB.heading_rad);
    if (position.manoeuvring()) step.distance_m = (inverse(before->X_MB) * step.belief->X_MB).x_m;
  }
  estimating.on_odometry(now, step);
}

void OnboardCore::Inside::tell_estimate(wire::Effects& effects) {
  if (auto json = estimating.take_answer()) session.publish_estimate(std::move(*json), effects);
}

}  // namespace cosiva::aiv
