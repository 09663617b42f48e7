#include "cosiva/experiments/faults/stop_monitor.h"

#include "cosiva/base/expect.h"
#include "cosiva/experiments/faults/fault.h"

namespace cosiva::experiments {
namespace {

constexpr double at_rest_mps = 1e-3;

}  // namespace

StopMonitor::StopMonitor(const World& world, std::uint32_t aivs) : world_{world}, vehicles_(aivs) {
  for (std::uint32_t i = 0; i < aivs; ++i) vehicles_[i].name = vehicle_id(static_cast<Process>(i + 1));
}

void StopMonitor::on_effect(Process aiv, const wire::Publish& message) {
  COSIVA_EXPECT(aiv >= 1 && aiv <= vehicles_.size());
  if (message.topic.ends_with("/state"))
    vehicles_[aiv - 1].paused = message.payload.find(R"("paused":true)") != std::string::npos;
}

Finding StopMonitor::on_server_message(const wire::Publish& message, const OperatorState& state) {
  if (!message.topic.ends_with("/instantActions") || message.payload.find("stopPause") == std::string::npos)
    return std::nullopt;
  const std::size_t end = message.topic.rfind('/');
  const std::size_t serial = message.topic.rfind('/', end - 1);
  const std::size_t manufacturer = message.topic.rfind('/', serial - 1);
  const std::string name = message.topic.substr(manufacturer + 1, end - manufacturer - 1);
  if (!state.stopped(name)) return std::nullopt;
  return Violation{"I6", "stopPause leaves to " + name + ", for which a Stop holds"};
}

Finding StopMonitor::step(const OperatorState& state, const FaultInjection& faults) {
  if (!faults.running(plant_process)) {
    // A plant that starts puts the vehicles elsewhere, and counts their distances from there.
    for (Vehicle& vehicle : vehicles_) vehicle.distance_m_max.reset();
    return std::nullopt;
  }
  const auto ground_truth = world_.plant().vehicles();
  for (std::size_t i = 0; i < vehicles_.size(); ++i) {
    Vehicle& vehicle = vehicles_[i];
    if (!state.stopped(vehicle.name)) {
      vehicle.distance_m_max.reset();
      vehicle.paused = false;  // what was confirmed was another Stop
      continue;
    }
    const bool confirmed = vehicle.paused || !faults.running(static_cast<Process>(i + 1));
    if (!vehicle.distance_m_max && confirmed && ground_truth[i].speed_mps < at_rest_mps)
      vehicle.distance_m_max = ground_truth[i].distance_m + moves_m_max;
    if (vehicle.distance_m_max && ground_truth[i].distance_m > *vehicle.distance_m_max)
      return Violation{"I6", vehicle.name + " moves, although a Stop holds that it has confirmed"};
  }
  return std::nullopt;
}

Finding StopMonitor::at_rest(const OperatorState& state) const {
  const auto ground_truth = world_.plant().vehicles();
  for (std::size_t i = 0; i < vehicles_.size(); ++i) {
    if (state.stopped(vehicles_[i].name) && ground_truth[i].speed_mps > at_rest_mps)
      return Violation{"I6", vehicles_[i].name + " drives, although a Stop holds and no fault is left"};
    if (state.stopped(vehicles_[i].name) && !vehicles_[i].paused)
      return Violation{"I6", vehicles_[i].name + " does not report that it is stopped, although no fault is left"};
  }
  return std::nullopt;
}

}  // namespace cosiva::experiments
