#include "cosiva/app/vehicle/presence_command.h"

#include <string>
#include <utility>

#include "cosiva/adapters/http/http_client.h"
#include "cosiva/app/cli/console.h"
#include "cosiva/app/remote/zone_switch.h"
#include "cosiva/app/vehicle/listed_vehicles.h"
#include "cosiva/base/json_writer.h"

namespace cosiva::app {
namespace {

constexpr unsigned accepted_status = 202;

Result<std::string> body_for(std::string_view command, const std::string& name,
                             const std::vector<ListedVehicle>& vehicles) {
  auto id = id_of(name, vehicles);
  if (!id) return id;
  JsonWriter json;
  json.begin_object().field("command", command).field("vehicle", *id).end_object();
  return json.take();
}

}  // namespace

int run_presence_command(const VehicleArguments& arguments, std::string_view command) {
  const auto client = adapters::HttpClient::make(arguments.url);
  if (!client) return report_error(client.error());
  const auto vehicles = vehicles_of(*client);
  if (!vehicles) return report_error(vehicles.error());
  for (const std::string& name : arguments.vehicles) {
    const auto body = body_for(command, name, *vehicles);
    if (!body) return report_error(body.error());
    const auto response = client->send_request("POST", "/api/v1/commands", *body);
    if (!response) return report_error(response.error());
    if (response->status != accepted_status) return report_error(refusal_in(response->body, response->status));
    print(std::string(command) + " " + name + ": accepted");
  }
  return exit_done;
}

}  // namespace cosiva::app
