// What the page and other programs read (docs/protocols/hmi-api.md, "Reading").
#include <algorithm>
#include <charconv>
#include <chrono>

#include "cosiva/base/json_writer.h"
#include "cosiva/hmi/openapi.h"
#include "cosiva/hmi/page_calls.h"

namespace cosiva::app {
namespace {

using adapters::http_error;
using adapters::HttpResponse;

constexpr std::uint64_t traces_limit_default = 200;
constexpr std::uint64_t traces_limit_max = 1000;

/// A whole number; `otherwise` where there is none; nothing where it is no number.
std::optional<std::uint64_t> number(const std::string& text, std::optional<std::uint64_t> otherwise) {
  if (text.empty()) return otherwise;
  std::uint64_t value = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (error != std::errc{} || end != text.data() + text.size()) return std::nullopt;
  return value;
}

}  // namespace

HttpResponse PageCalls::openapi(const Call&) { return json_answer(std::string(openapi_json())); }

HttpResponse PageCalls::zone(const Call&) { return json_answer(host_.core->zone_json()); }

HttpResponse PageCalls::snapshot(const Call&) { return json_answer(host_.core->snapshot_json()); }

HttpResponse PageCalls::bijection(const Call&) {
  JsonWriter json;
  host_.core->write_bijection(json);
  return json_answer(json.take());
}

HttpResponse PageCalls::run(const Call&) { return json_answer(run_json()); }

std::string PageCalls::run_json() const {
  const PageHost::Clock now = clock();
  JsonWriter json;
  json.begin_object().field("name", host_.run_name).key("scenario");
  if (host_.scenario_name.empty())
    json.null();
  else
    json.value(host_.scenario_name);
  json.field("version", COSIVA_VERSION).key("clock").begin_object();
  json.field("kind", now.is_virtual ? "virtual" : "wall").field("running", now.running).field("speed", now.speed);
  json.field("time_ms", std::chrono::duration<double, std::milli>(host_.now().time_since_epoch()).count());
  json.end_object().end_object();
  return json.take();
}

HttpResponse PageCalls::traces(const Call& call) {
  const auto after = number(call.request.parameter("after"), 0);
  const auto limit = number(call.request.parameter("limit"), traces_limit_default);
  if (!after || !limit) return http_error(400, "http.query", "'after' and 'limit' are whole numbers from 0 on");
  return json_answer(host_.core->traces_json(*after, std::min(*limit, traces_limit_max)));
}

HttpResponse PageCalls::trace(const Call& call) {
  const auto n = number(call.arguments[0], std::nullopt);
  if (!n) return http_error(400, "http.query", "a trace is named by its running number, such as /api/v1/traces/17");
  auto found = host_.core->trace_json(*n);
  if (!found)
    return http_error(404, "trace.not_found",
                      "there is no trace " + std::to_string(*n) + " any more, or not yet; only the last are kept");
  return json_answer(std::move(*found));
}

HttpResponse PageCalls::gvs_picture(const Call&) {
  const auto picture = host_.gvs_picture ? host_.gvs_picture() : nullptr;
  if (picture) return {200, "image/x-portable-graymap", *picture, {}};
  return http_error(404, "gvs.no_picture",
                    "no camera has sent a picture in the last seconds; where one watches (cosiva up --gvs), it does so "
                    "from half a second after the first question on");
}

HttpResponse PageCalls::battery_curve(const Call& call) {
  auto found = host_.core->battery_curve_json(call.arguments[0]);
  if (!found)
    return http_error(404, "battery.not_found",
                      "'" + call.arguments[0].substr(0, 80) + "' has not told how its battery fares");
  return json_answer(std::move(*found));
}

}  // namespace cosiva::app
