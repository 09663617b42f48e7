#pragma once

#include <limits>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "cosiva/drawing/svg/svg_writer.h"

/// Charts as SVG, for a Report or a separate file. Values that are not finite are left out.
namespace cosiva::experiments {

struct Axis {
  std::string label;           ///< with its unit: "waiting [s]"
  std::optional<double> from;  ///< else derived from the values
  std::optional<double> to;
  bool logarithmic{false};  ///< only values over 0 are drawn
};

struct Series {
  std::string name;  ///< in the legend; empty: not in the legend
  std::vector<double> x;
  std::vector<double> y;  ///< as many as x (checked)
  enum class Form { line, points, steps };
  Form form{Form::line};
  std::vector<double> low{};   ///< with `high`: a band about the line, such as an interval; as many as x, or none
  std::vector<double> high{};  ///< (checked)
  bool dashed{false};
};

struct Chart {
  Axis x;
  Axis y;
  std::vector<Series> series;  ///< at most one per available colour: 6 (checked)
  bool equal_scale{false};     ///< a map: a metre has the same length along x and y, whatever the axes' ranges
  /// Lines beneath all series, in one faint colour and without a legend, such as those of the ground.
  std::vector<Series> ground{};
};
[[nodiscard]] std::string to_svg(const Chart& chart);

/// How often values fall into bins of equal width.
struct Histogram {
  Axis x;
  std::string count_label{"how often"};
  std::vector<double> values;
  std::size_t bins{30};
};
[[nodiscard]] std::string to_svg(const Histogram& histogram);

/// One bar each, the longest first where the bars have no order of their own.
struct Bars {
  std::string label;  ///< of the values, with their unit
  struct Bar {
    std::string name;
    double value;
  };
  std::vector<Bar> bars;
};
[[nodiscard]] std::string to_svg(const Bars& bars);

/// Round values of an axis, evenly spaced by 1, 2 or 5 times a power of ten; from at or below `from` to at or above
/// `to`.
/// @param wanted  approximate number
[[nodiscard]] std::vector<double> ticks(double from, double to, int wanted = 6);
/// Round values of a logarithmic axis: 1, 2 and 5 times powers of ten, over many decades the powers alone; from at or
/// below `from` to at or above `to`. 0 < from < to (checked).
[[nodiscard]] std::vector<double> log_ticks(double from, double to);

/// The start of a chart of this size in pixels, in the style of a Report's page: the caller adds its parts and closes
/// it.
/// @param what  what the chart shows, for screen readers
[[nodiscard]] drawing::SvgWriter begin_chart(double width, double height, std::string_view what, double font_px = 12.0);

using drawing::escaped;
using drawing::readable;

}  // namespace cosiva::experiments
