#include "cosiva/app/platform/aiv_command.h"

#include <charconv>
#include <memory>
#include <string>
#include <utility>

#include "cosiva/adapters/unix_ports.h"
#include "cosiva/adapters/v2x/direct_ports.h"
#include "cosiva/adapters/v2x/multicast_link.h"
#include "cosiva/aiv/onboard/onboard_core.h"
#include "cosiva/app/cli/console.h"
#include "cosiva/app/platform/direct_link.h"
#include "cosiva/app/platform/part.h"
#include "cosiva/app/resources/rule_files.h"
#include "cosiva/app/resources/vehicle_file.h"
#include "cosiva/base/json_writer.h"

namespace cosiva::app {
namespace {

using adapters::EventLoop;
using adapters::LiveShell;
using adapters::PortHandlers;

/// "section:s", as in `--start`.
Result<aiv::OnboardOptions::Start> parse_start(const std::string& text) {
  const std::size_t colon = text.rfind(':');
  double s_m = 0.0;
  if (colon != std::string::npos && colon > 0) {
    const char* end = text.data() + text.size();
    const auto [stop, error] = std::from_chars(text.data() + colon + 1, end, s_m);
    if (error == std::errc{} && stop == end) return aiv::OnboardOptions::Start{text.substr(0, colon), s_m};
  }
  return fail("aiv.start", "'" + text + "' is not section:s, such as east:0.85 (metres along the section)", "--start");
}

}  // namespace

int run_aiv(const AivArguments& arguments) {
  aiv::OnboardOptions options;
  options.number = arguments.number;
  options.id.serial_number = arguments.serial.empty() ? "AIV" + std::to_string(arguments.number) : arguments.serial;
  if (!wire::valid_serial_number(options.id.serial_number))
    return report_error({"aiv.serial", "a serial number has A-Z a-z 0-9 _ . : - only, 64 at most", "--serial"});
  auto rules = load_speed_rules(arguments.rules);
  if (!rules) return report_error(rules.error());
  options.rules = std::move(*rules);
  if (!arguments.vehicle_file.empty()) {
    auto actions = load_vehicle_file(arguments.vehicle_file);
    if (!actions) return report_error(actions.error());
    options.actions = std::move(*actions);
  }
  options.v2x = arguments.v2x;
  options.rali = arguments.rali;
  if (!arguments.start.empty()) {
    auto start = parse_start(arguments.start);
    if (!start) return report_error(start.error());
    options.start = std::move(*start);
  }
  if (!arguments.zone.empty()) {
    auto zone = load_good_zone(arguments.zone);
    if (!zone) return report_error(zone.error());
    options.zone = (*zone)->configuration();
    options.rtm = std::move(*zone);
  }
  if (arguments.direct.link_loss == "finish-base") options.link_loss = aiv::LinkLoss::finish_base;
  auto direct = direct_link_options(arguments.direct, options.id);
  if (!direct) return report_error(direct.error());
  if (*direct && !options.v2x)
    return report_error({"aiv.v2x", "is off, and a direct link carries V2X messages only", "--v2x"});
  options.v2x_direct = direct->has_value();
  if (arguments.direct.autonomy == "negotiate") options.autonomy = aiv::Autonomy::negotiate;
  auto live = live_options(arguments.part, "aiv", "aiv" + std::to_string(arguments.number), aiv::to_json(options));
  if (!live) return report_error(live.error());
  live->state_file = arguments.state_file;
  if (arguments.emulated) live->obeys_radio = to_string(options.id);

  EventLoop loop;
  aiv::OnboardCore core{options};
  const adapters::MulticastLink* link = nullptr;
  LiveShell shell{
      loop, core, std::move(*live), [&](const PortHandlers& handlers) -> Result<std::unique_ptr<adapters::Ports>> {
        auto boards = adapters::connect_unix_ports(loop, arguments.sockets_directory, core.ports(), handlers);
        if (!boards || !*direct) return boards;
        auto opened = adapters::open_multicast(loop, **direct, handlers);
        if (!opened) return tl::unexpected(opened.error());
        link = opened->get();
        return std::make_unique<adapters::DirectPorts>(std::move(*boards), std::move(*opened));
      }};
  const auto summary = [&] {
    JsonWriter json;
    json.begin_object().field("number", arguments.number).field("speed", core.estimated_speed_mps()).key("estimated");
    if (const auto pose = core.estimated_pose()) {
      json.begin_object().field("x", pose->x_m).field("y", pose->y_m).field("heading", pose->heading_rad).end_object();
    } else {
      json.null();
    }
    if (link != nullptr) report_counters(json, *link);
    json.end_object();
    return json.take();
  };
  return Part{loop, shell, "aiv", arguments.part, summary}.run();
}

}  // namespace cosiva::app
