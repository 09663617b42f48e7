#include "cosiva/virtual/server/zones/map_deployment.h"

#include <algorithm>
#include <utility>

#include "cosiva/base/archive.h"
#include "cosiva/base/expect.h"

namespace cosiva::virtual_side {

void MapDeployment::begin() {
  for (Step& step : steps_) {
    if (step.handle != 0) action_sender_.drop(step.handle);
    step = {};
  }
}

std::optional<wire::Action> MapDeployment::next_action(VehicleIndex vehicle, const Map& map) const {
  const AivProxy& proxy = registry_[vehicle];
  const auto can = [&](std::string_view action) { return proxy.supports(action) == std::optional{true}; };
  const auto& maps = proxy.state()->maps;
  const auto known = std::ranges::find_if(maps, [&](const wire::MapInfo& one) { return one.map_id == map.id; });
  const auto action = [](std::string type, std::vector<wire::Parameter> parameters) {
    return wire::Action{std::move(type), {}, {}, wire::BlockingType::none, std::move(parameters)};
  };
  if (known == maps.end() && can("downloadMap") && !map.link.empty())
    return action("downloadMap", {{"mapId", map.id}, {"mapVersion", map.version}, {"mapDownloadLink", map.link}});
  if (known != maps.end() && !known->enabled && can("enableMap"))
    return action("enableMap", {{"mapId", map.id}, {"mapVersion", known->map_version}});
  // A vehicle that reports no maps may still know this one; a vehicle that lists maps without this one does not.
  if ((known != maps.end() || maps.empty()) && can("initPosition") && proxy.position.pose()) {
    return action("initPosition", {{"x", proxy.position.pose()->x_m},
                                   {"y", proxy.position.pose()->y_m},
                                   {"theta", proxy.position.pose()->heading_rad},
                                   {"mapId", map.id},
                                   {"lastNodeId", std::string{}}});
  }
  return std::nullopt;
}

bool MapDeployment::in_progress(Step& step) const {
  if (step.handle == 0) return false;
  const InstantActionSender::PendingAction* pending_action = action_sender_.find(step.handle);
  const bool done =
      pending_action == nullptr ||
      std::ranges::all_of(pending_action->actions, [](const InstantActionSender::Progress& action) {
        return action.status == wire::ActionStatus::finished || action.status == wire::ActionStatus::failed;
      });
  if (!done && publisher_.now() - step.sent_at < timeout) return true;
  const bool finished =
      pending_action != nullptr && pending_action->actions.front().status == wire::ActionStatus::finished;
  // The next state may have been sent before the action; and a failed action is not requested continuously.
  step.not_before = publisher_.now() + (finished ? SimDuration{std::chrono::seconds{1}} : again_after);
  action_sender_.drop(std::exchange(step.handle, 0));
  return false;
}

void MapDeployment::step(VehicleIndex vehicle, const Map& map) {
  AivProxy& proxy = registry_[vehicle];
  Step& step = steps_[vehicle];
  if (!proxy.state() || !proxy.online() || in_progress(step) || publisher_.now() < step.not_before) return;
  // A vehicle that still drives an order of the old map finishes that order first.
  if (!proxy.state()->node_states.empty() || proxy.state()->driving) return;
  auto action = next_action(vehicle, map);
  if (!action) return;
  publisher_.log('i', proxy.name() + ": is on map '" + proxy.position.map_id() + "'; requested " + action->action_type +
                          " of '" + map.id + "'");
  COSIVA_EXPECT(step.handle == 0);
  step.sent_at = publisher_.now();
  step.handle = action_sender_.send(proxy, vehicle, {std::move(*action)}, timeout, true);
}

void MapDeployment::archive(Archive& archive) { archive(steps_); }

}  // namespace cosiva::virtual_side
