#include <algorithm>

#include "adapters/files.h"
#include "app/arguments.h"
#include "app/places.h"
#include "app/words.h"
#include "base/json_writer.h"
#include "zone/draw.h"
#include "zone/rtm/rtm.h"

namespace cosiva::app {
namespace {

/// The longest way along the circuit on which a vehicle meets no tag: how far its odometry must carry it.
double longest_tag_free_m(const zone::TrafficZone& zone) {
  const double round_m = zone.circuit.total_length_m();
  double longest_m = zone.tags.empty() ? round_m : 0.0;
  for (const zone::Tag& from : zone.tags) {
    double next_m = round_m;
    for (const zone::Tag& to : zone.tags) {
      if (&to == &from) continue;
      const auto ahead_m = zone.circuit.distance_ahead(from.place, to.place, round_m);
      if (ahead_m) next_m = std::min(next_m, *ahead_m);
    }
    longest_m = std::max(longest_m, next_m);
  }
  return longest_m;
}

Result<zone::Rtm> open_zone(const std::string& name_or_file) {
  auto configuration = load_zone(name_or_file);
  if (!configuration) return tl::unexpected(configuration.error());
  return zone::Rtm::initialise(std::move(*configuration));
}

}  // namespace

int run_zone_check(const ZoneArguments& arguments) {
  const auto rtm = open_zone(arguments.zone);
  if (!rtm) return complain(rtm.error());
  const zone::TrafficZone& zone = rtm->zone();
  const double tag_free_m = longest_tag_free_m(zone);
  if (arguments.json) {
    JsonWriter json;
    json.begin_object().field("zone", zone.name).field("file", rtm->configuration().origin);
    json.field("sections", zone.circuit.size()).field("length_m", zone.circuit.total_length_m());
    json.field("crossings", zone.crossings.size()).field("tags", zone.tags.size());
    json.field("beacons", zone.beacons ? std::uint64_t{zone.beacons->columns} * zone.beacons->rows : 0);
    json.field("stations", zone.stations.size()).field("starts", zone.starts.size());
    json.field("longest_tag_free_m", tag_free_m).key("waypoints").begin_array();
    // The nodes that a foreign master control may send a vehicle to, in driving order along each section.
    for (const zone::Waypoint& waypoint : zone.waypoints) {
      const Pose2 X_MW = zone.circuit.pose_at(waypoint.place);
      json.begin_object().field("id", waypoint.id).field("x", X_MW.x_m).field("y", X_MW.y_m);
      json.field("heading", X_MW.heading_rad).field("section", zone.circuit.part(waypoint.place.section).name);
      json.field("s", waypoint.place.s_m).end_object();
    }
    json.end_array().end_object();
    print(json.text());
    return exit_done;
  }
  const auto count = [](std::size_t n, const char* one) { return std::to_string(n) + " " + one + (n == 1 ? "" : "s"); };
  print(zone.name + ": good\n  " + count(zone.circuit.size(), "section") + ", " +
        decimals(zone.circuit.total_length_m(), 3) + " m in all\n  " + count(zone.crossings.size(), "crossing") + ", " +
        count(zone.waypoints.size(), "waypoint") + ", " + count(zone.stations.size(), "station") + "\n  " +
        count(zone.tags.size(), "tag") + ", the longest way without one is " + decimals(tag_free_m, 3) + " m");
  return exit_done;
}

int run_zone_show(const ZoneArguments& arguments) {
  const auto rtm = open_zone(arguments.zone);
  if (!rtm) return complain(rtm.error());
  const std::string svg = zone::to_svg(rtm->zone(), zone::draw(rtm->zone()));
  if (arguments.svg_file.empty() || arguments.svg_file == "-") {
    print(svg);
    return exit_done;
  }
  if (auto written = adapters::write_file(arguments.svg_file, svg); !written) return complain(written.error());
  say("drawn into " + arguments.svg_file);
  return exit_done;
}

}  // namespace cosiva::app
