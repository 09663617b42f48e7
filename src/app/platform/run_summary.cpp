#include "cosiva/app/platform/run_summary.h"

#include <algorithm>

#include "cosiva/app/cli/console.h"
#include "cosiva/base/json_text.h"
#include "cosiva/base/json_value.h"
#include "cosiva/base/json_writer.h"

namespace cosiva::app {
namespace {

std::string millis(const JsonValue& metrics, std::string_view of, double scale, const char* unit) {
  const JsonValue* spread = metrics.find(of);
  const auto p99 = spread == nullptr ? std::nullopt : spread->number("p99");
  return p99 ? decimals(*p99 * scale, 1) + unit : std::string("unknown");
}

/// The metrics of virtual objects, in a separate line; empty where there were none.
std::string augmented(const JsonValue& bijection) {
  const double aivs = bijection.number("augmented").value_or(0.0);
  const JsonValue* effects = bijection.find("effects");
  const auto count = [&](std::string_view of) {
    const JsonValue* spread = effects == nullptr ? nullptr : effects->find(of);
    return spread == nullptr ? 0.0 : spread->number("count").value_or(0.0);
  };
  if (aivs == 0.0 && count("perceived_ms") == 0.0 && count("shown_ms") == 0.0) return {};
  std::string text = "\n" + decimals(aivs, 0) + " virtual AIVs";
  const auto figure = [&](std::string_view of, const char* phrase) {
    if (count(of) > 0.0) text += ", " + decimals(count(of), 0) + " times " + phrase + millis(*effects, of, 1.0, " ms");
  };
  figure("perceived_ms", "perceived in p99 ");
  figure("brakes_ms", "braked for in p99 ");
  figure("shown_ms", "an obstacle shown in p99 ");
  return text;
}

/// In a separate line where the delay is significant: then the metrics also reflect the machine.
std::string late(const JsonValue& bijection) {
  constexpr double significant_ms = 20.0;
  const JsonValue* spread = bijection.find("late_ms");
  if (spread == nullptr || spread->number("p99").value_or(0.0) < significant_ms) return {};
  return "\nthis machine was busy or stalled: the server woke up to " +
         decimals(spread->number("max").value_or(0.0), 0) + " ms late (p99 " +
         millis(bijection, "late_ms", 1.0, " ms") + "), which is included in these metrics";
}

/// "matched 4 of 4". Third-party vehicles may use the same broker: the total counts all vehicles that are present on
/// either side, and the requested vehicles that are on neither.
std::string matched_text(const JsonValue& bijection, std::uint32_t requested_for) {
  const auto counted = [&](const char* what) { return bijection.number(what).value_or(0.0); };
  const double present = counted("physical") + counted("virtual") - counted("matched");
  const double wanted = requested_for;
  std::string text = "matched " + decimals(counted("matched"), 0) + " of " + decimals(std::max(present, wanted), 0);
  if (present > wanted) text += " (" + decimals(present - wanted, 0) + " more than requested)";
  return text;
}

std::string deadlocks_text(const JsonValue* deadlocks) {
  if (deadlocks == nullptr) return {};
  const double detected = deadlocks->number("detected").value_or(0.0);
  const double open = deadlocks->number("open").value_or(0.0);
  return ", " + decimals(detected, 0) + (detected == 1.0 ? " deadlock" : " deadlocks") +
         (open > 0.0 ? " (" + decimals(open, 0) + " not resolved)" : "");
}

/// On zones with two-way tracks, where routes are planned.
std::string routes_text(const JsonValue* routes) {
  if (routes == nullptr) return {};
  return " (of a route " + decimals(routes->number("longest_wait_s").value_or(0.0), 1) + " s, 99 % up to " +
         decimals(routes->number("wait_p99_s").value_or(0.0), 0) + " s), " +
         decimals(routes->number("arrivals").value_or(0.0), 0) + " arrivals, at least " +
         decimals(routes->number("least_arrivals").value_or(0.0), 0) + " of each AIV";
}

}  // namespace

Result<RunSummary> summarise(const RunMetadata& metadata, std::string_view server_summary,
                             std::string_view plant_summary) {
  const auto server = JsonValue::parse(server_summary);
  const auto plant = JsonValue::parse(plant_summary);
  const JsonValue* bijection = server ? server->find("bijection") : nullptr;
  const JsonValue* collisions = plant ? plant->find("collisions") : nullptr;
  if (bijection == nullptr || collisions == nullptr || collisions->array() == nullptr)
    return fail("run.summary", "a part of the platform left no summary; see its log");

  RunSummary run;
  const std::size_t touched = collisions->array()->size();
  const double laps = plant->number("laps").value_or(0.0);
  const double longest_wait_s = plant->number("longest_wait_s").value_or(0.0);
  JsonWriter json;
  write_json(json.begin_object().key("bijection"), *bijection);
  json.field("aivs", metadata.aivs).field("collisions", touched).field("laps", laps);
  json.field("longest_wait_s", longest_wait_s);
  const JsonValue* routes = server->find("routes");
  if (routes != nullptr) write_json(json.key("routes"), *routes);
  const JsonValue* deadlocks = server->find("deadlocks");
  if (deadlocks != nullptr) write_json(json.key("deadlocks"), *deadlocks);
  json.field("digest", metadata.digest).field("duration_s", metadata.duration_s);
  json.field("zone", metadata.zone).field("seed", metadata.seed);
  if (!metadata.scenario.empty()) json.field("scenario", metadata.scenario);
  json.end_object();
  run.json = json.take();

  const auto counted = [&](const char* what) { return bijection->number(what).value_or(-1.0); };
  const double wanted = metadata.aivs;
  run.collided = touched > 0;
  run.deadlocked = deadlocks != nullptr && deadlocks->number("unresolved").value_or(0.0) > 0.0;
  run.all_matched = counted("matched") == wanted && counted("physical") == wanted && counted("virtual") == wanted;

  run.text = decimals(metadata.duration_s, 1) + " s on " + metadata.zone + ": " +
             matched_text(*bijection, metadata.aivs) + ", divergence p99 " +
             millis(*bijection, "divergence_m", 1e3, " mm") + ", age p99 " + millis(*bijection, "age_ms", 1.0, " ms") +
             "\n" + std::to_string(touched) + " collisions, " + decimals(laps, 0) + " laps, longest wait " +
             decimals(longest_wait_s, 1) + " s" + routes_text(routes) + deadlocks_text(deadlocks) + ", digest " +
             metadata.digest + augmented(*bijection) + late(*bijection);
  return run;
}

}  // namespace cosiva::app
