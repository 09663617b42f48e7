#include "cosiva/app/agent/surface_svg.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "cosiva/drawing/svg/svg_writer.h"

namespace cosiva::app {
namespace {

constexpr double width_px = 960.0;
constexpr double plot_left = 96.0;
constexpr double plot_top = 108.0;
constexpr double plot_width = 640.0;
constexpr double plot_height = 480.0;
constexpr double height_px = 700.0;
/// Shades between lowest and highest: more would only make the file longer.
constexpr int shades = 48;
constexpr const char* ink = "#1d2730";
constexpr const char* pale_ink = "#44525f";

/// From slow to fast; the colours also differ in lightness.
constexpr std::array<drawing::Rgb, 4> colours{{{75, 45, 110}, {50, 105, 155}, {85, 175, 150}, {245, 225, 120}}};

class Image {
 public:
  explicit Image(const Surface& surface) : surface_{surface} {}

  std::string draw() {
    svg_.open("svg").attribute("xmlns", "http://www.w3.org/2000/svg");
    svg_.attribute("viewBox", {0.0, 0.0, width_px, height_px}).size(width_px, height_px);
    svg_.attribute("font-family", "system-ui, 'Segoe UI', 'DejaVu Sans', sans-serif");
    svg_.shape("rect").attribute("width", "100%").attribute("height", "100%").attribute("fill", "#fbfcfd");
    head();
    fields();
    if (surface_.is_speed()) {
      for (const double level : {0.5, 1.5, 2.5}) contour(level);
    } else if (surface_.of == "go") {
      contour(0.5);
    }
    axes();
    legend();
    svg_.close();
    return svg_.take();
  }

 private:
  drawing::SvgWriter& text(double x, double y, double size, const char* fill) {
    return svg_.shape("text").at(x, y).attribute("font-size", size).attribute("fill", fill);
  }
  [[nodiscard]] std::string number(double value) const { return svg_.number(value); }

  static std::string titled(aiv::AgentInput input) {
    const aiv::AgentInputInfo& metadata = aiv::metadata_of(input);
    return std::string(metadata.name) + (metadata.unit.empty() ? "" : " [" + std::string(metadata.unit) + "]");
  }

  /// Prints an instruction as its name.
  [[nodiscard]] std::string formatted(aiv::AgentInput input, double value) const {
    if (input != aiv::AgentInput::instruction) return number(value);
    if (value > 3.5) return "none";
    return std::string(to_string(aiv::nearest_profile(value, std::nullopt)));
  }

  void head() {
    text(plot_left, 40.0, 22.0, ink).attribute("font-weight", "600");
    svg_.text((surface_.is_speed() ? std::string("Speed") : surface_.of) + " over " +
              std::string(aiv::metadata_of(surface_.x.input).name) + " and " +
              std::string(aiv::metadata_of(surface_.y.input).name));
    std::string fixed;
    for (const aiv::AgentInput input : surface_.requested) {
      if (input == surface_.x.input || input == surface_.y.input) continue;
      const double value = surface_.others[static_cast<std::size_t>(input)];
      fixed +=
          (fixed.empty() ? "with " : ", ") + std::string(aiv::metadata_of(input).name) + " " + formatted(input, value);
    }
    text(plot_left, 66.0, 13.0, pale_ink).text(fixed);
  }

  [[nodiscard]] double x_px(double column) const {
    return plot_left + column / static_cast<double>(surface_.x.values.size() - 1) * plot_width;
  }
  [[nodiscard]] double y_px(double row) const {
    return plot_top + plot_height - row / static_cast<double>(surface_.y.values.size() - 1) * plot_height;
  }
  [[nodiscard]] int shade(double level) const {
    return static_cast<int>(std::lround((level - surface_.low) / (surface_.high - surface_.low) * shades));
  }

  /// Draws a field around each point; equal neighbours in a row become one rectangle.
  void fields() {
    svg_.open("svg").at(plot_left, plot_top).size(plot_width, plot_height);
    svg_.attribute("viewBox", {plot_left, plot_top, plot_width, plot_height});
    svg_.attribute("shape-rendering", "crispEdges");
    const std::size_t columns = surface_.x.values.size();
    const double half_px = 0.5 * plot_height / static_cast<double>(surface_.y.values.size() - 1);
    for (std::size_t row = 0; row < surface_.y.values.size(); ++row) {
      for (std::size_t from = 0; from < columns;) {
        const int here = shade(surface_.at(from, row));
        std::size_t to = from + 1;
        while (to < columns && shade(surface_.at(to, row)) == here) ++to;
        const double left = x_px(static_cast<double>(from) - 0.5);
        svg_.shape("rect").at(left, y_px(static_cast<double>(row)) - half_px);
        svg_.size(x_px(static_cast<double>(to) - 0.5) - left, 2.0 * half_px);
        svg_.attribute("fill", drawing::colour_between(colours, static_cast<double>(here) / shades));
        from = to;
      }
    }
    svg_.close();
  }

  /// Draws where the level is crossed, field by field: each edge of a field whose ends lie on both sides of the level
  /// gives a point.
  void contour(double level) {
    std::string path;
    for (std::size_t row = 0; row + 1 < surface_.y.values.size(); ++row) {
      for (std::size_t column = 0; column + 1 < surface_.x.values.size(); ++column) {
        std::array<std::string, 4> points;
        std::size_t count = 0;
        const auto sample = [&](std::size_t c0, std::size_t r0, std::size_t c1, std::size_t r1) {
          const double a = surface_.at(c0, r0) - level;
          const double b = surface_.at(c1, r1) - level;
          if ((a < 0.0) == (b < 0.0)) return;
          const double ratio = a / (a - b);
          const auto between = [&](std::size_t from, std::size_t to) {
            return static_cast<double>(from) + ratio * (static_cast<double>(to) - static_cast<double>(from));
          };
          points[count++] = number(x_px(between(c0, c1))) + " " + number(y_px(between(r0, r1)));
        };
        sample(column, row, column + 1, row);
        sample(column + 1, row, column + 1, row + 1);
        sample(column + 1, row + 1, column, row + 1);
        sample(column, row + 1, column, row);
        for (std::size_t i = 0; i + 1 < count; i += 2) path += "M" + points[i] + "L" + points[i + 1];
      }
    }
    if (path.empty()) return;
    const auto stroke = [&](const char* colour, double width) {
      svg_.shape("path").attribute("d", path).attribute("fill", "none").attribute("stroke", colour);
      svg_.attribute("stroke-width", width).attribute("stroke-linecap", "round");
    };
    stroke("#ffffff", 5.0);
    stroke(ink, 2.0);
  }

  void axes() {
    svg_.shape("rect").at(plot_left, plot_top).size(plot_width, plot_height);
    svg_.attribute("fill", "none").attribute("stroke", ink);
    constexpr int ticks = 4;
    const double bottom = plot_top + plot_height;
    const auto value = [](const Surface::Axis& axis, double ratio) {
      return axis.values.front() + ratio * (axis.values.back() - axis.values.front());
    };
    for (int i = 0; i <= ticks; ++i) {
      const double ratio = static_cast<double>(i) / ticks;
      const double x = plot_left + ratio * plot_width;
      const double y = bottom - ratio * plot_height;
      svg_.shape("path").attribute(
          "d", "M" + number(x) + " " + number(bottom) + "v6M" + number(plot_left) + " " + number(y) + "h-6");
      svg_.attribute("stroke", ink);
      text(x, bottom + 24.0, 14.0, pale_ink).align(drawing::TextAlign::centre).text(number(value(surface_.x, ratio)));
      text(plot_left - 12.0, y + 5.0, 14.0, pale_ink).align(drawing::TextAlign::end);
      svg_.text(number(value(surface_.y, ratio)));
    }
    text(plot_left + 0.5 * plot_width, bottom + 54.0, 15.0, ink).align(drawing::TextAlign::centre);
    svg_.text(titled(surface_.x.input));
    text(0.0, 0.0, 15.0, ink).align(drawing::TextAlign::centre);
    svg_.attribute("transform", "translate(30 " + number(plot_top + 0.5 * plot_height) + ") rotate(-90)");
    svg_.text(titled(surface_.y.input));
  }

  void legend() {
    constexpr double left = plot_left + plot_width + 32.0;
    for (int i = 0; i <= shades; ++i) {
      const double step = plot_height / (shades + 1.0);
      svg_.shape("rect").at(left, plot_top + plot_height - (i + 1.0) * step).size(24.0, step + 0.5);
      svg_.attribute("fill", drawing::colour_between(colours, static_cast<double>(i) / shades));
    }
    const auto fiducial = [&](double ratio, const std::string& phrase) {
      text(left + 34.0, plot_top + (1.0 - ratio) * plot_height + 5.0, 14.0, pale_ink).text(phrase);
    };
    if (surface_.is_speed()) {
      constexpr std::array<const char*, 4> names{"0 stop", "1 slow", "2 medium", "3 fast"};
      for (std::size_t i = 0; i < names.size(); ++i) fiducial(static_cast<double>(i) / 3.0, names[i]);
      text(left, plot_top - 16.0, 13.0, pale_ink).text("lines: another profile");
      return;
    }
    for (const double ratio : {0.0, 0.25, 0.5, 0.75, 1.0})
      fiducial(ratio, number(surface_.low + ratio * (surface_.high - surface_.low)));
    if (surface_.of == "go") text(left, plot_top - 16.0, 13.0, pale_ink).text("line: goes from here");
  }

  const Surface& surface_;
  drawing::SvgWriter svg_{2};
};

}  // namespace

std::string to_svg(const Surface& surface) { return Image{surface}.draw(); }

}  // namespace cosiva::app
