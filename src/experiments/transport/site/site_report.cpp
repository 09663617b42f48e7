#include "cosiva/experiments/transport/site/site_report.h"

#include <algorithm>

#include "cosiva/experiments/reporting/chart.h"
#include "cosiva/experiments/reporting/report.h"

namespace cosiva::experiments {
namespace {

/// With more zones than this only those with the longest waits are drawn; the table contains all.
constexpr std::size_t drawn_most = 40;

void add_waiting(Report& report, const std::vector<SiteMetrics::Zone>& zones) {
  auto sorted = zones;
  std::ranges::stable_sort(sorted, std::ranges::greater{}, &SiteMetrics::Zone::waiting_ratio);
  Bars bars{"waiting [% of the time]", {}};
  for (std::size_t i = 0; i < std::min(drawn_most, sorted.size()); ++i)
    bars.bars.push_back({sorted[i].name, 100.0 * sorted[i].waiting_ratio});
  report.heading("Waiting");
  report.figure(to_svg(bars), sorted.size() > drawn_most ? "The forty zones with the longest waits." : "By zone.");
}

}  // namespace

std::string to_html(const SiteMetrics& metrics, const std::string& command) {
  Report report{"Traffic on a site of " + std::to_string(metrics.zones.size()) + " zones",
                std::to_string(metrics.aivs) + " AIVs, " + std::to_string(metrics.in_transfer) +
                    " of them between two zones at the end"};
  std::vector<std::vector<std::string>> rows;
  for (const SiteMetrics::Zone& zone : metrics.zones) {
    rows.push_back({zone.name, std::to_string(zone.aivs), std::to_string(zone.jobs_due), std::to_string(zone.jobs_done),
                    std::to_string(zone.came), std::to_string(zone.left), readable(zone.distance_m / 1000.0, 2),
                    readable(100.0 * zone.waiting_ratio, 1), readable(zone.energy_wh, 1),
                    std::to_string(zone.near_misses), std::to_string(zone.collisions), std::to_string(zone.stuck)});
  }
  const SiteMetrics::Zone all = metrics.total();
  report.metadata({{std::to_string(all.jobs_done) + " of " + std::to_string(all.jobs_due), "jobs done"},
                   {std::to_string(all.came), "transfers from zone to zone"},
                   {std::to_string(all.collisions), "collisions", all.collisions > 0},
                   {std::to_string(all.near_misses), "near misses", all.near_misses > 0},
                   {std::to_string(all.stuck), "AIVs stuck at the end", all.stuck > 0}});
  add_waiting(report, metrics.zones);
  report.heading("Zones");
  report.table({"zone", "AIVs at the end", "jobs due", "done", "came", "left", "driven [km]", "waiting [%]",
                "energy [Wh]", "near misses", "collisions", "stuck"},
               rows);
  report.heading("Reproduction");
  report.verbatim(command + "\ndigest " + metrics.digest);
  return report.html();
}

}  // namespace cosiva::experiments
