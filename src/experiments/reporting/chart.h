#pragma once

#include <limits>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

/// Charts as SVG, to be put into a Report or a file of their own. Values that are no finite number are left out.
namespace cosiva::experiments {

struct Axis {
  std::string label;           ///< with its unit: "waiting [s]"
  std::optional<double> from;  ///< else as the values want it
  std::optional<double> to;
  bool logarithmic{false};  ///< only what is over 0 is drawn
};

struct Series {
  std::string name;  ///< in the legend; empty: not there
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
  std::vector<Series> series;  ///< at most as many as there are colours: 6 (checked)
  bool equal_scale{false};     ///< a map: a metre is as long along x as along y, whatever the axes ask for
  /// Lines beneath all series, all of one faint colour and in no legend, such as the ground's.
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

/// One bar each, the longest first where they are not in an order of their own.
struct Bars {
  std::string label;  ///< of the values, with their unit
  struct Bar {
    std::string name;
    double value;
  };
  std::vector<Bar> bars;
};
[[nodiscard]] std::string to_svg(const Bars& bars);

/// Round values of an axis, evenly apart by 1, 2 or 5 times a power of ten; from at or below `from` to at or above
/// `to`.
/// @param wanted  about so many
[[nodiscard]] std::vector<double> ticks(double from, double to, int wanted = 6);
/// Round values of a logarithmic axis: 1, 2 and 5 times powers of ten, over many decades the powers alone; from at or
/// below `from` to at or above `to`. 0 < from < to (checked).
[[nodiscard]] std::vector<double> log_ticks(double from, double to);

/// A number as people read it: at most so many digits after the point, none that tell nothing.
[[nodiscard]] std::string readable(double number, int digits = 3);
/// For HTML and SVG.
[[nodiscard]] std::string escaped(std::string_view text);

}  // namespace cosiva::experiments
