#include "cosiva/experiments/transport/traffic/heat_map.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "cosiva/experiments/reporting/chart.h"

namespace cosiva::experiments {
namespace {

constexpr double map_px = 760.0;
constexpr double margin_px = 60.0;  // half a road's width, and a margin
constexpr double legend_px = 46.0;
/// With more names than these a map is unreadable: then only the crossings with the longest waits are named.
constexpr std::size_t names_max = 24;

struct Colour {
  double red, green, blue;
};
// From rarely to always: evenly darker, so that the map is readable without colours.
constexpr std::array<Colour, 5> scale{{{222, 230, 238}, {250, 214, 120}, {240, 140, 50}, {200, 50, 40}, {110, 10, 60}}};

std::string colour_of(double ratio) {
  const double at = std::clamp(ratio, 0.0, 1.0) * (scale.size() - 1.0);
  const auto low = std::min(static_cast<std::size_t>(at), scale.size() - 2);
  const double rest = at - static_cast<double>(low);
  const auto mix = [rest](double a, double b) { return std::to_string(std::lround(a + rest * (b - a))); };
  return "rgb(" + mix(scale[low].red, scale[low + 1].red) + "," + mix(scale[low].green, scale[low + 1].green) + "," +
         mix(scale[low].blue, scale[low + 1].blue) + ")";
}

struct Cell {
  double ratio;
  std::string path;
};

class Map {
 public:
  explicit Map(const zone::TrafficZone& zone) : circuit_{zone.circuit} {
    for (zone::SectionId id = 0; id < circuit_.size(); ++id)
      for (double part = 0.0; part <= 1.0; part += 1.0 / 32.0)
        take(circuit_.section(id).pose_at(part * circuit_.section(id).length_m()));
    const double longest = std::max({high_.x_m - low_.x_m, high_.y_m - low_.y_m, 1e-3});
    px_per_m_ = map_px / longest;
  }
  [[nodiscard]] double width_px() const { return (high_.x_m - low_.x_m) * px_per_m_ + 2.0 * margin_px; }
  [[nodiscard]] double height_px() const { return (high_.y_m - low_.y_m) * px_per_m_ + 2.0 * margin_px; }
  [[nodiscard]] double px_per_m() const { return px_per_m_; }
  [[nodiscard]] std::string name(zone::TrackPosition position, const std::string& text, double aside_px) const {
    const Pose2 pose = circuit_.pose_at(position);
    return "<text x=\"" + readable((pose.x_m - low_.x_m) * px_per_m_ + margin_px + aside_px, 1) + "\" y=\"" +
           readable((high_.y_m - pose.y_m) * px_per_m_ + margin_px + 4.0, 1) + "\">" + escaped(text) + "</text>";
  }
  [[nodiscard]] std::string path(zone::SectionId section, double from_m, double to_m) const {
    const double bend = circuit_.section(section).curvature_max_per_m() * (to_m - from_m);
    const int parts = std::max(1, static_cast<int>(std::ceil(bend / 0.2)));
    std::string path;
    for (int i = 0; i <= parts; ++i) {
      const Pose2 pose = circuit_.section(section).pose_at(from_m + (to_m - from_m) * i / parts);
      path += (i == 0 ? "M" : "L") + readable((pose.x_m - low_.x_m) * px_per_m_ + margin_px, 1) + " " +
              readable((high_.y_m - pose.y_m) * px_per_m_ + margin_px, 1);
    }
    return path;
  }

 private:
  void take(const Pose2& pose) {
    low_ = {std::min(low_.x_m, pose.x_m), std::min(low_.y_m, pose.y_m)};
    high_ = {std::max(high_.x_m, pose.x_m), std::max(high_.y_m, pose.y_m)};
  }
  const zone::Circuit& circuit_;
  Point2 low_{1e300, 1e300};
  Point2 high_{-1e300, -1e300};
  double px_per_m_{1.0};
};

std::string legend(double top_px, double width_px, double most, bool stopped) {
  std::string svg;
  const double bar_px = std::min(240.0, width_px - 2.0 * margin_px);
  for (int i = 0; i < 24; ++i) {
    svg += "<rect x=\"" + readable(margin_px + bar_px * i / 24.0, 1) + "\" y=\"" + readable(top_px, 1) + "\" width=\"" +
           readable(bar_px / 24.0 + 0.5, 1) + "\" height=\"10\" fill=\"" + colour_of(i / 23.0) + "\"/>";
  }
  const std::string what = stopped ? "of the time a vehicle waits here" : "of the time a vehicle is here";
  svg += "<text x=\"" + readable(margin_px, 1) + "\" y=\"" + readable(top_px + 28.0, 1) + "\">0 to " +
         readable(100.0 * most, 1) + " % " + what + "</text>";
  return svg;
}

/// Draws crossings and stations, so that the table's rows can be found on the map.
std::string names(const Map& map, const zone::TrafficZone& zone, const TrafficMetrics& metrics) {
  std::string svg =
      "<g fill=\"#14202b\" stroke=\"#fff\" stroke-width=\"3\" paint-order=\"stroke\" font-size=\"12\" "
      "text-anchor=\"middle\">";
  std::vector<std::size_t> crossings;
  for (std::size_t x = 0; x < std::min(zone.crossings.size(), metrics.crossings.size()); ++x)
    if (!zone.crossings[x].spans.empty()) crossings.push_back(x);
  if (crossings.size() > names_max) {
    std::ranges::stable_sort(crossings, std::ranges::greater{},
                             [&](std::size_t x) { return metrics.crossings[x].waiting_s; });
    crossings.resize(names_max);
  }
  for (const std::size_t x : crossings) {
    const zone::CrossingSpan& span = zone.crossings[x].spans.front();
    svg += map.name({span.section, 0.5 * (span.from_m + span.to_m)}, zone.crossings[x].name, 0.0);
  }
  svg += "</g><g fill=\"#14202b\" stroke=\"#fff\" stroke-width=\"3\" paint-order=\"stroke\" font-size=\"12\">";
  if (zone.stations.size() <= names_max)
    for (const zone::Station& station : zone.stations) svg += map.name(station.position, station.name, 14.0);
  return svg + "</g>";
}

}  // namespace

std::string heat_map(const zone::TrafficZone& zone, const TrafficMetrics& metrics, bool stopped) {
  const Map map{zone};
  std::vector<Cell> cells;
  double most = 0.0;
  for (zone::SectionId id = 0; id < metrics.cells.size(); ++id) {
    const auto& of_section = metrics.cells[id];
    const auto& seconds = stopped ? of_section.stopped_s : of_section.occupied_s;
    for (std::size_t i = 0; i < seconds.size(); ++i) {
      const double ratio = metrics.duration_s > 0.0 ? seconds[i] / metrics.duration_s : 0.0;
      most = std::max(most, ratio);
      const auto from = static_cast<double>(i);
      cells.push_back({ratio, map.path(id, from * of_section.length_m, (from + 1.0) * of_section.length_m)});
    }
  }
  // A cell that several sections cover shows the largest of their values.
  std::ranges::stable_sort(cells, {}, &Cell::ratio);
  const double width = std::max(map.width_px(), 320.0);
  const double line_px = std::max(2.5, 0.9 * zone.vehicle.width_m * map.px_per_m());
  std::string svg = "<svg class=\"chart\" xmlns=\"http://www.w3.org/2000/svg\" role=\"img\" aria-label=\"heat map of " +
                    escaped(zone.name) + "\" viewBox=\"0 0 " + readable(width, 1) + " " +
                    readable(map.height_px() + legend_px, 1) +
                    "\" font-family=\"system-ui, sans-serif\" font-size=\"13\" fill=\"none\" stroke-width=\"" +
                    readable(line_px, 1) + "\">";
  for (const Cell& cell : cells) {
    svg += "<path d=\"" + cell.path + "\" stroke=\"" + colour_of(most > 0.0 ? cell.ratio / most : 0.0) + "\"><title>" +
           readable(100.0 * cell.ratio, 2) + " %</title></path>";
  }
  svg += names(map, zone, metrics);
  return svg + "<g stroke=\"none\">" + legend(map.height_px(), width, most, stopped) + "</g></svg>";
}

}  // namespace cosiva::experiments
