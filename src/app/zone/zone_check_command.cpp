#include "cosiva/app/zone/zone_check_command.h"

#include <algorithm>
#include <cmath>
#include <optional>

#include "cosiva/app/cli/console.h"
#include "cosiva/app/zone/opened_zone.h"
#include "cosiva/app/zone/zone_arguments.h"
#include "cosiva/app/zone/zone_report.h"
#include "cosiva/planning/layout_check/layout_problems.h"
#include "cosiva/zone/check/check.h"
#include "cosiva/zone/check/deadlock.h"
#include "cosiva/zone/layout/beacon_free.h"

namespace cosiva::app {
namespace {

/// The distances that a vehicle drives by odometry alone, and how the beacons could shorten them.
struct Stretches {
  zone::Stretch tag_free;
  std::optional<zone::Stretch> beacon_free;  ///< nothing where there are no beacons
  std::optional<zone::OriginSuggestion> origin;
};

Stretches stretches_of(const zone::TrafficZone& zone) {
  std::optional<zone::Stretch> beacon_free;
  if (zone.beacons) beacon_free = zone::longest_beacon_free(zone);
  return {zone::longest_tag_free(zone), beacon_free, zone::suggest_origin(zone)};
}

void write_stretch(JsonWriter& json, const zone::Circuit& circuit, const std::optional<zone::Stretch>& stretch) {
  if (!stretch) {
    json.null();
    return;
  }
  json.begin_object().field("length_m", stretch->length_m).field("endless", stretch->endless);
  for (const auto& [name, end] : {std::pair{"from", stretch->from}, {"to", stretch->to}}) {
    json.key(name).begin_object().field("section", circuit.part(end.section).name).field("s", end.s_m);
    json.end_object();
  }
  json.end_object();
}

std::string stretch_text(const zone::Circuit& circuit, const zone::Stretch& stretch) {
  if (stretch.endless)
    return "a loop of " + decimals(stretch.length_m, 3) + " m through " + position_text(circuit, stretch.from);
  return decimals(stretch.length_m, 3) + " m, from " + position_text(circuit, stretch.from);
}

/// A suggestion is printed only where moving the beacons shortens the distance by a tenth.
std::string origin_text(const zone::OriginSuggestion& suggestion) {
  if (!(suggestion.after_m < 0.9 * suggestion.before_m)) return {};
  return "\n    with origin = [" + decimals(suggestion.origin.x_m, 4) + ", " + decimals(suggestion.origin.y_m, 4) +
         "] it would be " + decimals(suggestion.after_m, 3) + " m";
}

void write_problem(JsonWriter& json, const zone::TrafficZone& zone, const zone::Problem& problem) {
  json.begin_object();
  json.field("severity", to_string(problem.severity));
  json.field("code", problem.code).field("section", section_name(zone.circuit, problem.position.section));
  json.field("s", problem.position.s_m)
      .field("x", problem.at.x_m)
      .field("y", problem.at.y_m)
      .field("text", problem.text);
  json.end_object();
}

void write_waypoints(JsonWriter& json, const zone::TrafficZone& zone) {
  json.begin_array();
  // The nodes that a third-party master control may send a vehicle to, in driving order along each section.
  for (const zone::Waypoint& waypoint : zone.waypoints) {
    const Pose2 X_MW = zone.circuit.pose_at(waypoint.position);
    json.begin_object().field("id", waypoint.id).field("x", X_MW.x_m).field("y", X_MW.y_m);
    json.field("heading", X_MW.heading_rad).field("section", zone.circuit.part(waypoint.position.section).name);
    json.field("s", waypoint.position.s_m).end_object();
  }
  json.end_array();
}

/// The findings of a zone: its problems, where deadlocks can occur, and what its stations make of a fleet.
struct Findings {
  explicit Findings(const zone::TrafficZone& zone)
      : problems{zone::problems(zone)}, deadlocks{zone::deadlock_spots(zone)} {
    const auto found = planning::WellFormed::examine(zone);
    layout = planning::layout_problems(zone, found);
    well_formed = zone.stations.size() > 1 && !found.obstructed() &&
                  std::ranges::all_of(found.stations(), &planning::WellFormed::Finding::reaches_another);
  }
  std::vector<zone::Problem> problems;
  std::vector<zone::Problem> deadlocks;
  std::vector<zone::Problem> layout;
  bool well_formed{false};  ///< for as many vehicles as there are stations
};

void write_problems(JsonWriter& json, const zone::TrafficZone& zone, const std::vector<zone::Problem>& problems) {
  json.begin_array();
  for (const zone::Problem& problem : problems) write_problem(json, zone, problem);
  json.end_array();
}

std::string json_of(const zone::Rtm& rtm, const Stretches& stretches, const Findings& findings) {
  const zone::TrafficZone& zone = rtm.zone();
  JsonWriter json;
  json.begin_object().field("zone", zone.name).field("good", true).field("file", rtm.configuration().origin);
  json.field("format", rtm.configuration().format);
  json.field("sections", zone.circuit.size()).field("length_m", zone.circuit.total_length_m());
  json.field("crossings", zone.crossings.size()).field("tags", zone.tags.size());
  json.field("beacons", zone.beacons ? std::uint64_t{zone.beacons->columns} * zone.beacons->rows : 0);
  json.field("stations", zone.stations.size()).field("loops", zone.loops.size()).field("starts", zone.starts.size());
  json.field("longest_tag_free_m", stretches.tag_free.length_m);
  write_stretch(json.key("tag_free"), zone.circuit, stretches.tag_free);
  write_stretch(json.key("beacon_free"), zone.circuit, stretches.beacon_free);
  json.key("suggested_origin");
  if (stretches.origin)
    json.begin_array().value(stretches.origin->origin.x_m).value(stretches.origin->origin.y_m).end_array();
  else
    json.null();
  write_problems(json.key("problems"), zone, findings.problems);
  write_problems(json.key("deadlocks"), zone, findings.deadlocks);
  write_problems(json.key("layout"), zone, findings.layout);
  json.field("well_formed", findings.well_formed);
  write_diagnostics(json.key("diagnostics"), zone.diagnostics);
  write_waypoints(json.key("waypoints"), zone);
  json.end_object();
  return json.take();
}

/// An error here is a spot where vehicles cannot do what is required; the rest of the zone is usable.
std::string verdict(std::size_t errors, std::size_t warnings) {
  if (errors + warnings == 0) return "good";
  std::string text = errors > 0 ? "can be read, but has " + counted(errors, "error") : "good";
  if (warnings > 0) text += (errors > 0 ? " and " : ", with ") + counted(warnings, "warning");
  return text;
}

std::string text_of(const zone::TrafficZone& zone, const Stretches& stretches, const Findings& findings) {
  const auto count = [&](zone::Problem::Severity severity) {
    return static_cast<std::size_t>(std::ranges::count(findings.problems, severity, &zone::Problem::severity) +
                                    std::ranges::count(findings.layout, severity, &zone::Problem::severity));
  };
  const std::vector<zone::Problem>& problems = findings.problems;
  std::string text =
      zone.name + ": " + verdict(count(zone::Problem::Severity::error), count(zone::Problem::Severity::warning));
  text += "\n  " + size_of(zone) + "\n  " + counted(zone.crossings.size(), "crossing") + ", " +
          counted(zone.waypoints.size(), "waypoint") + ", " + counted(zone.stations.size(), "station") +
          (zone.loops.empty() ? "" : ", " + counted(zone.loops.size(), "loop")) + "\n  " +
          counted(zone.tags.size(), "tag");
  text += ", the longest distance without a tag is " + stretch_text(zone.circuit, stretches.tag_free);
  if (zone.beacons) {
    text += "\n  " + counted(std::size_t{zone.beacons->columns} * zone.beacons->rows, "beacon");
    if (stretches.beacon_free)
      text += ", the longest distance without a beacon is " + stretch_text(zone.circuit, *stretches.beacon_free);
    if (stretches.origin) text += origin_text(*stretches.origin);
  }
  if (!problems.empty()) text += "\n  weak spots:";
  for (const zone::Problem& problem : problems) text += "\n    " + to_string(problem, zone);
  if (!findings.deadlocks.empty()) text += "\n  possible deadlocks:";
  for (const zone::Problem& spot : findings.deadlocks) text += "\n    " + to_string(spot, zone);
  if (!findings.layout.empty()) text += "\n  stations:";
  for (const zone::Problem& problem : findings.layout) text += "\n    " + to_string(problem, zone);
  if (findings.well_formed)
    text += "\n  well-formed for " + counted(zone.stations.size(), "vehicle") +
            ": each station can be reached and left while vehicles are stopped at all others";
  return text + report_of(zone.diagnostics, "reading it");
}

/// Lists every fault of an unusable zone, not only the first.
int refuse_zone(const ZoneArguments& arguments, const Error& first) {
  std::vector<Error> faults;
  if (const auto configuration = load_zone(arguments)) faults = zone::faults(*configuration);
  if (faults.empty()) faults.push_back(first);
  for (const Error& fault : faults) report_error(fault);
  if (!arguments.json) return exit_bad_input;
  JsonWriter json;
  json.begin_object().field("good", false).key("faults").begin_array();
  for (const Error& fault : faults)
    json.begin_object()
        .field("code", fault.code)
        .field("location", fault.location)
        .field("message", fault.message)
        .end_object();
  json.end_array().end_object();
  print(json.text());
  return exit_bad_input;
}

}  // namespace

int run_zone_check(const ZoneArguments& arguments) {
  const auto rtm = open_zone(arguments);
  if (!rtm) return refuse_zone(arguments, rtm.error());
  const Stretches stretches = stretches_of(rtm->zone());
  const Findings findings{rtm->zone()};
  print(arguments.json ? json_of(*rtm, stretches, findings) : text_of(rtm->zone(), stretches, findings));
  return exit_done;
}

}  // namespace cosiva::app
