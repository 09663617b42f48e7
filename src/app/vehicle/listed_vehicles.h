#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "cosiva/adapters/http/http_client.h"
#include "cosiva/base/result.h"

namespace cosiva::app {

/// A vehicle of a running platform, from its snapshot.
struct ListedVehicle {
  std::string id;    ///< "CoSiVA/AIV1"
  double number{0};  ///< what the platform displays it as
  std::string connection;
  std::string status;
  std::string section;  ///< empty: on none
  bool is_virtual{false};
  bool excluded{false};
  std::string absent;  ///< why it is not on the physical side; empty: it is
};

/// Reads the snapshot's JSON, which has the vehicles in the order of their arrival. Returns them in the order of the
/// page: physical vehicles before virtual ones, then by number. Fails ("vehicle.snapshot") on anything else.
[[nodiscard]] Result<std::vector<ListedVehicle>> vehicles_in(std::string_view snapshot_json);
/// The vehicles of the platform that the client is connected to. Fails as the request does, and as vehicles_in.
[[nodiscard]] Result<std::vector<ListedVehicle>> vehicles_of(const adapters::HttpClient& client);
/// The id of the vehicle with this id or, where it is unique, this serial number. A name with a slash that no vehicle
/// has is returned as it is: the platform knows excluded vehicles that are away. Fails ("vehicle.unknown",
/// "vehicle.ambiguous") with the names that exist.
[[nodiscard]] Result<std::string> id_of(std::string_view name, const std::vector<ListedVehicle>& vehicles);
/// A line for each vehicle.
[[nodiscard]] std::string to_text(const std::vector<ListedVehicle>& vehicles);
[[nodiscard]] std::string to_json(const std::vector<ListedVehicle>& vehicles);

}  // namespace cosiva::app
