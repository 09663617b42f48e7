#include "cosiva/app/vehicle/listed_vehicles.h"

#include <algorithm>
#include <cstddef>
#include <tuple>

#include "cosiva/app/cli/console.h"
#include "cosiva/base/json_value.h"
#include "cosiva/base/json_writer.h"

namespace cosiva::app {
namespace {

constexpr std::size_t snapshot_bytes_max = std::size_t{1} << 28U;
constexpr std::size_t names_listed_max = 12;

std::string_view serial_of(std::string_view id) { return id.substr(id.find('/') + 1); }

std::string known_names(const std::vector<ListedVehicle>& vehicles) {
  if (vehicles.empty()) return "the platform has no vehicle";
  std::string names;
  for (std::size_t i = 0; i < vehicles.size() && i < names_listed_max; ++i)
    names += (i == 0 ? "" : ", ") + vehicles[i].id;
  if (vehicles.size() > names_listed_max)
    names += " and " + std::to_string(vehicles.size() - names_listed_max) + " more";
  return "the platform has " + names;
}

std::string condition_of(const ListedVehicle& vehicle) {
  std::string text = vehicle.is_virtual       ? "virtual only"
                     : vehicle.absent.empty() ? "matched"
                                              : "orphan: " + vehicle.absent;
  if (vehicle.excluded) text += ", excluded";
  return text;
}

std::string padded(std::string_view text, std::size_t width) {
  return std::string(text) + std::string(text.size() < width ? width - text.size() : 0, ' ');
}

}  // namespace

Result<std::vector<ListedVehicle>> vehicles_in(std::string_view snapshot_json) {
  const auto snapshot = JsonValue::parse(snapshot_json, snapshot_bytes_max);
  const JsonValue* aivs = snapshot ? snapshot->find("aivs") : nullptr;
  if (aivs == nullptr || aivs->array() == nullptr)
    return fail("vehicle.snapshot", "the response contains no list of vehicles; is --url a platform's address?");
  std::vector<ListedVehicle> vehicles;
  for (const JsonValue& aiv : *aivs->array()) {
    vehicles.push_back({aiv.text("id").value_or(""), aiv.number("number").value_or(0),
                        aiv.text("connection").value_or(""), aiv.text("status").value_or(""),
                        aiv.text("section").value_or(""), aiv.flag("augmented").value_or(false),
                        aiv.flag("excluded").value_or(false), aiv.text("absent").value_or("")});
  }
  std::ranges::stable_sort(vehicles, {}, [](const ListedVehicle& vehicle) {
    return std::tie(vehicle.is_virtual, vehicle.number, vehicle.id);
  });
  return vehicles;
}

Result<std::vector<ListedVehicle>> vehicles_of(const adapters::HttpClient& client) {
  const auto snapshot = client.send_request("GET", "/api/v1/snapshot");
  if (!snapshot) return tl::unexpected(snapshot.error());
  return vehicles_in(snapshot->body);
}

Result<std::string> id_of(std::string_view name, const std::vector<ListedVehicle>& vehicles) {
  if (name.find('/') != std::string_view::npos) return std::string(name);
  const auto has_serial = [name](const ListedVehicle& vehicle) { return serial_of(vehicle.id) == name; };
  const auto found = std::ranges::find_if(vehicles, has_serial);
  if (found == vehicles.end()) {
    std::vector<std::string> serials;
    serials.reserve(vehicles.size());
    for (const ListedVehicle& vehicle : vehicles) serials.emplace_back(serial_of(vehicle.id));
    const std::string near = nearest_word(name, serials);
    return fail(
        "vehicle.unknown",
        "no vehicle has this serial number; " + (near.empty() ? known_names(vehicles) : "did you mean " + near + "?"),
        std::string(name));
  }
  const auto other = std::find_if(std::next(found), vehicles.end(), has_serial);
  if (other == vehicles.end()) return found->id;
  return fail("vehicle.ambiguous", "several vehicles have this serial number: " + found->id + " and " + other->id,
              std::string(name));
}

std::string to_text(const std::vector<ListedVehicle>& vehicles) {
  if (vehicles.empty()) return "no vehicle";
  std::size_t width = 0;
  for (const ListedVehicle& vehicle : vehicles) width = std::max(width, vehicle.id.size());
  std::string text;
  for (const ListedVehicle& vehicle : vehicles) {
    if (!text.empty()) text += '\n';
    text += padded(vehicle.id, width) + "  " + padded(vehicle.connection, 16) + "  " + padded(vehicle.status, 7) +
            "  " + padded(vehicle.section.empty() ? "-" : vehicle.section, 10) + "  " + condition_of(vehicle);
  }
  return text;
}

std::string to_json(const std::vector<ListedVehicle>& vehicles) {
  JsonWriter json;
  json.begin_array();
  for (const ListedVehicle& vehicle : vehicles) {
    json.begin_object().field("id", vehicle.id).field("connection", vehicle.connection);
    json.field("status", vehicle.status).field("section", vehicle.section).field("virtual", vehicle.is_virtual);
    json.field("excluded", vehicle.excluded).field("absent", vehicle.absent).end_object();
  }
  json.end_array();
  return json.take();
}

}  // namespace cosiva::app
