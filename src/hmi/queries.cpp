#include "cosiva/hmi/queries.h"

#include <algorithm>
#include <charconv>
#include <chrono>

#include "cosiva/base/json_value.h"
#include "cosiva/base/json_writer.h"
#include "cosiva/hmi/http_responses.h"
#include "cosiva/hmi/openapi.h"

namespace cosiva::app {
namespace {

using adapters::http_error;
using adapters::HttpResponse;

constexpr std::uint64_t traces_limit_default = 200;
constexpr std::uint64_t traces_limit_max = 1000;

/// A whole number; `otherwise` where the text is empty; nothing where the text is not a number.
std::optional<std::uint64_t> number(const std::string& text, std::optional<std::uint64_t> otherwise) {
  if (text.empty()) return otherwise;
  std::uint64_t value = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (error != std::errc{} || end != text.data() + text.size()) return std::nullopt;
  return value;
}

}  // namespace

HttpResponse get_openapi(CallContext&, const Call&) { return json_response(std::string(openapi_json())); }

HttpResponse get_zone(CallContext& context, const Call&) { return json_response(context.host().core->zone_json()); }

HttpResponse get_snapshot(CallContext& context, const Call&) { return json_response(snapshot_json(context.host())); }

std::string snapshot_json(const PageHost& host) {
  std::string snapshot = host.core->snapshot_json();
  if (!host.parts_json) return snapshot;
  const std::string parts = host.parts_json();
  // The file is another program's: what is no array is not shown.
  const auto read = JsonValue::parse(parts);
  if (!read || read->array() == nullptr || snapshot.empty()) return snapshot;
  snapshot.pop_back();
  return snapshot + R"(,"parts":)" + parts + "}";
}

HttpResponse get_bijection(CallContext& context, const Call&) {
  JsonWriter json;
  context.host().core->write_bijection(json);
  return json_response(json.take());
}

HttpResponse get_run(CallContext& context, const Call&) { return json_response(run_json(context)); }

std::string run_json(const CallContext& context) {
  const PageHost::Clock now = context.clock();
  JsonWriter json;
  json.begin_object().field("name", context.host().run_name).key("scenario");
  if (context.host().scenario_name.empty())
    json.null();
  else
    json.value(context.host().scenario_name);
  json.field("version", COSIVA_VERSION).key("clock").begin_object();
  json.field("kind", now.is_virtual ? "virtual" : "wall").field("running", now.running).field("speed", now.speed);
  json.field("time_ms", to_milliseconds(context.host().now().time_since_epoch()));
  json.end_object().end_object();
  return json.take();
}

HttpResponse get_traces(CallContext& context, const Call& call) {
  const auto after = number(call.request.parameter("after"), 0);
  const auto limit = number(call.request.parameter("limit"), traces_limit_default);
  if (!after || !limit) return http_error(400, "http.query", "'after' and 'limit' are whole numbers from 0 on");
  return json_response(context.host().core->traces_json(*after, std::min(*limit, traces_limit_max)));
}

HttpResponse get_trace(CallContext& context, const Call& call) {
  const auto n = number(call.arguments[0], std::nullopt);
  if (!n) return http_error(400, "http.query", "a trace is named by its running number, such as /api/v1/traces/17");
  auto found = context.host().core->trace_json(*n);
  if (!found)
    return http_error(404, "trace.not_found",
                      "there is no trace " + std::to_string(*n) + " any more, or not yet; only the last are stored");
  return json_response(std::move(*found));
}

HttpResponse get_gvs_preview(CallContext& context, const Call&) {
  if (!context.host().gvs_preview)
    return http_error(404, "gvs.no_image", "this program receives no camera's images; cosiva up --gvs starts a camera");
  // A client requests images before there are any, and a browser's console would list each 404 as an error of the page.
  const auto image = context.host().gvs_preview();
  return {image ? 200U : 204U, "image/x-portable-graymap", image ? *image : std::string{}, {}};
}

HttpResponse get_battery_curve(CallContext& context, const Call& call) {
  auto found = context.host().core->battery_curve_json(call.arguments[0]);
  if (!found)
    return http_error(404, "battery.not_found",
                      "'" + call.arguments[0].substr(0, 80) + "' has not reported its battery");
  return json_response(std::move(*found));
}

}  // namespace cosiva::app
