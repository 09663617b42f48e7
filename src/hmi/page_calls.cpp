#include "cosiva/hmi/page_calls.h"

#include <algorithm>
#include <array>
#include <utility>

#include "cosiva/base/json_writer.h"

namespace cosiva::app {

using adapters::http_error;
using adapters::HttpRequest;
using adapters::HttpResponse;

std::span<const PageCalls::Route> PageCalls::routes() {
  using enum Route::Body;
  using Calls = PageCalls;
  static constexpr auto table = std::to_array<Route>({
      {"GET", "/api", none, &Calls::openapi},
      {"GET", "/api/v1/zone", none, &Calls::zone},
      {"GET", "/api/v1/snapshot", none, &Calls::snapshot},
      {"GET", "/api/v1/bijection", none, &Calls::bijection},
      {"GET", "/api/v1/run", none, &Calls::run},
      {"GET", "/api/v1/zones", none, &Calls::zones},
      {"GET", "/api/v1/zone/file", none, &Calls::zone_file},
      {"GET", "/api/v1/zone/companion", none, &Calls::zone_companion},
      {"GET", "/api/v1/zone/beacons/suggestion", none, &Calls::suggest_beacons},
      {"GET", "/api/v1/traces", none, &Calls::traces},
      {"GET", "/api/v1/traces/{n}", none, &Calls::trace},
      {"POST", "/api/v1/commands", object, &Calls::command},
      {"GET", "/api/v1/battery/curves/{id}", none, &Calls::battery_curve},
      {"GET", "/api/v1/gvs/picture", none, &Calls::gvs_picture},
      {"POST", "/api/v1/battery/ready", object, &Calls::battery_ready},
      {"POST", "/api/v1/things", object, &Calls::add_thing},
      {"DELETE", "/api/v1/things", none, &Calls::remove_things},
      {"PATCH", "/api/v1/things/{id}", object, &Calls::move_thing},
      {"DELETE", "/api/v1/things/{id}", none, &Calls::remove_thing},
      {"PUT", "/api/v1/priorities", object, &Calls::priorities},
      {"POST", "/api/v1/zone/switch", object, &Calls::switch_zone},
      {"POST", "/api/v1/zone/edit", object, &Calls::edit_zone},
      {"POST", "/api/v1/zone/undo", none, &Calls::undo_zone},
      {"POST", "/api/v1/zone/redo", none, &Calls::redo_zone},
      {"POST", "/api/v1/zone/save", none, &Calls::save_zone},
      {"POST", "/api/v1/plant/obstacles", object, &Calls::add_plant_obstacle},
      {"DELETE", "/api/v1/plant/obstacles/{id}", none, &Calls::remove_plant_obstacle},
      {"PUT", "/api/v1/clock", object, &Calls::set_clock},
      {"POST", "/api/v1/clock/step", object, &Calls::step_clock},
  });
  return table;
}

namespace {

/// What stands at a pattern's {…}; nothing when the path is another.
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

Result<JsonValue> object_of(const std::string& body) {
  if (body.empty())
    return fail("http.body", "this call needs a JSON object as its body; GET /api shows what stands in it");
  auto value = JsonValue::parse(body, switch_bytes_max);
  if (!value) return fail("http.body", "the body must be a JSON object; it is " + value.error().message);
  if (value->object() == nullptr)
    return fail("http.body", "the body must be a JSON object; GET /api shows what stands in it");
  return value;
}

}  // namespace

HttpResponse PageCalls::answer(const HttpRequest& request) {
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
    return (this->*route.handler)(call);
  }
  if (allowed.empty())
    return http_error(404, "http.not_found", "there is no call " + request.path + "; GET /api lists those there are");
  HttpResponse wrong = http_error(405, "http.method", request.path + " is asked with " + allowed);
  wrong.headers.emplace_back("Allow", allowed);
  return wrong;
}

void PageCalls::know_plant(std::set<std::string> obstacles) {
  std::erase_if(plant_added_, [&](const std::string& id) { return obstacles.contains(id); });
  plant_obstacles_ = std::move(obstacles);
}

bool PageCalls::in_plant(const std::string& obstacle) const {
  return plant_added_.contains(obstacle) || (plant_obstacles_ && plant_obstacles_->contains(obstacle));
}

Result<void> PageCalls::give(std::string json) {
  if (auto checked = host_.core->check_command(json); !checked) return checked;
  host_.command("http", std::move(json));
  return {};
}

HttpResponse json_answer(std::string json, unsigned status) {
  return {status, "application/json", std::move(json), {}};
}

HttpResponse refusal(const Error& error) {
  using Case = std::pair<std::string_view, unsigned>;
  static constexpr std::array cases{Case{"command.impossible", 409}, Case{"edit.undo", 409},  Case{"edit.redo", 409},
                                    Case{"edit.zone", 409},          Case{"plant.zone", 409}, Case{"thing.zone", 409},
                                    Case{"battery.not_asked", 409},  Case{"thing.room", 409}, Case{"thing.many", 429},
                                    Case{"thing.unknown", 404}};
  unsigned status = 400;
  for (const auto& [code, meant] : cases)
    if (error.code == code) status = meant;
  return http_error(status, error.code, to_string(error));
}

void write_json(JsonWriter& json, const JsonValue& value) {
  if (const bool* flag = value.flag()) {
    json.value(*flag);
  } else if (const double* number = value.number()) {
    json.value(*number);
  } else if (const std::string* text = value.text()) {
    json.value(*text);
  } else if (const JsonValue::Array* array = value.array()) {
    json.begin_array();
    for (const JsonValue& element : *array) write_json(json, element);
    json.end_array();
  } else if (const JsonValue::Object* object = value.object()) {
    json.begin_object();
    for (const auto& [name, member] : *object) write_json(json.key(name), member);
    json.end_object();
  } else {
    json.null();
  }
}

}  // namespace cosiva::app
