#include "cosiva/app/platform/server_command.h"

#include <chrono>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "cosiva/adapters/files.h"
#include "cosiva/adapters/stop/stop_sender.h"
#include "cosiva/adapters/store/live_store.h"
#include "cosiva/app/cli/console.h"
#include "cosiva/app/platform/gvs_view.h"
#include "cosiva/app/platform/live_scenario.h"
#include "cosiva/app/platform/part.h"
#include "cosiva/app/platform/zone_watch.h"
#include "cosiva/app/resources/file_zone_library.h"
#include "cosiva/app/resources/resource_paths.h"
#include "cosiva/app/resources/rule_files.h"
#include "cosiva/app/resources/zone_files.h"
#include "cosiva/base/json_writer.h"
#include "cosiva/experiments/runs/world/fleet.h"
#include "cosiva/hmi/server_page.h"
#include "cosiva/virtual/server/core/server_core.h"
#include "cosiva/wire/messages/stop_target.h"
#include "cosiva/wire/messages/topics.h"
#include "cosiva/wire/own/control_areas.h"

namespace cosiva::app {
namespace {

using adapters::EventLoop;
using adapters::LiveShell;
using adapters::StopSender;

/// How often the sender of Stops is given the list of vehicles.
constexpr std::chrono::milliseconds stop_list_period{100};

PageHost page_host(const ServerArguments& arguments, const virtual_side::ServerCore& core, LiveShell& shell,
                   StopSender& stops, const std::string& scenario_name) {
  PageHost host;
  host.core = &core;
  host.command = [&shell](const std::string& source, std::string json,
                          std::shared_ptr<const virtual_side::DecodedCommand> decoded, PageHost::Decided decided) {
    shell.command(source, std::move(json), std::move(decoded), std::move(decided));
  };
  host.stop = [&shell](const std::string& source, std::string json,
                       std::shared_ptr<const virtual_side::DecodedCommand> decoded, std::function<void()> durable) {
    shell.urgent_command(source, std::move(json), std::move(decoded), std::move(durable));
  };
  host.stop_line.send = [&stops](const std::string& id, const std::vector<std::string>& vehicles) {
    return stops.send(id, vehicles);
  };
  host.stop_line.lift = [&stops](const std::vector<std::string>& vehicles) { stops.lift(vehicles); };
  host.stop_line.unconfirmed = [&stops](const std::string& id) { return stops.unconfirmed(id); };
  host.gives_earlier_commands = [&shell] { return shell.gives_earlier_commands(); };
  host.now = [] { return adapters::WallClock{}.now(); };
  host.zones = std::make_shared<const FileZoneLibrary>();
  if (!arguments.parts_file.empty())
    host.parts_json = [file = arguments.parts_file] { return adapters::read_file(file).value_or(""); };
  host.run_name = arguments.name.empty() ? default_run_name("live") : arguments.name;
  host.scenario_name = scenario_name;
  // A zone given by its file is edited in place; a ready one, given by its name, never.
  host.zone_file = arguments.zone_file;
  if (host.zone_file.empty() && is_like_a_file(arguments.zone)) host.zone_file = arguments.zone;
  return host;
}

std::string store_folder(const ServerArguments& arguments) {
  if (!arguments.store.empty()) return arguments.store;
  return default_store_directory() + (arguments.area.empty() ? "" : "-" + arguments.area);
}

/// The zone file to watch: the file that `up` names, or our own zone's.
std::string watched_file(const ServerArguments& arguments) {
  if (!arguments.watch_file.empty()) return arguments.watch_file;
  return arguments.watch ? find_zone_file(arguments.zone).value_or("") : std::string{};
}

/// Reports a text to the program that started this part: to `up`, or on the terminal.
void report(const PartArguments& part, const std::string& text) {
  if (!part.announce) return print_info(text);
  JsonWriter json;
  json.begin_object().field("event", "print").field("text", text).end_object();
  announce(part, json.text());
}

/// Receives the ground truth of an emulated world, for display only: over a connection of its own, so that none
/// of it can reach the core.
Result<std::unique_ptr<adapters::MqttClient>> ground_truth_for(EventLoop& loop, const PartArguments& part,
                                                               ServerPage& page, const std::string& area) {
  auto mqtt = mqtt_options(part.broker, "cosiva-instrument" + (area.empty() ? "" : "-" + area));
  if (!mqtt) return tl::unexpected(mqtt.error());
  adapters::MqttHandlers handlers;
  handlers.on_link = [](bool) {};
  handlers.on_message = [&page](std::string_view, std::string_view payload, bool) {
    page.ground_truth(std::string(payload));
  };
  return adapters::MqttClient::make(loop, std::move(*mqtt), {std::string(wire::ground_truth_topic)}, std::nullopt,
                                    std::move(handlers));
}

/// Publishes Stops over a connection and a thread of its own.
Result<std::unique_ptr<StopSender>> stop_sender_for(EventLoop& loop, const ServerArguments& arguments) {
  auto mqtt = mqtt_options(arguments.part.broker, "cosiva-stop" + (arguments.area.empty() ? "" : "-" + arguments.area));
  if (!mqtt) return tl::unexpected(mqtt.error());
  adapters::StopHandlers handlers;
  handlers.on_log = [&loop](char, const std::string& text) { loop.post([text] { print_info("cosiva: " + text); }); };
  return StopSender::open(std::move(*mqtt), std::move(handlers));
}

/// Gives the sender of Stops the vehicles that the core knows.
///
/// Invariant: the sender has the list `given_`.
class StopListFeed {
 public:
  StopListFeed(EventLoop& loop, const virtual_side::ServerCore& core, StopSender& stops)
      : core_{core}, stops_{stops}, timer_{loop} {
    timer_.every(stop_list_period, [this] { give(); });
  }

 private:
  void give() {
    auto targets = core_.stop_targets();
    if (targets == given_) return;
    given_ = targets;
    stops_.know(std::move(targets));
  }

  const virtual_side::ServerCore& core_;
  StopSender& stops_;
  std::vector<wire::StopTarget> given_;
  adapters::Timer timer_;
};

/// Waits until the fleet is complete, announces this to `up`, and begins the scenario.
class FleetWatch {
 public:
  FleetWatch(EventLoop& loop, const virtual_side::ServerCore& core, LiveShell& shell, const ServerArguments& arguments,
             experiments::Scenario scenario)
      : core_{core},
        arguments_{arguments},
        fleet_{arguments.fleet > 0 || arguments.scenario.empty() ? arguments.fleet : scenario.aivs},
        scenario_{loop,
                  std::move(scenario),
                  arguments.steps_done,
                  {[&shell](std::string command) { shell.command("scenario", std::move(command)); },
                   [this](std::uint64_t number, SimDuration at, const experiments::Scenario::Step& step) {
                     print_step(number, at, step);
                   }}},
        timer_{loop} {
    if (fleet_ > 0) timer_.every(std::chrono::milliseconds{100}, [this] { check(); });
  }

 private:
  void check() {
    if (!experiments::fleet_is_complete(core_, fleet_)) return;
    timer_.cancel();
    announce(arguments_.part, R"({"event":"fleet"})");
    if (arguments_.scenario.empty()) return;
    using Milliseconds = std::chrono::milliseconds;
    const SimTime began = arguments_.began_ms > 0 ? SimTime{Milliseconds{arguments_.began_ms}} : clock_.now();
    const auto began_ms = std::chrono::duration_cast<Milliseconds>(began.time_since_epoch()).count();
    announce(arguments_.part, R"({"event":"scenario","began_ms":)" + std::to_string(began_ms) + "}");
    scenario_.begin(began);
  }

  void print_step(std::uint64_t number, SimDuration at, const experiments::Scenario::Step& step) {
    JsonWriter json;
    json.begin_object().field("event", "step").field("number", number).field("t_s", to_seconds(at));
    json.field("what", step.what).end_object();
    announce(arguments_.part, json.text());
    if (!arguments_.part.announce) print_info(step_line(to_seconds(at), step.what));
  }

  const virtual_side::ServerCore& core_;
  const ServerArguments& arguments_;
  std::uint32_t fleet_;
  adapters::WallClock clock_;
  LiveScenario scenario_;
  adapters::Timer timer_;
};

}  // namespace

int run_server(const ServerArguments& arguments) {
  virtual_side::ServerOptions options;
  if (!arguments.area.empty() && !wire::valid_area_name(arguments.area))
    return report_error(
        {"server.area", "the name of a control area has A-Z a-z 0-9 _ . : - only, 32 at most", "--area"});
  options.area = arguments.area;
  options.drive = !arguments.no_drive;
  options.v2x = arguments.v2x;
  options.convoys = arguments.convoys;
  options.negotiated_crossings = arguments.autonomy == "negotiate";
  options.map_download_link = arguments.map_link;
  options.vehicles_max = arguments.limits.vehicles_max;
  options.entries_expire_after = from_seconds(arguments.limits.entries_expire_s);
  options.vehicle_messages_per_s_max = arguments.limits.vehicle_rate_max_per_s;
  // The server listens on this machine only; vehicles elsewhere need an address from which they can download the file.
  if (options.map_download_link.empty() && arguments.port != 0)
    options.map_download_link = "http://127.0.0.1:" + std::to_string(arguments.port) + "/api/v1/zone/file";
  if (arguments.watch && arguments.zone.empty())
    return report_error({"server.watch", "without --zone there is no file to watch; add --zone FILE", "--watch"});
  if (!arguments.zone.empty()) {
    auto zone = load_good_zone(arguments.zone);
    if (!zone) return report_error(zone.error());
    options.zone = (*zone)->configuration();
    options.rtm = std::move(*zone);
  }
  auto rules = load_speed_rules(arguments.rules);
  if (!rules) return report_error(rules.error());
  options.virtual_rules = std::move(*rules);
  experiments::Scenario scenario;
  if (!arguments.scenario.empty()) {
    auto loaded = load_scenario(arguments.scenario);
    if (!loaded) return report_error(loaded.error());
    scenario = std::move(loaded->scenario);
  }
  // Two clients with the same name would disconnect each other from the broker.
  const std::string client = arguments.area.empty() ? "server" : "server-" + arguments.area;
  auto live = live_options(arguments.part, "server", client, virtual_side::to_json(options));
  if (!live) return report_error(live.error());

  EventLoop loop;
  const auto keep = parse_keep(arguments.keep);
  if (!keep) return report_error(keep.error());
  adapters::LiveStoreOptions store_options;
  store_options.keep = *keep;
  store_options.on_log = [](char level, const std::string& text) {
    print_info((level == 'i' ? "" : "cosiva: ") + text);
  };
  auto store = adapters::LiveStore::open(loop, store_folder(arguments), std::move(store_options));
  if (!store) return report_error(store.error());
  live->store = std::move(*store);
  virtual_side::ServerCore core{options};
  auto client_options =
      mqtt_options(arguments.part.broker, "cosiva-gvs" + (arguments.area.empty() ? "" : "-" + arguments.area));
  if (!client_options) return report_error(client_options.error());
  LiveShell shell{loop, core, std::move(*live)};
  GvsView gvs{loop, std::move(*client_options)};
  auto stops = stop_sender_for(loop, arguments);
  if (!stops) return report_error(stops.error());
  StopListFeed stop_list{loop, core, **stops};
  PageHost host = page_host(arguments, core, shell, **stops, scenario.name);
  host.gvs_preview = [&gvs] { return gvs.latest_image(); };
  auto page = ServerPage::open(loop, std::move(host), arguments.port, find_web_root(arguments.web_directory),
                               arguments.headless);
  if (!page) return report_error(page.error());
  shell.after_input([&] { (*page)->changed(); });
  std::unique_ptr<adapters::MqttClient> instrument;
  if (arguments.emulated) {
    auto made = ground_truth_for(loop, arguments.part, **page, arguments.area);
    if (!made) return report_error(made.error());
    instrument = std::move(*made);
    instrument->start();
  }
  const std::uint16_t port = (*page)->port();
  if (arguments.port != 0 && port != arguments.port)
    print_info("port " + std::to_string(arguments.port) + " is busy; taking " + std::to_string(port));
  print_info((arguments.headless ? "API at http://127.0.0.1:" : "page at http://127.0.0.1:") + std::to_string(port) +
             "/");
  announce(arguments.part, R"({"event":"page","port":)" + std::to_string(port) + "}");

  std::unique_ptr<ZoneWatch> zone_watch;
  if (const std::string file = watched_file(arguments); !file.empty()) {
    zone_watch = std::make_unique<ZoneWatch>(
        loop, file, std::string{},
        ZoneWatch::Handlers{[&] { return core.zone_configuration(); },
                            [&](std::string command) { shell.command("watch", std::move(command)); },
                            [&](const std::string& text) { report(arguments.part, text); }});
  }

  FleetWatch watch{loop, core, shell, arguments, std::move(scenario)};
  return Part{loop, shell, "server", arguments.part, [&] { return core.summary_json(); }}.run();
}

}  // namespace cosiva::app
