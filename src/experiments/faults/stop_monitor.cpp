#include "cosiva/experiments/faults/stop_monitor.h"

#include <algorithm>

#include "cosiva/base/expect.h"
#include "cosiva/experiments/faults/fault.h"
#include "cosiva/wire/vda5050/codec.h"

namespace cosiva::experiments {
namespace {

constexpr double at_rest_mps = 1e-3;

}  // namespace

StopMonitor::StopMonitor(const World& world, std::uint32_t aivs) : world_{world}, vehicles_(aivs) {
  for (std::uint32_t i = 0; i < aivs; ++i) vehicles_[i].name = vehicle_id(static_cast<Process>(i + 1));
}

StopMonitor::Vehicle* StopMonitor::find(const std::string& name) {
  const auto vehicle = std::ranges::find(vehicles_, name, &Vehicle::name);
  return vehicle == vehicles_.end() ? nullptr : &*vehicle;
}

void StopMonitor::on_effect(Process aiv, const wire::Publish& message) {
  COSIVA_EXPECT(aiv >= 1 && aiv <= vehicles_.size());
  if (!message.topic.ends_with("/state")) return;
  Vehicle& vehicle = vehicles_[aiv - 1];
  vehicle.paused = message.payload.find(R"("paused":true)") != std::string::npos;
  if (!vehicle.paused) return;
  vehicle.confirmed = vehicle.confirmed || std::ranges::any_of(vehicle.stops, [&](const std::string& id) {
                        return message.payload.find('"' + id + '"') != std::string::npos;
                      });
}

Finding StopMonitor::on_server_message(const wire::Publish& message, const OperatorState& state) {
  if (!message.topic.ends_with("/instantActions")) return std::nullopt;
  const auto actions = wire::vda5050::decode_instant_actions(message.payload);
  if (!actions) return std::nullopt;
  const std::string name = actions->header.manufacturer + "/" + actions->header.serial_number;
  Vehicle* const vehicle = find(name);
  for (const wire::Action& action : actions->actions) {
    if (vehicle != nullptr && action.action_type == "startPause") vehicle->stops.push_back(action.action_id);
    if (action.action_type != "stopPause") continue;
    if (state.stopped(name)) return Violation{"I6", "stopPause leaves to " + name + ", for which a Stop holds"};
    if (vehicle != nullptr) lift(*vehicle);
  }
  return std::nullopt;
}

void StopMonitor::lift(Vehicle& vehicle) {
  vehicle.stops.clear();
  vehicle.confirmed = false;
  vehicle.distance_m_max.reset();
}

Finding StopMonitor::step(const OperatorState& state, const FaultInjection& faults) {
  const auto ground_truth = world_.plant().vehicles();
  for (std::size_t i = 0; i < vehicles_.size(); ++i) {
    Vehicle& vehicle = vehicles_[i];
    if (!state.stopped(vehicle.name)) {
      lift(vehicle);
      continue;
    }
    const bool confirmed = vehicle.confirmed || !faults.running(static_cast<Process>(i + 1));
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
