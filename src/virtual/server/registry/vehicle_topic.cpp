#include "cosiva/virtual/server/registry/vehicle_topic.h"

namespace cosiva::virtual_side {

std::optional<VehicleTopic> parse_vehicle_topic(std::string_view name) {
  if (name == "state") return VehicleTopic::state;
  if (name == "visualization") return VehicleTopic::visualization;
  if (name == "connection") return VehicleTopic::connection;
  if (name == "factsheet") return VehicleTopic::factsheet;
  return std::nullopt;
}

std::string_view to_string(VehicleTopic topic) {
  switch (topic) {
    case VehicleTopic::connection: return "connection";
    case VehicleTopic::state: return "state";
    case VehicleTopic::visualization: return "visualization";
    case VehicleTopic::factsheet: return "factsheet";
    case VehicleTopic::perceived: return "virtual_obstacles_ack";
    case VehicleTopic::detected: return "detected_obstacle";
    case VehicleTopic::boards: return "boards";
  }
  return "?";
}

}  // namespace cosiva::virtual_side
