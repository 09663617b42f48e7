#include "cosiva/experiments/reporting/chart.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "cosiva/base/expect.h"
#include "cosiva/base/math.h"

namespace cosiva::experiments {
namespace {

constexpr double width_px = 720.0;
constexpr double height_px = 340.0;
constexpr double left_px = 72.0;
constexpr double right_px = 16.0;
constexpr double top_px = 16.0;
constexpr double bottom_px = 52.0;
constexpr double legend_px = 22.0;
constexpr std::size_t colours = 6;
/// A line with more points than a screen has columns is thinned: of each column the lowest and the highest point
/// remain.
constexpr std::size_t points_max = 4000;

struct Range {
  double from{std::numeric_limits<double>::infinity()};
  double to{-std::numeric_limits<double>::infinity()};
  void take(double value) {
    if (!std::isfinite(value)) return;
    from = std::min(from, value);
    to = std::max(to, value);
  }
};

Range is_steady(Range range, const Axis& axis) {
  if (!(range.from <= range.to)) range = {axis.logarithmic ? 0.1 : 0.0, 1.0};
  if (axis.from) range.from = *axis.from;
  if (axis.to) range.to = *axis.to;
  if (axis.logarithmic && !(range.from < range.to)) range = {0.5 * range.from, 2.0 * range.from};
  if (!(range.from < range.to)) range = {range.from - 0.5, range.from + 0.5};
  return range;
}

std::vector<double> ticks_of(const Axis& axis, const Range& range, int wanted) {
  return axis.logarithmic ? log_ticks(range.from, range.to) : ticks(range.from, range.to, wanted);
}

/// The relative position of a value between an axis's ends, in [0, 1].
double track_position(const Axis& axis, const Range& range, double value) {
  if (!axis.logarithmic) return (value - range.from) / (range.to - range.from);
  return det_log(value / range.from) / det_log(range.to / range.from);
}

bool drawable(const Axis& axis, double value) { return std::isfinite(value) && (!axis.logarithmic || value > 0.0); }

/// Maps values to positions in the drawing.
class Frame {
 public:
  Frame(const Axis& x_axis, Range x, const Axis& y_axis, Range y)
      : x_axis_{x_axis}, y_axis_{y_axis}, x_ticks_{ticks_of(x_axis, x, 8)}, y_ticks_{ticks_of(y_axis, y, 6)} {
    x_ = {x_axis.from ? x.from : x_ticks_.front(), x_axis.to ? x.to : x_ticks_.back()};
    y_ = {y_axis.from ? y.from : y_ticks_.front(), y_axis.to ? y.to : y_ticks_.back()};
  }
  [[nodiscard]] double x(double value) const {
    return left_px + track_position(x_axis_, x_, value) * (width_px - left_px - right_px);
  }
  [[nodiscard]] double y(double value) const {
    return height_px - bottom_px - track_position(y_axis_, y_, value) * (height_px - top_px - bottom_px);
  }
  [[nodiscard]] bool shows(double x_value, double y_value) const {
    return drawable(x_axis_, x_value) && drawable(y_axis_, y_value);
  }
  void draw(drawing::SvgWriter& svg) const {
    const double right = width_px - right_px;
    const double bottom = height_px - bottom_px;
    for (const double tick : y_ticks_) {
      if (tick < y_.from || tick > y_.to) continue;
      svg.shape("path").attribute("class", "grid");
      svg.attribute("d", "M" + svg.number(left_px) + " " + svg.number(y(tick)) + "H" + svg.number(right));
      svg.shape("text").at(left_px - 8.0, y(tick) + 4.0).align(drawing::TextAlign::end).text(readable(tick, 6));
    }
    for (const double tick : x_ticks_) {
      if (tick < x_.from || tick > x_.to) continue;
      svg.shape("path").attribute("class", "grid");
      svg.attribute("d", "M" + svg.number(x(tick)) + " " + svg.number(top_px) + "V" + svg.number(bottom));
      svg.shape("text").at(x(tick), bottom + 18.0).align(drawing::TextAlign::centre).text(readable(tick, 6));
    }
    svg.shape("path").attribute("class", "axis");
    svg.attribute(
        "d", "M" + svg.number(left_px) + " " + svg.number(top_px) + "V" + svg.number(bottom) + "H" + svg.number(right));
    svg.shape("text").attribute("class", "label").at(0.5 * (left_px + right), bottom + 42.0);
    svg.align(drawing::TextAlign::centre).text(x_axis_.label);
    svg.shape("text").attribute("class", "label");
    svg.attribute("transform", "translate(16 " + svg.number(0.5 * (top_px + bottom)) + ") rotate(-90)");
    svg.align(drawing::TextAlign::centre).text(y_axis_.label);
  }

 private:
  const Axis& x_axis_;
  const Axis& y_axis_;
  std::vector<double> x_ticks_;
  std::vector<double> y_ticks_;
  Range x_;
  Range y_;
};

/// Widens the shorter axis until a unit has the same length along both axes.
void equalise(Axis& x_axis, Range& x, Axis& y_axis, Range& y) {
  constexpr double margin = 1.05;
  const double across_px = width_px - left_px - right_px;
  const double up_px = height_px - top_px - bottom_px;
  const double unit_per_px = margin * std::max((x.to - x.from) / across_px, (y.to - y.from) / up_px);
  const auto widen = [&](Axis& axis, Range& range, double length_px) {
    const double centre = 0.5 * (range.from + range.to);
    const double half = 0.5 * length_px * unit_per_px;
    range.from = centre - half;
    range.to = centre + half;
    axis.from = range.from;
    axis.to = range.to;
  };
  widen(x_axis, x, across_px);
  widen(y_axis, y, up_px);
}

/// The visible part of a long line.
Series thinned(const Series& series) {
  const std::size_t n = series.x.size();
  if (n <= points_max || series.form == Series::Form::points) return series;
  Series thin{series.name, {}, {}, series.form, {}, {}, series.dashed};
  const std::size_t columns = points_max / 2;
  for (std::size_t column = 0; column < columns; ++column) {
    const auto first = series.y.begin() + static_cast<std::ptrdiff_t>(column * n / columns);
    const auto last = series.y.begin() + static_cast<std::ptrdiff_t>((column + 1) * n / columns);
    auto [low, high] = std::minmax_element(first, last);
    if (high < low) std::swap(low, high);
    for (const auto& at : {low, high}) {
      thin.x.push_back(series.x[static_cast<std::size_t>(at - series.y.begin())]);
      thin.y.push_back(*at);
    }
  }
  return thin;
}

void draw_line(drawing::SvgWriter& svg, const Frame& frame, const Series& series, const std::string& colour) {
  std::string path;
  bool on = false;
  double last_y = 0.0;
  for (std::size_t i = 0; i < series.x.size(); ++i) {
    if (!frame.shows(series.x[i], series.y[i])) {
      on = false;
      continue;
    }
    const std::string at = svg.number(frame.x(series.x[i]));
    if (on && series.form == Series::Form::steps) path += "L" + at + " " + svg.number(last_y);
    last_y = frame.y(series.y[i]);
    path += (on ? "L" : "M") + at + " " + svg.number(last_y);
    on = true;
  }
  svg.shape("path").attribute("class", "line " + colour);
  if (series.dashed) svg.attribute("stroke-dasharray", {6.0, 4.0});
  svg.attribute("d", path);
}

/// Along the upper values and back along the lower ones.
void draw_band(drawing::SvgWriter& svg, const Frame& frame, const Series& series, const std::string& colour) {
  std::string there;
  std::string back;
  for (std::size_t i = 0; i < series.low.size(); ++i) {
    if (!frame.shows(series.x[i], series.low[i]) || !frame.shows(series.x[i], series.high[i])) continue;
    const std::string at = svg.number(frame.x(series.x[i]));
    there += (there.empty() ? "M" : "L") + at + " " + svg.number(frame.y(series.high[i]));
    back.insert(0, "L" + at + " " + svg.number(frame.y(series.low[i])));
  }
  if (there.empty()) return;
  svg.shape("path").attribute("class", "bar " + colour).attribute("opacity", "0.18");
  svg.attribute("d", there + back + "Z");
}

void draw_points(drawing::SvgWriter& svg, const Frame& frame, const Series& series, const std::string& colour) {
  for (std::size_t i = 0; i < series.x.size(); ++i) {
    if (!frame.shows(series.x[i], series.y[i])) continue;
    svg.shape("circle").attribute("class", "point " + colour).attribute("cx", frame.x(series.x[i]));
    svg.attribute("cy", frame.y(series.y[i])).attribute("r", 3.0);
  }
}

void draw_legend(drawing::SvgWriter& svg, const std::vector<Series>& all) {
  double x = left_px;
  for (std::size_t i = 0; i < all.size(); ++i) {
    if (all[i].name.empty()) continue;
    svg.shape("rect").attribute("class", "bar c" + std::to_string(i)).at(x, height_px + 4.0).size(12.0, 12.0);
    svg.shape("text").at(x + 18.0, height_px + 14.0).text(all[i].name);
    x += 18.0 + 7.0 * static_cast<double>(all[i].name.size()) + 24.0;
  }
}

}  // namespace

drawing::SvgWriter begin_chart(double width, double height, std::string_view what, double font_px) {
  drawing::SvgWriter svg{1};
  svg.open("svg").attribute("class", "chart").attribute("xmlns", "http://www.w3.org/2000/svg");
  svg.attribute("role", "img").attribute("aria-label", what).attribute("viewBox", {0.0, 0.0, width, height});
  svg.attribute("font-family", "system-ui, sans-serif").attribute("font-size", font_px);
  return svg;
}

std::vector<double> ticks(double from, double to, int wanted) {
  COSIVA_EXPECT(from < to && wanted > 0);
  const double raw = (to - from) / wanted;
  COSIVA_EXPECT(raw > 1e-300 && raw < 1e300);
  double power = 1.0;
  while (power > raw) power /= 10.0;
  while (power * 10.0 <= raw) power *= 10.0;
  double step = 10.0 * power;
  for (const double round : {5.0, 2.0, 1.0})
    if (round * power >= raw * (1.0 - 1e-9)) step = round * power;
  std::vector<double> at;
  const double first = std::floor(from / step + 1e-9);
  const double last = std::ceil(to / step - 1e-9);
  for (double i = first; i <= last; i += 1.0) at.push_back(i * step);
  return at;
}

std::vector<double> log_ticks(double from, double to) {
  COSIVA_EXPECT(0.0 < from && from < to && from > 1e-300 && to < 1e300);
  double power = 1.0;
  while (power > from) power /= 10.0;
  while (power * 10.0 <= from) power *= 10.0;
  const bool many = to / from > 1e4;
  std::vector<double> all;
  for (; all.empty() || all.back() < to * (1.0 - 1e-9); power *= 10.0)
    for (const double round : {1.0, 2.0, 5.0})
      if (round == 1.0 || !many) all.push_back(round * power);
  // Of the ticks at or below `from` only the last, of those at or above `to` only the first.
  std::vector<double> at;
  for (std::size_t i = 0; i < all.size(); ++i) {
    const bool below = i + 1 < all.size() && all[i + 1] <= from * (1.0 + 1e-9);
    const bool above = i > 0 && all[i - 1] >= to * (1.0 - 1e-9);
    if (!below && !above) at.push_back(all[i]);
  }
  return at;
}

std::string to_svg(const Chart& chart) {
  COSIVA_EXPECT(chart.series.size() <= colours);
  Range x;
  Range y;
  const auto take = [&](const Series& series) {
    COSIVA_EXPECT(series.x.size() == series.y.size() && series.low.size() == series.high.size());
    COSIVA_EXPECT(series.low.empty() || series.low.size() == series.x.size());
    for (const double value : series.x)
      if (drawable(chart.x, value)) x.take(value);
    for (const auto* values : {&series.y, &series.low, &series.high})
      for (const double value : *values)
        if (drawable(chart.y, value)) y.take(value);
  };
  for (const Series& series : chart.ground) take(series);
  for (const Series& series : chart.series) take(series);
  Axis x_axis = chart.x;
  Axis y_axis = chart.y;
  x = is_steady(x, x_axis);
  y = is_steady(y, y_axis);
  if (chart.equal_scale) equalise(x_axis, x, y_axis, y);
  const Frame frame{x_axis, x, y_axis, y};
  drawing::SvgWriter svg = begin_chart(width_px, height_px + legend_px, chart.y.label + " over " + chart.x.label);
  frame.draw(svg);
  for (const Series& series : chart.ground) draw_line(svg, frame, thinned(series), "ground");
  for (std::size_t i = 0; i < chart.series.size(); ++i) {
    const std::string colour = "c" + std::to_string(i);
    draw_band(svg, frame, chart.series[i], colour);
    if (chart.series[i].form == Series::Form::points)
      draw_points(svg, frame, chart.series[i], colour);
    else
      draw_line(svg, frame, thinned(chart.series[i]), colour);
  }
  draw_legend(svg, chart.series);
  return svg.close().take();
}

std::string to_svg(const Histogram& histogram) {
  COSIVA_EXPECT(histogram.bins > 0);
  Range range;
  for (const double value : histogram.values) range.take(value);
  range = is_steady(range, histogram.x);
  std::vector<double> counts(histogram.bins, 0.0);
  const double bin = (range.to - range.from) / static_cast<double>(histogram.bins);
  for (const double value : histogram.values) {
    if (!(value >= range.from && value <= range.to)) continue;
    const auto at = static_cast<std::size_t>((value - range.from) / bin);
    counts[std::min(at, histogram.bins - 1)] += 1.0;
  }
  const Axis y_axis{histogram.count_label, 0.0, {}};
  const Frame frame{histogram.x, range, y_axis, {0.0, std::max(1.0, *std::ranges::max_element(counts))}};
  drawing::SvgWriter svg = begin_chart(width_px, height_px, histogram.count_label + ", " + histogram.x.label);
  frame.draw(svg);
  for (std::size_t i = 0; i < counts.size(); ++i) {
    if (counts[i] == 0.0) continue;
    const double from = range.from + bin * static_cast<double>(i);
    svg.shape("rect").attribute("class", "bar c0").at(frame.x(from) + 0.5, frame.y(counts[i]));
    svg.size(std::max(1.0, frame.x(from + bin) - frame.x(from) - 1.0), frame.y(0.0) - frame.y(counts[i]));
    svg.title(readable(from) + " … " + readable(from + bin) + ": " + readable(counts[i]));
  }
  return svg.close().take();
}

std::string to_svg(const Bars& bars) {
  constexpr double row_px = 22.0;
  constexpr double name_px = 170.0;
  constexpr double value_px = 80.0;
  double longest = 0.0;
  for (const Bars::Bar& bar : bars.bars)
    if (std::isfinite(bar.value)) longest = std::max(longest, bar.value);
  const double height = row_px * static_cast<double>(bars.bars.size()) + 30.0;
  drawing::SvgWriter svg = begin_chart(width_px, height, bars.label);
  double y = 4.0;
  for (const Bars::Bar& bar : bars.bars) {
    const double ratio = longest > 0.0 && std::isfinite(bar.value) ? std::max(0.0, bar.value) / longest : 0.0;
    const double length = ratio * (width_px - name_px - value_px);
    svg.shape("text").at(name_px - 8.0, y + 14.0).align(drawing::TextAlign::end).text(bar.name);
    svg.shape("rect").attribute("class", "bar c0").at(name_px, y + 3.0).size(std::max(1.0, length), row_px - 6.0);
    svg.shape("text").at(name_px + length + 8.0, y + 14.0).text(readable(bar.value));
    y += row_px;
  }
  svg.shape("text").attribute("class", "label").at(name_px, y + 16.0).text(bars.label);
  return svg.close().take();
}

}  // namespace cosiva::experiments
