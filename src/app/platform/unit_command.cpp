#include "cosiva/app/platform/unit_command.h"

#include <memory>
#include <utility>

#include "cosiva/adapters/event_loop.h"
#include "cosiva/adapters/live_shell.h"
#include "cosiva/adapters/v2x/multicast_link.h"
#include "cosiva/app/cli/console.h"
#include "cosiva/app/platform/direct_link.h"
#include "cosiva/app/platform/part.h"
#include "cosiva/base/json_writer.h"
#include "cosiva/physical/roadside/crossing_unit.h"

namespace cosiva::app {

int run_unit(const UnitArguments& arguments) {
  auto zone = load_good_zone(arguments.zone);
  if (!zone) return report_error(zone.error());
  const wire::VehicleId id{std::string(wire::unit_manufacturer), arguments.crossing};
  auto direct = direct_link_options(arguments.direct, id);
  if (!direct) return report_error(direct.error());
  physical::CrossingUnitOptions options;
  options.rtm = std::move(*zone);
  options.crossing = arguments.crossing;
  options.direct = direct->has_value();
  options.emulated = arguments.emulated;
  options.off = arguments.off;
  const std::string configuration = physical::to_json(options);
  auto core = physical::CrossingUnit::make(std::move(options));
  if (!core) return report_error(core.error());
  auto live = live_options(arguments.part, "unit", "unit-" + arguments.crossing, configuration);
  if (!live) return report_error(live.error());

  adapters::EventLoop loop;
  const adapters::MulticastLink* link = nullptr;
  adapters::OpenPorts open_ports;
  if (*direct) {
    (*direct)->repeats = true;
    open_ports = [&](const adapters::PortHandlers& handlers) -> Result<std::unique_ptr<adapters::Ports>> {
      auto opened = adapters::open_multicast(loop, **direct, handlers);
      if (!opened) return tl::unexpected(opened.error());
      link = opened->get();
      return std::move(*opened);
    };
  }
  adapters::LiveShell shell{loop, **core, std::move(*live), std::move(open_ports)};
  const auto summary = [&] {
    const physical::CrossingUnit::Counters& counters = (*core)->counters();
    JsonWriter json;
    json.begin_object().key("status").raw(wire::to_json((*core)->status()));
    json.field("repeated", counters.repeated).field("refused", counters.refused);
    if (link != nullptr) report_counters(json, *link);
    return json.end_object().take();
  };
  return Part{loop, shell, "unit", arguments.part, summary}.run();
}

}  // namespace cosiva::app
