#include "cosiva/hmi/page_calls.h"

#include <algorithm>
#include <array>
#include <utility>
#include <variant>

#include "cosiva/adapters/http/http_rules.h"
#include "cosiva/hmi/clock_calls.h"
#include "cosiva/hmi/commands.h"
#include "cosiva/hmi/http_responses.h"
#include "cosiva/hmi/queries.h"
#include "cosiva/hmi/zone_calls.h"

namespace cosiva::app {

using adapters::http_error;
using adapters::HttpRequest;
using adapters::HttpResponse;

std::span<const PageCalls::Route> PageCalls::routes() {
  using enum Route::Body;
  static constexpr auto table = std::to_array<Route>({
      {"GET", "/api", none, &get_openapi},
      {"GET", "/api/v1/zone", none, &get_zone},
      {"GET", "/api/v1/snapshot", none, &get_snapshot},
      {"GET", "/api/v1/bijection", none, &get_bijection},
      {"GET", "/api/v1/run", none, &get_run},
      {"GET", "/api/v1/zones", none, &list_zones},
      {"GET", "/api/v1/zone/file", none, &get_zone_file},
      {"GET", "/api/v1/zone/sidecar", none, &get_zone_sidecar},
      {"GET", "/api/v1/zone/beacons/suggestion", none, &suggest_beacons},
      {"GET", "/api/v1/traces", none, &get_traces},
      {"GET", "/api/v1/traces/{n}", none, &get_trace},
      {"POST", "/api/v1/commands", object, &post_command},
      {"GET", "/api/v1/commands/{id}", none, &get_command},
      {"GET", "/api/v1/battery/curves/{id}", none, &get_battery_curve},
      {"GET", "/api/v1/gvs/preview", none, &get_gvs_preview},
      {"POST", "/api/v1/battery/ready", object, &post_battery_ready},
      {"POST", "/api/v1/virtual-objects", object, &add_virtual_object},
      {"DELETE", "/api/v1/virtual-objects", none, &remove_virtual_objects},
      {"PATCH", "/api/v1/virtual-objects/{id}", object, &move_virtual_object},
      {"DELETE", "/api/v1/virtual-objects/{id}", none, &remove_virtual_object},
      {"PUT", "/api/v1/priorities", object, &put_priorities},
      {"POST", "/api/v1/zone/switch", zone, &switch_zone},
      {"POST", "/api/v1/zone/edit", object, &edit_zone},
      {"POST", "/api/v1/zone/undo", none, &undo_zone},
      {"POST", "/api/v1/zone/redo", none, &redo_zone},
      {"POST", "/api/v1/zone/save", none, &save_zone},
      {"POST", "/api/v1/plant/obstacles", object, &add_plant_obstacle},
      {"DELETE", "/api/v1/plant/obstacles/{id}", none, &remove_plant_obstacle},
      {"PUT", "/api/v1/clock", object, &set_clock},
      {"POST", "/api/v1/clock/step", object, &step_clock},
  });
  return table;
}

namespace {

/// The path's parts at a pattern's {…}; nothing when the path does not match.
std::optional<std::vector<std::string>> match(std::string_view pattern, const std::vector<std::string>& segments) {
  std::vector<std::string> arguments;
  std::size_t at = 0;
  for (pattern.remove_prefix(1); !pattern.empty(); ++at) {
    const std::size_t slash = std::min(pattern.find('/'), pattern.size());
    const std::string_view part = pattern.substr(0, slash);
    if (at >= segments.size()) return std::nullopt;
    if (part.starts_with('{'))
      arguments.push_back(segments[at]);
    else if (part != segments[at])
      return std::nullopt;
    pattern.remove_prefix(std::min(slash + 1, pattern.size()));
  }
  if (at != segments.size()) return std::nullopt;
  return arguments;
}

/// Whether a call is a Restart of one of these vehicles ("*": all).
bool restarts(const PageCalls::ReadCall& read, const std::vector<std::string>& vehicles) {
  if (read.route->handler != &post_command || read.call.body.text("command") != "restart") return false;
  const virtual_side::DecodedCommand decoded{read.call.request.body};
  if (!decoded.command()) return false;
  const auto* command = std::get_if<virtual_side::VehicleCommand>(&*decoded.command());
  if (command == nullptr) return false;
  const auto has = [](const std::vector<std::string>& names, std::string_view name) {
    return std::ranges::find(names, name) != names.end();
  };
  if (has(vehicles, "*") || has(command->vehicle_names, "*")) return true;
  return std::ranges::any_of(vehicles, [&](const std::string& name) { return has(command->vehicle_names, name); });
}

Result<JsonValue> object_of(const std::string& body) {
  if (body.empty()) return fail("http.body", "this call needs a JSON object as its body; GET /api shows its fields");
  auto value = JsonValue::parse(body, switch_bytes_max);
  if (!value) return fail("http.body", "the body must be a JSON object; it is " + value.error().message);
  if (value->object() == nullptr) return fail("http.body", "the body must be a JSON object; GET /api shows its fields");
  return value;
}

}  // namespace

PageCalls::PageCalls(PageHost host) : context_{std::move(host)} {
  context_.on_decided([this] { handle_changes(); });
}

bool PageCalls::takes_zone(const HttpRequest& request) {
  return request.method == "POST" && request.path == switch_path;
}

tl::expected<PageCalls::ReadCall, HttpResponse> PageCalls::read(HttpRequest request, const ZoneLibrary& zones) {
  std::string allowed;
  for (const Route& route : routes()) {
    auto arguments = match(route.pattern, request.segments);
    if (!arguments) continue;
    if (route.method != request.method) {
      allowed += (allowed.empty() ? "" : ", ") + std::string(route.method);
      continue;
    }
    ReadCall read{&route, {std::move(request), std::move(*arguments), {}, {}}};
    if (route.body == Route::Body::none) return read;
    auto body = object_of(read.call.request.body);
    if (!body) return tl::unexpected(refusal(body.error()));
    read.call.body = std::move(*body);
    if (route.body == Route::Body::object) return read;
    auto zone = read_zone(zones, read.call);
    if (!zone) return tl::unexpected(std::move(zone.error()));
    read.call.zone = std::move(*zone);
    read.call.body = {};
    read.call.request.body.clear();
    return read;
  }
  if (allowed.empty())
    return tl::unexpected(
        http_error(404, "http.not_found", "there is no call " + request.path + "; GET /api lists those there are"));
  HttpResponse wrong = http_error(405, "http.method", request.path + " is requested with " + allowed);
  wrong.headers.emplace_back("Allow", allowed);
  return tl::unexpected(std::move(wrong));
}

void PageCalls::handle(ReadCall read, Respond respond) {
  const bool is_change = adapters::http_rules::changes_state(read.route->method);
  if (is_change && read.route->handler == &post_command && is_stop(read.call.body)) {
    const auto given = read_stop(read.call.body, context_.stops()->begin());
    return respond(given ? stop(*given) : refusal(given.error()));
  }
  if (!is_change) return respond(response(read));
  changes_.push_back({std::move(read), std::move(respond), std::nullopt});
  handle_changes();
}

HttpResponse PageCalls::stop(const StopRequest& stop) {
  if (refuse_restarts(stop.vehicles)) stops_to_repeat_.push_back(stop);
  return give_stop(context_, stop);
}

bool PageCalls::refuse_restarts(const std::vector<std::string>& vehicles) {
  bool given = false;
  for (auto change = changes_.begin(); change != changes_.end();) {
    if (!restarts(change->read, vehicles)) {
      ++change;
      continue;
    }
    given = given || change->response;
    if (change->response) {
      ++change;
      continue;
    }
    const Respond respond = std::move(change->respond);
    change = changes_.erase(change);
    respond(http_error(409, "command.stopped", "a Stop was sent after this Restart; restart again where that is safe"));
  }
  return given;
}

void PageCalls::handle_changes() {
  // A command that is decided at once calls this function from within.
  if (std::exchange(handling_, true)) return;
  while (!changes_.empty()) {
    Change& change = changes_.front();
    if (!change.response && waits_for_earlier_commands()) break;
    if (!change.response) change.response = response(change.read);
    if (context_.undecided() > 0) break;
    const auto failure = context_.take_failure();
    const auto made = context_.take_response();
    const Change done = std::move(change);
    changes_.pop_front();
    done.respond(failure ? refusal(*failure) : made ? made() : *done.response);
    // With an action of its own: the vehicle has performed the first one.
    for (const StopRequest& stop : std::exchange(stops_to_repeat_, {}))
      if (const auto again = read_stop(*JsonValue::parse(stop.json), context_.stops()->begin()))
        (void)give_stop(context_, *again);
  }
  handling_ = false;
}

bool PageCalls::waits_for_earlier_commands() const {
  return host().gives_earlier_commands && host().gives_earlier_commands();
}

HttpResponse PageCalls::response(const ReadCall& read) {
  HttpResponse response = read.route->handler(context_, read.call);
  if (context_.undecided() > 0) return response;
  const auto made = context_.take_response();
  return made ? made() : response;
}

HttpResponse PageCalls::response(const HttpRequest& request) {
  auto read = PageCalls::read(request, *host().zones);
  return read ? response(*read) : std::move(read.error());
}

}  // namespace cosiva::app
