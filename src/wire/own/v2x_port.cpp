#include "cosiva/wire/own/v2x_port.h"

#include <algorithm>

namespace cosiva::wire {

std::optional<std::size_t> v2x_port_number(std::string_view port) {
  const auto found = std::ranges::find(v2x_ports, port);
  if (found == v2x_ports.end()) return std::nullopt;
  return static_cast<std::size_t>(found - v2x_ports.begin());
}

std::string v2x_port_of(const VehicleId& sender, std::string_view port) {
  std::string source{port};
  return source.append("/").append(to_string(sender));
}

std::optional<V2xSource> v2x_source(std::string_view source) {
  const std::size_t end = source.find('/');
  if (end == std::string_view::npos) return std::nullopt;
  const auto number = v2x_port_number(source.substr(0, end));
  const std::string_view name = source.substr(end + 1);
  const std::size_t slash = name.find('/');
  if (!number || slash == std::string_view::npos) return std::nullopt;
  VehicleId sender{std::string(name.substr(0, slash)), std::string(name.substr(slash + 1))};
  if (!valid_serial_number(sender.manufacturer) || !valid_serial_number(sender.serial_number)) return std::nullopt;
  return V2xSource{v2x_ports[*number], std::move(sender)};
}

}  // namespace cosiva::wire
