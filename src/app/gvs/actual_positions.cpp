#include "cosiva/app/gvs/actual_positions.h"

#include <utility>

#include "cosiva/base/expect.h"

namespace cosiva::app {

void ActualPositions::on_request(SimTime now, const wire::VehicleId& vehicle, std::string_view payload) {
  auto request = wire::actual_position_request_from_json(payload);
  if (!request) return;
  std::string name = to_string(vehicle);
  if (requested_.size() >= vehicles_max && !requested_.contains(name)) return;
  requested_.insert_or_assign(std::move(name), Requested{vehicle, std::move(*request), now});
  COSIVA_EXPECT(requested_.size() <= vehicles_max);
}

std::vector<wire::Publish> ActualPositions::on_detections(const wire::GvsDetections& detections) {
  std::vector<wire::Publish> responses;
  for (const auto& detection : detections.detections) {
    const auto found = requested_.find(detection.vehicle);
    // The vehicle may still have moved before the request.
    if (found == requested_.end() || detection.at < found->second.at) continue;
    const auto& [vehicle, request, at] = found->second;
    const wire::ActualPosition position{request.session, request.sequence, detection.at, detection.pose,
                                        detection.uncertainty_m};
    responses.push_back(
        {wire::own_topic(wire::gvs_position_response_topic_prefix, vehicle), to_json(position), 0, false});
    requested_.erase(found);
  }
  return responses;
}

}  // namespace cosiva::app
