#include "cosiva/physical/vision/residual_svg.h"

#include <algorithm>
#include <cmath>

#include "cosiva/drawing/svg/svg_writer.h"

namespace cosiva::vision {
namespace {

/// From light to dark red.
std::string colour_of(double ratio) {
  const double t = std::clamp(ratio, 0.0, 1.0);
  const auto mix = [&](double from, double to) { return std::to_string(static_cast<int>(from + t * (to - from))); };
  return "rgb(" + mix(245, 150) + "," + mix(247, 20) + "," + mix(250, 40) + ")";
}

}  // namespace

std::string residual_svg(const std::vector<FloorPoint>& points, const Calibrated& calibrated) {
  const ResidualMap& map = calibrated.calibration.uncertainty;
  const Tried& tried = calibrated.tried[calibrated.chosen];
  constexpr double room_px = 900.0;
  constexpr double margin_px = 24.0;
  constexpr double text_px = 64.0;
  const double wide_m = static_cast<double>(map.columns) * map.side_m;
  const double high_m = static_cast<double>(map.rows) * map.side_m;
  const double px = room_px / std::max(wide_m, high_m);
  const auto x_of = [&](double x_m) { return margin_px + px * (x_m - map.x0_m); };
  const auto y_of = [&](double y_m) { return margin_px + px * (high_m - (y_m - map.y0_m)); };
  double worst_m = 1e-9;
  for (const double rms : map.rms_m) worst_m = std::max(worst_m, rms);
  // An arrow of the rms is a fifth of a square long.
  const double enlarged = 0.2 * map.side_m / std::max(1e-9, tried.block.metrics.rms_m);
  const double width = px * wide_m + 2.0 * margin_px;
  const double height = px * high_m + 2.0 * margin_px + text_px;
  drawing::SvgWriter svg{2};
  const auto number = [&](double value) { return svg.number(value); };
  svg.open("svg").attribute("xmlns", "http://www.w3.org/2000/svg").attribute("class", "chart").attribute("role", "img");
  svg.attribute("aria-label", "residual map").attribute("viewBox", {0.0, 0.0, width, height});
  svg.attribute("font-family", "sans-serif").attribute("font-size", 14.0);
  for (std::size_t row = 0; row < map.rows; ++row) {
    for (std::size_t column = 0; column < map.columns; ++column) {
      const std::size_t at = row * map.columns + column;
      const double left_m = map.x0_m + map.side_m * static_cast<double>(column);
      const double top_m = map.y0_m + map.side_m * static_cast<double>(row + 1);
      svg.shape("rect").at(x_of(left_m), y_of(top_m)).size(px * map.side_m, px * map.side_m);
      svg.attribute("fill", colour_of(map.rms_m[at] / worst_m));
      if (map.points[at] == 0) svg.attribute("fill-opacity", ".4");
      svg.title(number(1e3 * map.rms_m[at]) + " mm rms, " + std::to_string(map.points[at]) + " points");
    }
  }
  svg.open("g").attribute("stroke", "#1d4e89").attribute("stroke-width", 1.0);
  for (std::size_t i = 0; i < points.size(); ++i) {
    const Point2& off = tried.block.residuals[i];
    svg.shape("path").attribute("d", "M" + number(x_of(points[i].floor.x_m)) + " " + number(y_of(points[i].floor.y_m)) +
                                         "l" + number(px * enlarged * off.x_m) + " " +
                                         number(-px * enlarged * off.y_m));
  }
  svg.close();
  svg.shape("text").at(margin_px, height - 42.0).attribute("fill", "currentColor");
  svg.text("Left-out blocks: " + number(1e3 * tried.block.metrics.rms_m) + " mm rms, " +
           number(1e3 * tried.block.metrics.max_m) +
           " mm at most. Other colour: " + number(1e3 * tried.colour.metrics.rms_m) + " mm rms, " +
           number(1e3 * tried.colour.metrics.max_m) + " mm at most.");
  svg.shape("text").at(margin_px, height - 20.0).attribute("fill", "currentColor");
  svg.text("Squares of " + number(map.side_m) + " m, darkest " + number(1e3 * worst_m) +
           " mm rms; arrows: each point's error when its block was left out, " + number(enlarged) + " times as long.");
  return svg.close().take();
}

}  // namespace cosiva::vision
