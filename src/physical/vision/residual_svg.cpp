#include "cosiva/physical/vision/residual_svg.h"

#include <algorithm>
#include <cmath>

#include "cosiva/base/json_writer.h"

namespace cosiva::vision {
namespace {

std::string text_of(double number) {
  JsonWriter json;
  return json.value(std::nearbyint(number * 100.0) / 100.0).take();
}

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
  std::string svg =
      "<svg xmlns=\"http://www.w3.org/2000/svg\" class=\"chart\" role=\"img\" aria-label=\"residual map\" viewBox=\"0 "
      "0 " +
      text_of(width) + " " + text_of(height) + "\" font-family=\"sans-serif\" font-size=\"14\">\n";
  for (std::size_t row = 0; row < map.rows; ++row) {
    for (std::size_t column = 0; column < map.columns; ++column) {
      const std::size_t at = row * map.columns + column;
      const double top_m = map.y0_m + map.side_m * static_cast<double>(row + 1);
      svg += "<rect x=\"" + text_of(x_of(map.x0_m + map.side_m * static_cast<double>(column))) + "\" y=\"" +
             text_of(y_of(top_m)) + "\" width=\"" + text_of(px * map.side_m) + "\" height=\"" +
             text_of(px * map.side_m) + "\" fill=\"" + colour_of(map.rms_m[at] / worst_m) + "\"" +
             (map.points[at] == 0 ? " fill-opacity=\".4\"" : "") + "><title>" + text_of(1e3 * map.rms_m[at]) +
             " mm rms, " + std::to_string(map.points[at]) + " points</title></rect>\n";
    }
  }
  svg += "<g stroke=\"#1d4e89\" stroke-width=\"1\">\n";
  for (std::size_t i = 0; i < points.size(); ++i) {
    const Point2& off = tried.block.residuals[i];
    const double x = x_of(points[i].floor.x_m);
    const double y = y_of(points[i].floor.y_m);
    svg += "<path d=\"M" + text_of(x) + " " + text_of(y) + "l" + text_of(px * enlarged * off.x_m) + " " +
           text_of(-px * enlarged * off.y_m) + "\"/>\n";
  }
  svg += "</g>\n<text x=\"" + text_of(margin_px) + "\" y=\"" + text_of(height - 42.0) +
         "\" fill=\"currentColor\">Left-out blocks: " + text_of(1e3 * tried.block.metrics.rms_m) + " mm rms, " +
         text_of(1e3 * tried.block.metrics.max_m) +
         " mm at most. Other colour: " + text_of(1e3 * tried.colour.metrics.rms_m) + " mm rms, " +
         text_of(1e3 * tried.colour.metrics.max_m) + " mm at most.</text>\n<text x=\"" + text_of(margin_px) +
         "\" y=\"" + text_of(height - 20.0) + "\" fill=\"currentColor\">Squares of " + text_of(map.side_m) +
         " m, darkest " + text_of(1e3 * worst_m) + " mm rms; arrows: each point's error when its block was left out, " +
         text_of(enlarged) + " times as long.</text>\n</svg>\n";
  return svg;
}

}  // namespace cosiva::vision
