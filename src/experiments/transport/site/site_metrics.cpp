#include "cosiva/experiments/transport/site/site_metrics.h"

#include <algorithm>

#include "cosiva/experiments/reporting/chart.h"

namespace cosiva::experiments {
namespace {

/// With more zones than this the text contains only their number.
constexpr std::size_t listed_most = 24;

}  // namespace

bool SiteMetrics::good() const {
  return std::ranges::all_of(zones, [](const Zone& zone) { return zone.collisions == 0 && zone.stuck == 0; });
}

SiteMetrics::Zone SiteMetrics::total() const {
  Zone all;
  for (const Zone& zone : zones) {
    all.jobs_due += zone.jobs_due;
    all.jobs_done += zone.jobs_done;
    all.came += zone.came;
    all.distance_m += zone.distance_m;
    all.energy_wh += zone.energy_wh;
    all.near_misses += zone.near_misses;
    all.collisions += zone.collisions;
    all.stuck += zone.stuck;
  }
  return all;
}

void write_json(JsonWriter& json, const SiteMetrics& metrics) {
  json.begin_object().field("aivs", metrics.aivs).field("in_transfer", metrics.in_transfer);
  json.field("vehicle_steps", metrics.vehicle_steps).field("digest", metrics.digest);
  const SiteMetrics::Zone all = metrics.total();
  json.field("jobs_due", all.jobs_due).field("jobs_done", all.jobs_done).field("transferPoints", all.came);
  json.field("distance_m", all.distance_m).field("energy_wh", all.energy_wh);
  json.field("near_misses", all.near_misses).field("collisions", all.collisions).field("stuck", all.stuck);
  json.key("zones").begin_array();
  for (const SiteMetrics::Zone& zone : metrics.zones) {
    json.begin_object().field("name", zone.name).field("aivs", zone.aivs);
    json.field("jobs_due", zone.jobs_due).field("jobs_done", zone.jobs_done);
    json.field("came", zone.came).field("left", zone.left).field("distance_m", zone.distance_m);
    json.field("waiting_ratio", zone.waiting_ratio).field("energy_wh", zone.energy_wh);
    json.field("near_misses", zone.near_misses)
        .field("collisions", zone.collisions)
        .field("stuck", zone.stuck)
        .end_object();
  }
  json.end_array().end_object();
}

std::string to_text(const SiteMetrics& metrics) {
  std::string text;
  const SiteMetrics::Zone all = metrics.total();
  for (const SiteMetrics::Zone& zone : metrics.zones) {
    if (metrics.zones.size() > listed_most) break;
    text += "  " + zone.name + ": " + std::to_string(zone.aivs) + " AIVs at the end, " +
            std::to_string(zone.jobs_done) + " jobs done (" + std::to_string(zone.jobs_due) + " due here), " +
            std::to_string(zone.came) + " came, " + std::to_string(zone.left) + " left, waiting " +
            readable(100.0 * zone.waiting_ratio, 1) + " %\n";
  }
  return std::to_string(metrics.zones.size()) + (metrics.zones.size() == 1 ? " zone, " : " zones, ") +
         std::to_string(metrics.aivs) + " AIVs (" + std::to_string(metrics.in_transfer) +
         " in transfer now): " + std::to_string(all.jobs_done) + " of " + std::to_string(all.jobs_due) +
         " jobs done, " + std::to_string(all.came) + " transfers, " + readable(all.distance_m / 1000.0, 1) + " km, " +
         readable(all.energy_wh, 0) + " Wh, " + std::to_string(all.collisions) + " collisions, " +
         std::to_string(all.near_misses) + " near misses, " + std::to_string(all.stuck) + " stuck\n" + text;
}

}  // namespace cosiva::experiments
