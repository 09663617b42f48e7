#include "cosiva/virtual/server/core/zone_change.h"

#include <optional>
#include <utility>

#include "cosiva/base/archive.h"
#include "cosiva/base/expect.h"
#include "cosiva/zone/circuit/path_snap.h"

namespace cosiva::virtual_side {
namespace {

/// The server does not wait any longer for a CoSiVA vehicle that has not reported the new map this long after a change.
constexpr SimDuration change_timeout{std::chrono::seconds{10}};
constexpr double moving_mps = 0.01;

}  // namespace

void ZoneChange::begin(std::string from) {
  last_ = Change{};
  last_->at = context_.now;
  last_->from = std::move(from);
}

bool ZoneChange::is_changing(VehicleIndex vehicle) const {
  const AivProxy& proxy = context_.registry[vehicle];
  return last_ && context_.now - last_->at < change_timeout && !proxy.position.map_id().empty() &&
         proxy.position.map_id() != map_->zone().name;
}

bool ZoneChange::all_stopped_off_old_map() const {
  for (VehicleIndex v = 0; v < context_.registry.size(); ++v) {
    const AivProxy& proxy = context_.registry[v];
    if (!proxy.here() || !proxy.online() || proxy.lost(context_.now, context_.options.lost_after) || !is_changing(v))
      continue;
    // A report from before the change does not show what the vehicle does now.
    const bool moves = proxy.reports.last() <= last_->at || (proxy.state() && proxy.state()->driving) ||
                       context_.simulator.twin(*proxy.twin()).speed_mps() > moving_mps;
    if (proxy.is_cosiva() && moves) return false;
  }
  return true;
}

bool ZoneChange::no_vehicle_changes_map() const {
  for (VehicleIndex v = 0; v < context_.registry.size(); ++v) {
    const AivProxy& proxy = context_.registry[v];
    if (!proxy.here() || !proxy.online() || proxy.lost(context_.now, context_.options.lost_after)) continue;
    const bool coasts = context_.simulator.twin(*proxy.twin()).speed_mps() > moving_mps && !master_.orders.has_order(v);
    if (is_changing(v) || proxy.reports.last() <= last_->at || coasts) return false;
  }
  return true;
}

std::string ZoneChange::off_route(VehicleIndex vehicle) const {
  const AivProxy& proxy = context_.registry[vehicle];
  if (!map_ || !proxy.here() || is_changing(vehicle)) return {};
  const std::string& name = map_->zone().name;
  if (!proxy.position.map_id().empty() && proxy.position.map_id() != name)
    return "is on map '" + proxy.position.map_id().substr(0, 80) + "', not on '" + name +
           "'; it gets no orders until it is";
  const Twin& twin = context_.simulator.twin(*proxy.twin());
  if (twin.reported_off_m() <= zone::snap_within_m) return {};
  return "is " + metres_text(twin.reported_off_m()) + " m from the nearest section of '" + name +
         "'; move it to within " + metres_text(zone::snap_within_m) + " m of one";
}

void ZoneChange::follow() {
  if (!map_) return;
  deploy_map();
  if (!last_) return;
  last_->sent_off = last_->sent_off || all_stopped_off_old_map();
  const bool over = no_vehicle_changes_map() || context_.now - last_->at >= change_timeout;
  if (last_->sent_off && !last_->counted && over) count_vehicles();
  if (last_->sent_off && !last_->first_moving) find_first_moving();
}

void ZoneChange::deploy_map() {
  // The version is a digest of the whole file, and almost never wanted.
  std::optional<MapDeployment::Map> wanted;
  for (VehicleIndex v = 0; v < context_.registry.size(); ++v) {
    const AivProxy& proxy = context_.registry[v];
    if (!context_.options.drive || proxy.is_cosiva() || !proxy.here() || proxy.position.map_id().empty() ||
        proxy.position.map_id() == map_->zone().name)
      continue;
    if (!wanted)
      wanted = {map_->zone().name, zone::version_of(*context_.simulator.configuration()),
                context_.options.map_download_link};
    master_.maps.step(v, *wanted);
  }
}

void ZoneChange::count_vehicles() {
  COSIVA_EXPECT(last_->sent_off && !last_->counted);
  last_->counted = true;
  for (VehicleIndex v = 0; v < context_.registry.size(); ++v) {
    const AivProxy& proxy = context_.registry[v];
    if (!proxy.here()) continue;
    const std::string why = off_route(v);
    if (why.empty()) {
      ++last_->snapped;
      continue;
    }
    last_->off_route.push_back(proxy.name());
    context_.publisher.log('w', proxy.name() + ": off-route: it " + why);
  }
}

void ZoneChange::find_first_moving() {
  COSIVA_EXPECT(last_->sent_off && !last_->first_moving);
  for (VehicleIndex v = 0; v < context_.registry.size(); ++v) {
    const AivProxy& proxy = context_.registry[v];
    if (!proxy.here() || !master_.orders.has_order(v)) continue;
    // Turning towards the new path counts: VDA 5050's driving is "driving or rotating".
    const bool drives = proxy.state() && proxy.state()->driving && proxy.position.map_id() == map_->zone().name;
    if (!drives && context_.simulator.twin(*proxy.twin()).speed_mps() <= moving_mps) continue;
    last_->first_moving = context_.now;
    context_.publisher.log(
        'i', "zone '" + map_->zone().name + "': " + proxy.name() + " moves on it, " +
                 std::to_string(static_cast<std::int64_t>(to_milliseconds_scaled(context_.now - last_->at))) +
                 " ms after the switch");
    return;
  }
}

void ZoneChange::write(JsonWriter& json) const {
  if (!last_) {
    json.null();
    return;
  }
  json.begin_object().field("at", to_milliseconds_scaled(last_->at)).field("from", last_->from).key("first_moving_ms");
  if (last_->first_moving)
    json.value(to_milliseconds_scaled(*last_->first_moving - last_->at));
  else
    json.null();
  json.field("snapped", static_cast<std::uint64_t>(last_->snapped)).key("offRoute").begin_array();
  for (const std::string& name : last_->off_route) json.value(name);
  json.end_array().end_object();
}

void ZoneChange::archive(Archive& archive) { archive(last_); }

}  // namespace cosiva::virtual_side
