#include "cosiva/aiv/onboard/estimation_service.h"

#include <optional>
#include <utility>

#include "cosiva/base/archive.h"
#include "cosiva/base/expect.h"

namespace cosiva::aiv {
namespace {

std::optional<Estimating::CurrentEstimate> estimate_of(const DrivingContext& context) {
  const PositionEstimator& position = context.vehicle().position();
  if (!position.pose_known()) return std::nullopt;
  Estimating::CurrentEstimate estimate{context.shared_zone(), position.pose(), std::nullopt,
                                       position.on_path_estimator().sigma_m()};
  if (position.known() && !position.off_path()) estimate.position = position.track_position();
  return estimate;
}

}  // namespace

void EstimationService::on_request(SimTime now, std::string_view payload, ServerProxy& server_proxy,
                                   wire::Effects& effects) {
  auto request = wire::estimate_request_from_json(payload);
  if (!request) {
    errors_.report("request", "a request for estimates that cannot be read: " + to_string(request.error()), effects);
    return;
  }
  estimating_.on_request(now, std::move(*request));
  publish(server_proxy, effects);
}

void EstimationService::on_odometry(SimTime now, const wire::Odometry& odometry, DrivingContext& context) {
  const SimTime at = pils_clock_.stamp(now, odometry.board_ms);
  COSIVA_EXPECT(at <= now);
  Agent& agent = context.agent();
  if (!estimating_.busy()) return agent.on_odometry(odometry);
  const PositionEstimator& position = agent.vehicle().position();
  const double travelled_m = position.travelled_m();
  const auto before = estimate_of(context);
  agent.on_odometry(odometry);
  Estimating::Step step{at, position.travelled_m() - travelled_m, 0.0, 1e-3 * odometry.speed_mmps,
                        estimate_of(context)};
  if (before && step.current_estimate) {
    // There is no gyroscope: on its path the vehicle turns as the path does, elsewhere as its wheels report.
    step.turn_rad = wrap_angle(step.current_estimate->X_MB.heading_rad - before->X_MB.heading_rad);
    if (position.off_path_estimator().manoeuvring())
      step.distance_m = (inverse(before->X_MB) * step.current_estimate->X_MB).x_m;
  }
  estimating_.on_odometry(now, step);
}

void EstimationService::on_tag(SimTime now, const wire::TagRead& tag, const DrivingContext& context) {
  const PositionEstimator& position = context.vehicle().position();
  if (!estimating_.busy() || !position.pose_known()) return;
  estimating_.on_tag(tag.number, now - std::chrono::milliseconds{tag.age_ms}, context.zone(), position.pose());
}

void EstimationService::publish(ServerProxy& server_proxy, wire::Effects& effects) {
  if (auto json = estimating_.take_response()) server_proxy.publish_estimate(std::move(*json), effects);
}

void EstimationService::archive(Archive& archive) { archive(estimating_, pils_clock_, errors_); }

}  // namespace cosiva::aiv
