#include "cosiva/app/vehicle/vehicle_list_command.h"

#include "cosiva/adapters/http/http_client.h"
#include "cosiva/app/cli/console.h"
#include "cosiva/app/vehicle/listed_vehicles.h"

namespace cosiva::app {

int run_vehicle_list(const VehicleArguments& arguments) {
  const auto client = adapters::HttpClient::make(arguments.url);
  if (!client) return report_error(client.error());
  const auto vehicles = vehicles_of(*client);
  if (!vehicles) return report_error(vehicles.error());
  print(arguments.json ? to_json(*vehicles) : to_text(*vehicles));
  return exit_done;
}

}  // namespace cosiva::app
