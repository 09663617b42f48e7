#include "cosiva/zone/lif/lif_properties.h"

#include <algorithm>
#include <cmath>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "cosiva/base/math.h"
#include "cosiva/zone/lif/lif_trajectory.h"

namespace cosiva::zone::lif {
namespace {

constexpr auto mended = Diagnostic::Kind::mended;
constexpr auto lost = Diagnostic::Kind::lost;

constexpr double speed_max_mps = 100.0;
/// Of an orientation that is meant to be along the path: files have their angles rounded to two digits.
constexpr double along_rad = 0.01;

bool is_in_degrees(double angle_rad) { return std::fabs(angle_rad) > 2.0 * pi + 1e-6; }

/// The types of all actions; reports what vehicles do not do there, the required actions by name.
/// @param done  actions of these types are no loss
std::vector<std::string> read_actions(const LifFields& properties, const std::vector<std::string_view>& done,
                                      const std::string& why) {
  std::vector<std::string> types;
  std::string required;
  bool others = false;
  const auto count = properties.each("actions", [&](const LifFields& action) {
    types.push_back(action.text("actionType").value_or(""));
    const std::string& type = types.back();
    if (std::find(done.begin(), done.end(), type) != done.end()) return;
    if (action.text("requirementType") == "REQUIRED")
      required += (required.empty() ? "'" : ", '") + printable(type.substr(0, 40)) + "'";
    else
      others = true;
  });
  if (!required.empty())
    properties.record(lost, "actions", "orders do not contain the required action " + required + ": " + why);
  if (others || (count == 0 && done.empty())) properties.lose("actions", why);
  return types;
}

/// False: it is closed to all.
bool read_load_restriction(const LifFields& properties) {
  if (!properties.has("loadRestriction")) return true;
  const LifFields restriction = properties.object("loadRestriction");
  restriction.known({"unloaded", "loaded", "loadSetNames"});
  const auto loaded = restriction.flag("loaded");
  const auto unloaded = restriction.flag("unloaded");
  if (loaded == false && unloaded == false) {
    properties.record(lost, "loadRestriction", "neither loaded nor unloaded vehicles may be here; not taken");
    return false;
  }
  const bool names_sets = restriction.each("loadSetNames", [](const LifFields&) {}).value_or(0) > 0;
  if (loaded != true || unloaded != true)
    properties.lose("loadRestriction", "vehicles drive here with and without load");
  else if (names_sets)
    properties.lose("loadRestriction", "vehicles drive here with any load");
  return true;
}

/// A file of 1.0 has one orientation, which is 0 where it is absent; one of 2.0 has a list of those that are possible,
/// all where it is absent.
bool may_drive_forwards(const LifFields& properties, const EdgeRules& rules) {
  const std::string type = properties.text("orientationType").value_or("TANGENTIAL");
  const bool is_global = type == "GLOBAL" && !properties.has("trajectory");
  const bool is_known = is_global || type == "TANGENTIAL";
  const auto is_along = [&](double orientation_rad) {
    if (is_in_degrees(orientation_rad))
      properties.record(mended, properties.has("vehicleOrientations") ? "vehicleOrientations" : "vehicleOrientation",
                        "an angle beyond ±2π must be meant in degrees");
    const double off_rad = orientation_rad - (is_global ? rules.heading_rad : 0.0);
    return is_known && std::fabs(wrap_angle(off_rad)) <= along_rad;
  };
  if (!properties.has("vehicleOrientations")) {
    const auto orientation_rad = properties.number("vehicleOrientation");
    if (!orientation_rad && rules.is_version_2) return true;
    // Along the path a file of 1.0 has exactly 0.
    return is_along(orientation_rad.value_or(0.0)) && (is_global || orientation_rad.value_or(0.0) == 0.0);
  }
  bool forwards = false;
  const auto count = properties.each("vehicleOrientations", [&](const LifFields& item) {
    if (const auto orientation_rad = item.number()) forwards = is_along(*orientation_rad) || forwards;
  });
  return forwards || count.value_or(0) == 0;
}

Rotation read_rotation(const LifFields& fields, std::string_view key) {
  const auto word = fields.text(key);
  if (!word || *word == "BOTH") return Rotation::any;
  if (*word == "NONE") return Rotation::none;
  if (*word == "CW" || *word == "CCW") {
    fields.record(lost, key, "turning in one direction only is not supported: vehicles turn in the shorter direction");
    return Rotation::one_way;
  }
  fields.record(mended, key,
                "expected NONE, CW, CCW or BOTH, found '" + printable(word->substr(0, 40)) + "'; taken as BOTH");
  return Rotation::any;
}

void read_rotations(const LifFields& properties, const EdgeRules& rules, Edge& edge) {
  const bool is_version_2 =
      rules.is_version_2 || properties.has("vehicleOrientations") || properties.has("reachOrientationBeforeEntering");
  if (!properties.has("rotationAllowed")) {
    if (!is_version_2)
      properties.record(mended, "rotationAllowed",
                        "'rotationAllowed' is missing; vehicles do not turn on edges anyway");
  } else if (properties.flag("rotationAllowed").value_or(false)) {
    properties.record(lost, "rotationAllowed", "turning while driving is not supported: vehicles turn at nodes only");
  }
  edge.leaving = read_rotation(properties, "rotationAtStartNodeAllowed");
  edge.arriving = read_rotation(properties, "rotationAtEndNodeAllowed");
  properties.lose("maxRotationSpeed", "turns on the spot have one speed everywhere");
}

}  // namespace

bool read_node_properties(const LifFields& properties, Node& node) {
  properties.known(
      {"vehicleTypeId", "vehicleTypeIds", "theta", "maximumAllowedDeviation", "loadRestriction", "actions"});
  if (const auto theta = properties.number("theta"); theta && is_in_degrees(*theta))
    properties.record(mended, "theta", "an angle beyond ±2π must be meant in degrees");
  properties.lose("theta", "a stopped vehicle has the heading of its path");
  properties.lose("maximumAllowedDeviation", "orders allow the same deviation at all nodes");
  const auto types = read_actions(properties, {"startCharging", "stopCharging"},
                                  "vehicles do nothing at nodes but stop, turn and charge");
  node.charges = std::find(types.begin(), types.end(), "startCharging") != types.end();
  return read_load_restriction(properties);
}

bool read_edge_properties(const LifFields& properties, const EdgeRules& rules, Edge& edge) {
  properties.known({"vehicleTypeId",
                    "vehicleTypeIds",
                    "vehicleOrientation",
                    "vehicleOrientations",
                    "orientationType",
                    "reachOrientationBeforeEntering",
                    "rotationAllowed",
                    "rotationAtStartNodeAllowed",
                    "rotationAtEndNodeAllowed",
                    "maxSpeed",
                    "maxRotationSpeed",
                    "minHeight",
                    "maxHeight",
                    "minimumLoadHandlingDeviceHeight",
                    "maximumMobileRobotHeight",
                    "loadRestriction",
                    "actions",
                    "trajectory",
                    "physicalLineGuidedProperty",
                    "reentryAllowed",
                    "allowedDeviationXY",
                    "corridor"});
  if (!may_drive_forwards(properties, rules))
    properties.record(lost, properties.has("vehicleOrientations") ? "vehicleOrientations" : "vehicleOrientation",
                      "another orientation than along the path is not supported: vehicles drive forwards");
  read_rotations(properties, rules, edge);
  if (const auto speed = properties.number("maxSpeed")) {
    if (*speed > 0.0 && *speed <= speed_max_mps)
      edge.speed_mps_max = *speed;
    else
      properties.record(mended, "maxSpeed", "expected a positive speed of at most 100 m/s; taken as absent");
  }
  for (const std::string_view key :
       {"minHeight", "maxHeight", "minimumLoadHandlingDeviceHeight", "maximumMobileRobotHeight"})
    properties.lose(key, "a zone is flat");
  const bool is_open = read_load_restriction(properties);
  (void)read_actions(properties, {}, "vehicles do nothing on edges but drive");
  if (properties.has("reentryAllowed") && !properties.flag("reentryAllowed").value_or(true))
    properties.lose("reentryAllowed", "vehicles do not turn round on edges anyway");
  properties.lose("physicalLineGuidedProperty", "vehicles follow the path between the nodes");
  properties.lose("allowedDeviationXY", "orders allow the same deviation at all nodes");
  properties.lose("corridor", "vehicles keep to the path");
  const LifFields trajectory = properties.object("trajectory");
  if (trajectory.is_object()) edge.trajectory = read_trajectory(trajectory, rules.scale);
  return is_open;
}

}  // namespace cosiva::zone::lif
