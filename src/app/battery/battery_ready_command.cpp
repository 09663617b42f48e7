#include "cosiva/app/battery/battery_ready_command.h"

#include <string>

#include "cosiva/app/cli/console.h"
#include "cosiva/app/remote/publish_once.h"
#include "cosiva/wire/own/battery_exchange.h"

namespace cosiva::app {

int run_battery_ready(const BatteryReadyArguments& arguments) {
  const std::size_t slash = arguments.vehicle.find('/');
  const wire::VehicleId id =
      slash == std::string::npos
          ? wire::VehicleId{std::string(wire::our_manufacturer), arguments.vehicle}
          : wire::VehicleId{arguments.vehicle.substr(0, slash), arguments.vehicle.substr(slash + 1)};
  if (id.manufacturer.empty() || !wire::valid_serial_number(id.serial_number))
    return report_error({"battery.vehicle", "expected AIV3, or MANUFACTURER/SERIAL", arguments.vehicle});
  BrokerArguments broker = arguments.broker;
  if (broker.address.empty()) broker.address = "127.0.0.1:1883";
  const wire::BatteryReady ready{arguments.battery, arguments.type,          arguments.cycles,
                                 arguments.rest_s,  arguments.temperature_c, arguments.charge_percent};
  const wire::Publish message{wire::own_topic(wire::battery_fitted_topic_prefix, id), to_json(ready), 1, false};
  if (const auto published = publish_once(broker, "cosiva-battery-ready", {message}); !published)
    return report_error(published.error());
  print(to_string(id) + ": batteryReady, '" + arguments.battery + "'");
  return exit_done;
}

}  // namespace cosiva::app
