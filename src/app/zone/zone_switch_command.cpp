#include "cosiva/app/zone/zone_switch_command.h"

#include <chrono>
#include <thread>

#include "cosiva/adapters/http/http_client.h"
#include "cosiva/app/cli/console.h"
#include "cosiva/app/remote/publish_once.h"
#include "cosiva/app/remote/zone_switch.h"
#include "cosiva/app/resources/resource_paths.h"
#include "cosiva/app/resources/zone_files.h"
#include "cosiva/app/zone/zone_arguments.h"
#include "cosiva/app/zone/zone_report.h"
#include "cosiva/base/json_value.h"
#include "cosiva/wire/messages/topics.h"

namespace cosiva::app {
namespace {

using std::chrono::milliseconds;

constexpr milliseconds check_period{50};

/// Queries the platform until the first vehicle moves, or until the longest wait is over.
std::optional<SwitchedZone> watch(const adapters::HttpClient& client, double wait_s) {
  const auto until = std::chrono::steady_clock::now() + std::chrono::duration<double>(wait_s);
  std::optional<SwitchedZone> switched;
  for (;;) {
    if (const auto response = client.send_request("GET", "/api/v1/snapshot"); response && response->status == 200)
      switched = switched_in(response->body);
    // An off-route vehicle will not move, and neither will one that is absent.
    const bool nobody = switched && switched->off_route.size() >= switched->vehicles;
    if (nobody || (switched && switched->first_moving_ms) || std::chrono::steady_clock::now() >= until) return switched;
    std::this_thread::sleep_for(check_period);
  }
}

void report(const ZoneArguments& arguments, const std::string& name, double revision,
            const std::optional<SwitchedZone>& switched) {
  if (!arguments.json) {
    print("switched to " + name + (switched ? "\n  " + to_text(*switched) : std::string{}));
    return;
  }
  JsonWriter json;
  json.begin_object().field("zone", name).field("revision", static_cast<std::uint64_t>(revision));
  json.field("snapped", switched ? switched->snapped : 0).key("offRoute").begin_array();
  if (switched)
    for (const std::string& vehicle : switched->off_route) json.value(vehicle);
  json.end_array().key("first_moving_ms");
  if (switched && switched->first_moving_ms)
    json.value(*switched->first_moving_ms);
  else
    json.null();
  json.end_object();
  print(json.text());
}

int switch_over_http(const ZoneArguments& arguments, const zone::ZoneConfiguration& configuration) {
  const auto client = adapters::HttpClient::make(arguments.url);
  if (!client) return report_error(client.error());
  JsonWriter json;
  zone::write_json(json, configuration);
  const auto response = client->send_request("POST", "/api/v1/zone/switch", json.take(), std::chrono::seconds{120});
  if (!response) return report_error(response.error());
  if (response->status != 200) {
    Error refused = refusal_in(response->body, response->status);
    refused.message += "\n  the present zone stays in force";
    return report_error(refused);
  }
  const auto accepted = JsonValue::parse(response->body);
  const std::string name = accepted ? accepted->text("name").value_or(configuration.origin) : configuration.origin;
  report(arguments, name, accepted ? accepted->number("revision").value_or(0.0) : 0.0,
         watch(*client, arguments.wait_s));
  return exit_done;
}

/// Publishes as a physical side does: the new configuration is retained, and configurations of other formats are
/// removed from the broker first, so that a later subscriber finds one only.
int switch_over_broker(const ZoneArguments& arguments, const zone::ZoneConfiguration& configuration) {
  // A broker sends no response: errors of the zone can be reported here only.
  const auto rtm = zone::Rtm::initialise(configuration);
  if (!rtm) return report_error(rtm.error());
  const std::string prefix{wire::zone_topic_prefix};
  std::vector<wire::Publish> messages;
  for (const std::string_view format : zone::known_formats())
    if (format != configuration.format) messages.push_back({prefix + std::string(format), {}, 1, true});
  messages.push_back({prefix + configuration.format, zone::to_payload(configuration), 1, true});
  if (const auto published = publish_once(arguments.broker, "cosiva-switch", messages); !published)
    return report_error(published.error());
  print("published " + rtm->zone().name + " (" + size_of(rtm->zone()) + ") to " + prefix + configuration.format +
        "\n  each subscriber validates the zone and switches by itself");
  return exit_done;
}

}  // namespace

int run_zone_switch(const ZoneArguments& arguments) {
  auto configuration = load_zone(arguments.zone, arguments.sidecar);
  if (!configuration) return report_error(configuration.error());
  return arguments.broker.address.empty() ? switch_over_http(arguments, *configuration)
                                          : switch_over_broker(arguments, *configuration);
}

}  // namespace cosiva::app
