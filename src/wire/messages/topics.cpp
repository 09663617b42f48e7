#include "cosiva/wire/messages/topics.h"

#include <algorithm>
#include <array>

namespace cosiva::wire {

std::string to_string(const VehicleId& id) { return id.manufacturer + "/" + id.serial_number; }

std::string to_string(const VdaTopic& topic) {
  return topic.interface_name + "/" + topic.major_version + "/" + topic.vehicle.manufacturer + "/" +
         topic.vehicle.serial_number + "/" + topic.name;
}

std::optional<VdaTopic> parse_vda_topic(std::string_view topic) {
  std::array<std::string_view, 5> levels;
  for (std::size_t i = 0; i < levels.size(); ++i) {
    const std::size_t slash = topic.find('/');
    if ((slash == std::string_view::npos) != (i + 1 == levels.size())) return std::nullopt;
    levels[i] = topic.substr(0, slash);
    if (levels[i].empty()) return std::nullopt;
    if (slash != std::string_view::npos) topic.remove_prefix(slash + 1);
  }
  return VdaTopic{std::string(levels[0]),
                  std::string(levels[1]),
                  {std::string(levels[2]), std::string(levels[3])},
                  std::string(levels[4])};
}

std::string vda_topic(const VehicleId& vehicle, std::string_view name, std::string_view interface_name) {
  return to_string(VdaTopic{std::string(interface_name), "v2", vehicle, std::string(name)});
}

bool valid_serial_number(std::string_view serial) {
  return !serial.empty() && serial.size() <= 64 && std::ranges::all_of(serial, [](char c) {
    return (c >= 'A' && c <= 'Z') || (c >= 'a' && c <= 'z') || (c >= '0' && c <= '9') || c == '_' || c == '.' ||
           c == ':' || c == '-';
  });
}

std::string topics_below(std::string_view prefix, int levels) {
  std::string filter{prefix};
  for (int i = 0; i < levels; ++i) filter.append(i == 0 ? "+" : "/+");
  return filter;
}

std::string own_topic(std::string_view prefix, const VehicleId& vehicle) {
  std::string topic{prefix};
  topic += vehicle.manufacturer;
  topic += '/';
  topic += vehicle.serial_number;
  return topic;
}

std::optional<VehicleId> parse_own_topic(std::string_view prefix, std::string_view topic) {
  if (!topic.starts_with(prefix)) return std::nullopt;
  topic.remove_prefix(prefix.size());
  const std::size_t slash = topic.find('/');
  if (slash == std::string_view::npos || slash == 0 || slash + 1 == topic.size()) return std::nullopt;
  const std::string_view serial = topic.substr(slash + 1);
  if (serial.find('/') != std::string_view::npos) return std::nullopt;
  return VehicleId{std::string(topic.substr(0, slash)), std::string(serial)};
}

}  // namespace cosiva::wire
