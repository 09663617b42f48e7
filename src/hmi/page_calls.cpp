#include "cosiva/hmi/page_calls.h"

#include <algorithm>
#include <array>
#include <utility>

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
      {"GET", "/api/v1/battery/curves/{id}", none, &get_battery_curve},
      {"GET", "/api/v1/gvs/preview", none, &get_gvs_preview},
      {"POST", "/api/v1/battery/ready", object, &post_battery_ready},
      {"POST", "/api/v1/virtual-objects", object, &add_virtual_object},
      {"DELETE", "/api/v1/virtual-objects", none, &remove_virtual_objects},
      {"PATCH", "/api/v1/virtual-objects/{id}", object, &move_virtual_object},
      {"DELETE", "/api/v1/virtual-objects/{id}", none, &remove_virtual_object},
      {"PUT", "/api/v1/priorities", object, &put_priorities},
      {"POST", "/api/v1/zone/switch", object, &switch_zone},
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

/// Whether a request is a Stop: the command that must not wait for the disk, nor for other changes.
bool is_stop(const HttpRequest& request) {
  if (request.method != "POST" || request.path != "/api/v1/commands") return false;
  const auto body = JsonValue::parse(request.body, virtual_side::DecodedCommand::vehicle_command_bytes_max);
  return body && body->text("command") == "stop";
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

HttpResponse PageCalls::respond(const HttpRequest& request) {
  if (!adapters::http_rules::changes_state(request.method) || is_stop(request)) return response(request);
  HttpResponse later;
  later.later = [this, request](Respond respond) {
    changes_.push_back({request, std::move(respond), std::nullopt});
    handle_changes();
  };
  return later;
}

void PageCalls::handle_changes() {
  // A command that is decided at once calls this function from within.
  if (std::exchange(handling_, true)) return;
  while (!changes_.empty()) {
    Change& change = changes_.front();
    if (!change.response) change.response = response(change.request);
    if (context_.undecided() > 0) break;
    const auto failure = context_.take_failure();
    const auto made = context_.take_response();
    const Change done = std::move(change);
    changes_.pop_front();
    done.respond(failure ? refusal(*failure) : made ? made() : *done.response);
  }
  handling_ = false;
}

HttpResponse PageCalls::response(const HttpRequest& request) {
  std::string allowed;
  for (const Route& route : routes()) {
    auto arguments = match(route.pattern, request.segments);
    if (!arguments) continue;
    if (route.method != request.method) {
      allowed += (allowed.empty() ? "" : ", ") + std::string(route.method);
      continue;
    }
    Call call{request, std::move(*arguments), {}};
    if (route.body == Route::Body::object) {
      auto body = object_of(request.body);
      if (!body) return refusal(body.error());
      call.body = std::move(*body);
    }
    HttpResponse response = route.handler(context_, call);
    if (context_.undecided() > 0) return response;
    const auto made = context_.take_response();
    return made ? made() : response;
  }
  if (allowed.empty())
    return http_error(404, "http.not_found", "there is no call " + request.path + "; GET /api lists those there are");
  HttpResponse wrong = http_error(405, "http.method", request.path + " is requested with " + allowed);
  wrong.headers.emplace_back("Allow", allowed);
  return wrong;
}

}  // namespace cosiva::app
