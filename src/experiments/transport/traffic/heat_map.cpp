#include "cosiva/experiments/transport/traffic/heat_map.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "cosiva/drawing/svg/svg_writer.h"
#include "cosiva/experiments/reporting/chart.h"

namespace cosiva::experiments {
namespace {

constexpr double map_px = 760.0;
constexpr double margin_px = 60.0;  // half a road's width, and a margin
constexpr double legend_px = 46.0;
/// With more names than these a map is unreadable: then only the crossings with the longest waits are named.
constexpr std::size_t names_max = 24;

// From rarely to always: evenly darker, so that the map is readable without colours.
constexpr std::array<drawing::Rgb, 5> scale{
    {{222, 230, 238}, {250, 214, 120}, {240, 140, 50}, {200, 50, 40}, {110, 10, 60}}};

struct Cell {
  double ratio;
  zone::SectionId section;
  double from_m;
  double to_m;
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
  void draw_name(drawing::SvgWriter& svg, zone::TrackPosition position, std::string_view name, double aside_px) const {
    const Pose2 pose = circuit_.pose_at(position);
    svg.shape("text").at(x_px(pose) + aside_px, y_px(pose) + 4.0).text(name);
  }
  void draw_cell(drawing::SvgWriter& svg, const Cell& cell) const {
    const zone::Section& section = circuit_.section(cell.section);
    const double bend = section.curvature_max_per_m() * (cell.to_m - cell.from_m);
    const int parts = std::max(1, static_cast<int>(std::ceil(bend / 0.2)));
    std::string path;
    for (int i = 0; i <= parts; ++i) {
      const Pose2 pose = section.pose_at(cell.from_m + (cell.to_m - cell.from_m) * i / parts);
      path += (i == 0 ? "M" : "L") + svg.number(x_px(pose)) + " " + svg.number(y_px(pose));
    }
    svg.shape("path").attribute("d", path);
  }

 private:
  [[nodiscard]] double x_px(const Pose2& pose) const { return (pose.x_m - low_.x_m) * px_per_m_ + margin_px; }
  [[nodiscard]] double y_px(const Pose2& pose) const { return (high_.y_m - pose.y_m) * px_per_m_ + margin_px; }
  void take(const Pose2& pose) {
    low_ = {std::min(low_.x_m, pose.x_m), std::min(low_.y_m, pose.y_m)};
    high_ = {std::max(high_.x_m, pose.x_m), std::max(high_.y_m, pose.y_m)};
  }
  const zone::Circuit& circuit_;
  Point2 low_{1e300, 1e300};
  Point2 high_{-1e300, -1e300};
  double px_per_m_{1.0};
};

void draw_legend(drawing::SvgWriter& svg, double top_px, double width_px, double most, bool stopped) {
  const double bar_px = std::min(240.0, width_px - 2.0 * margin_px);
  for (int i = 0; i < 24; ++i) {
    svg.shape("rect").at(margin_px + bar_px * i / 24.0, top_px).size(bar_px / 24.0 + 0.5, 10.0);
    svg.attribute("fill", drawing::colour_between(scale, i / 23.0));
  }
  const std::string what = stopped ? "of the time a vehicle waits here" : "of the time a vehicle is here";
  svg.shape("text").at(margin_px, top_px + 28.0).text("0 to " + readable(100.0 * most, 1) + " % " + what);
}

/// Draws crossings and stations, so that the table's rows can be found on the map.
void draw_names(drawing::SvgWriter& svg, const Map& map, const zone::TrafficZone& zone, const TrafficMetrics& metrics) {
  const auto open = [&]() -> drawing::SvgWriter& {
    svg.open("g").attribute("fill", "#14202b").attribute("stroke", "#fff").attribute("stroke-width", 3.0);
    return svg.attribute("paint-order", "stroke").attribute("font-size", 12.0);
  };
  open().align(drawing::TextAlign::centre);
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
    map.draw_name(svg, {span.section, 0.5 * (span.from_m + span.to_m)}, zone.crossings[x].name, 0.0);
  }
  svg.close();
  open();
  if (zone.stations.size() <= names_max)
    for (const zone::Station& station : zone.stations) map.draw_name(svg, station.position, station.name, 14.0);
  svg.close();
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
      cells.push_back({ratio, id, from * of_section.length_m, (from + 1.0) * of_section.length_m});
    }
  }
  // A cell that several sections cover shows the largest of their values.
  std::ranges::stable_sort(cells, {}, &Cell::ratio);
  const double width = std::max(map.width_px(), 320.0);
  const double line_px = std::max(2.5, 0.9 * zone.vehicle.width_m * map.px_per_m());
  drawing::SvgWriter svg = begin_chart(width, map.height_px() + legend_px, "heat map of " + zone.name, 13.0);
  svg.attribute("fill", "none").attribute("stroke-width", line_px);
  for (const Cell& cell : cells) {
    map.draw_cell(svg, cell);
    svg.attribute("stroke", drawing::colour_between(scale, most > 0.0 ? cell.ratio / most : 0.0));
    svg.title(readable(100.0 * cell.ratio, 2) + " %");
  }
  draw_names(svg, map, zone, metrics);
  svg.open("g").attribute("stroke", "none");
  draw_legend(svg, map.height_px(), width, most, stopped);
  return svg.close().close().take();
}

}  // namespace cosiva::experiments
