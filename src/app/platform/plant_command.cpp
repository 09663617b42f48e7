#include "cosiva/app/platform/plant_command.h"

#include <string>
#include <utility>

#include "cosiva/adapters/unix_ports.h"
#include "cosiva/app/cli/console.h"
#include "cosiva/app/platform/part.h"
#include "cosiva/physical/plant/plant_core.h"
#include "cosiva/physical/plant/plant_options.h"

namespace cosiva::app {
namespace {

using adapters::EventLoop;
using adapters::LiveShell;
using adapters::PortHandlers;

}  // namespace

int run_plant(const PlantArguments& arguments) {
  auto zone = load_good_zone(arguments.zone);
  if (!zone) return report_error(zone.error());
  physical::PlantOptions options;
  options.zone = (*zone)->configuration();
  options.rtm = std::move(*zone);
  options.vehicles = arguments.vehicles;
  options.seed = arguments.seed;
  auto equipment = physical::read_equipment(arguments.vehicles, arguments.line_tracking, arguments.without_rali);
  if (!equipment) return report_error(equipment.error());
  options.equipment = std::move(*equipment);
  auto live = live_options(arguments.part, "plant", "plant", physical::to_json(options));
  if (!live) return report_error(live.error());
  live->state_file = arguments.state_file;
  auto core = physical::PlantCore::make(options);
  if (!core) return report_error(core.error());

  EventLoop loop;
  LiveShell shell{loop, **core, std::move(*live), [&](const PortHandlers& handlers) {
                    return adapters::listen_unix_ports(loop, arguments.sockets_directory, (*core)->ports(), handlers);
                  }};
  return Part{loop, shell, "plant", arguments.part, [&] { return (*core)->summary_json(); }}.run();
}

}  // namespace cosiva::app
