// to_svg: the drawing of a zone as a file that any browser opens.
#include "cosiva/zone/drawing/svg.h"

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>

#include "cosiva/base/expect.h"
#include "cosiva/drawing/svg/svg_writer.h"

namespace cosiva::zone {
namespace {

constexpr double image_px = 960.0;  // the longer side of the map
constexpr double margin_px = 36.0;
constexpr double head_px = 56.0;
constexpr double foot_px = 64.0;
constexpr double row_px = 24.0;   // of the legend
constexpr double bar_px = 240.0;  // the scale bar's part of the foot, with its text

// More names than this are merged into few shapes, or a browser takes minutes.
constexpr std::size_t titled_max = 5'000;

struct Style {
  std::string_view layer;
  std::string_view kind;  ///< of a layer with several kinds; empty: any
  std::string_view fill;
  std::string_view stroke;
  std::string_view name;  ///< in the legend; empty: not there
};

// Bottom to top. Colours keep a contrast of at least 3:1 with the road they lie on, and differ in lightness too.
constexpr std::array<Style, 14> styles{{
    {"road", "", "none", "#dfe5ec", ""},
    {"crossing", "", "#ffd9a0", "#e08a1e", "crossing"},
    {"closed", "", "none", "#b42318", "closed"},
    {"line", "straight", "none", "#5b6b7d", "straight"},
    {"line", "arc", "none", "#0f7f86", "arc"},
    {"line", "clothoid", "none", "#a02c8c", "clothoid"},
    {"line", "", "none", "#8797a8", ""},
    {"beacon", "", "#6d7b89", "none", "beacon"},
    {"pivot", "", "#fbfcfd", "#1d2730", "turn on the spot"},
    {"tag", "", "#2563c9", "#ffffff", "tag"},
    {"station", "charger", "#b45f06", "#ffffff", "charger"},
    {"station", "", "#2f8f5b", "#ffffff", "station"},
    {"section", "", "#44525f", "none", ""},
    {"label", "", "#44525f", "none", ""},
}};

constexpr std::size_t closed_style = 2;
static_assert(styles[closed_style].layer == "closed");

/// The first that fits: those of one kind come before those of any.
const Style* style_of(const Primitive& primitive) {
  const auto at = std::find_if(styles.begin(), styles.end(), [&](const Style& style) {
    return style.layer == primitive.layer && (style.kind.empty() || style.kind == primitive.kind);
  });
  return at == styles.end() ? nullptr : &*at;
}

constexpr double text_least_px = 4.0;

/// A ground of hundreds of metres leaves a section less than a pixel: it is drawn as wide as can still be seen.
double least_px(const Style& style) {
  if (style.layer == "road") return 4.5;
  if (style.layer == "closed") return 4.0;
  if (style.layer == "line") return 1.4;
  if (style.layer == "station" || style.layer == "tag") return 2.5;
  return 0.0;
}

/// Writes the drawing layer by layer. Invariant: the map has a scale, and room in the image.
class Svg {
 public:
  Svg(const TrafficZone& zone, const std::vector<Primitive>& primitives)
      : zone_{zone}, primitives_{primitives}, box_{bounds(primitives)} {
    const double width_m = box_.high.x_m - box_.low.x_m;
    const double height_m = box_.high.y_m - box_.low.y_m;
    px_per_m_ = image_px / std::max({width_m, height_m, 1e-9});
    by_style_.resize(styles.size());
    for (const Primitive& primitive : primitives_) {
      if (const Style* style = style_of(primitive); style != nullptr && !primitive.points.empty())
        by_style_[static_cast<std::size_t>(style - styles.data())].push_back(&primitive);
    }
    find_closed();
    // A zone narrower than its legend still gets the legend's room.
    width_px_ = std::max(width_m * px_per_m_ + 2.0 * margin_px, 760.0);
    lay_legend();
    height_px_ = height_m * px_per_m_ + 2.0 * margin_px + head_px + foot_px + (legend_rows_ - 1.0) * row_px;
    COSIVA_EXPECT(px_per_m_ > 0.0 && width_px_ > 0.0 && height_px_ > 0.0);
    left_px_ = 0.5 * (width_px_ - width_m * px_per_m_);
  }

  std::string write() {
    head();
    for (std::size_t i = 0; i < styles.size(); ++i)
      if (!by_style_[i].empty()) layer(styles[i], by_style_[i]);
    foot();
    svg_.close();
    return svg_.take();
  }

 private:
  [[nodiscard]] double x_of(Point2 p) const { return left_px_ + (p.x_m - box_.low.x_m) * px_per_m_; }
  [[nodiscard]] double y_of(Point2 p) const { return head_px + margin_px + (box_.high.y_m - p.y_m) * px_per_m_; }
  [[nodiscard]] std::string xy(Point2 p) const { return svg_.number(x_of(p)) + "," + svg_.number(y_of(p)); }

  drawing::SvgWriter& text(double x_px, double y_px, double size_px) {
    return svg_.shape("text").at(x_px, y_px).attribute("font-size", size_px);
  }

  void head() {
    svg_.open("svg").attribute("xmlns", "http://www.w3.org/2000/svg");
    svg_.attribute("viewBox", {0.0, 0.0, width_px_, height_px_}).size(width_px_, height_px_);
    svg_.attribute("font-family", "system-ui, 'Segoe UI', 'DejaVu Sans', sans-serif").title(zone_.name);
    svg_.shape("rect").attribute("width", "100%").attribute("height", "100%").attribute("fill", "#fbfcfd");
    text(margin_px, 40.0, 24.0).attribute("font-weight", "600").attribute("fill", "#1d2730").text(zone_.name);
    const auto count = [](std::size_t n, std::string_view one) {
      return std::to_string(n) + " " + std::string(one) + (n == 1 ? "" : "s");
    };
    text(width_px_ - margin_px, 40.0, 14.0).align(drawing::TextAlign::end).attribute("fill", "#5d6b78");
    svg_.text(count(zone_.circuit.size(), "section") + ", " + svg_.number(zone_.circuit.total_length_m()) + " m, " +
              count(zone_.crossings.size(), "crossing") + ", " + count(zone_.tags.size(), "tag"));
  }

  /// The roads of closed sections, by their names: they are drawn once more, hatched.
  void find_closed() {
    std::vector<std::string_view> names;
    for (const SectionId id : zone_.closed) names.push_back(zone_.circuit.part(id).name);
    std::sort(names.begin(), names.end());
    for (const Primitive& primitive : primitives_) {
      if (primitive.layer == "road" && std::binary_search(names.begin(), names.end(), primitive.label))
        by_style_[closed_style].push_back(&primitive);
    }
  }

  void layer(const Style& style, const std::vector<const Primitive*>& shapes) {
    std::string id{style.layer};
    if (!style.kind.empty()) id.append("-").append(style.kind);
    svg_.open("g").attribute("id", id).attribute("fill", style.fill).attribute("stroke", style.stroke);
    svg_.attribute("stroke-linejoin", "round");
    if (shapes.size() > titled_max && shapes.front()->shape == Primitive::Shape::polyline) {
      gathered(style, shapes);
    } else {
      for (const Primitive* primitive : shapes) shape(style, *primitive);
    }
    svg_.close();
  }

  /// Many lines as one path, without their names.
  void gathered(const Style& style, const std::vector<const Primitive*>& shapes) {
    std::string path;
    for (const Primitive* primitive : shapes) {
      char command = 'M';
      for (const Point2& p : primitive->points) {
        path += command;
        path += xy(p);
        command = 'L';
      }
    }
    svg_.shape("path").attribute("stroke-width", std::max({shapes.front()->size_m * px_per_m_, least_px(style), 0.05}));
    svg_.attribute("stroke-linecap", "round").attribute("d", path);
  }

  void shape(const Style& style, const Primitive& primitive) {
    const double size_px = std::max(primitive.size_m * px_per_m_, least_px(style));
    const bool widened = size_px > primitive.size_m * px_per_m_;
    switch (primitive.shape) {
      case Primitive::Shape::polyline:
        svg_.shape("polyline").attribute("points", points(primitive)).attribute("stroke-width", size_px);
        // The dash is four strokes long: a line to follow, not a wall. A closed section is a fence across the road.
        if (style.layer == "line" && !widened)
          svg_.attribute("stroke-dasharray", {4.0 * size_px, 3.0 * size_px});
        else if (style.layer == "closed")
          svg_.attribute("stroke-opacity", "0.6").attribute("stroke-dasharray", {0.12 * size_px, 0.3 * size_px});
        else
          svg_.attribute("stroke-linecap", "round");
        break;
      case Primitive::Shape::polygon: svg_.shape("polygon").attribute("points", points(primitive)); break;
      case Primitive::Shape::disc:
        svg_.shape("circle").attribute("cx", x_of(primitive.points.front()));
        svg_.attribute("cy", y_of(primitive.points.front())).attribute("r", size_px);
        break;
      case Primitive::Shape::text:
        // An illegible name would only hide the section under its halo; the name is in the title of its line.
        if (size_px >= text_least_px) name(primitive, size_px);
        return;
    }
    if (!primitive.label.empty()) svg_.title(primitive.label);
  }

  void name(const Primitive& primitive, double size_px) {
    text(inside_px(primitive, size_px), y_of(primitive.points.front()), size_px).align(drawing::TextAlign::centre);
    svg_.attribute("dominant-baseline", "central").attribute("stroke", "#fbfcfd").attribute("stroke-width", 3.0);
    svg_.attribute("paint-order", "stroke").text(primitive.label);
  }

  /// The centre of a name, moved so that no part of it extends beyond the drawing's edge.
  [[nodiscard]] double inside_px(const Primitive& name, double size_px) const {
    constexpr double letter = 0.56;  // of the size, on average
    const double half_px = 0.5 * letter * size_px * static_cast<double>(name.label.size());
    return std::clamp(x_of(name.points.front()), half_px, std::max(half_px, width_px_ - half_px));
  }

  [[nodiscard]] std::string points(const Primitive& primitive) const {
    std::string text;
    for (const Point2& p : primitive.points) text.append(text.empty() ? "" : " ").append(xy(p));
    return text;
  }

  struct Entry {
    const Style* style;
    double x_px;
    double row;
  };

  /// The legend, from left to right in as many rows as it takes next to the scale bar.
  void lay_legend() {
    double x_px = margin_px;
    for (std::size_t i = 0; i < styles.size(); ++i) {
      const Style& style = styles[i];
      if (style.name.empty() || by_style_[i].empty()) continue;
      const double wide_px = 52.0 + 7.5 * static_cast<double>(style.name.size());
      if (x_px + wide_px > width_px_ - margin_px - bar_px) {
        x_px = margin_px;
        legend_rows_ += 1.0;
      }
      legend_.push_back({&style, x_px, legend_rows_});
      x_px += wide_px;
    }
  }

  void foot() {
    for (const Entry& entry : legend_) {
      const double y_px = height_px_ - 34.0 - (legend_rows_ - entry.row) * row_px;
      swatch(*entry.style, entry.x_px, y_px);
      text(entry.x_px + 26.0, y_px + 5.0, 14.0).attribute("fill", "#44525f").text(entry.style->name);
    }
    scale_bar(height_px_ - 34.0);
  }

  void swatch(const Style& style, double x_px, double y_px) {
    if (style.fill == "none") {
      const bool fence = style.layer == "closed";
      svg_.shape("path").attribute("d", "M" + svg_.number(x_px) + " " + svg_.number(y_px) + "h20");
      svg_.attribute("stroke", style.stroke).attribute("stroke-width", fence ? 14.0 : 3.0);
      if (fence) svg_.attribute("stroke-opacity", "0.6").attribute("stroke-dasharray", {2.0, 4.0});
      return;
    }
    if (style.layer == "tag" || style.layer == "beacon" || style.layer == "pivot") {
      svg_.shape("circle").attribute("cx", x_px + 10.0).attribute("cy", y_px).attribute("r", 6.0);
    } else {
      svg_.shape("rect").at(x_px + 2.0, y_px - 7.0).size(16.0, 14.0).attribute("rx", 2.0);
    }
    svg_.attribute("fill", style.fill).attribute("stroke", style.stroke);
  }

  /// A round length (1, 2 or 5 times a power of ten) of at most bar_px.
  void scale_bar(double y) {
    double bar_m = 1.0;
    while (bar_m * px_per_m_ > bar_px - 60.0) bar_m /= 10.0;
    while (bar_m * px_per_m_ * 10.0 <= bar_px - 60.0) bar_m *= 10.0;
    for (const double factor : {5.0, 2.0}) {
      if (factor * bar_m * px_per_m_ <= bar_px - 60.0) {
        bar_m *= factor;
        break;
      }
    }
    const double right = width_px_ - margin_px;
    const double left = right - bar_m * px_per_m_;
    svg_.shape("path").attribute("d", "M" + svg_.number(left) + " " + svg_.number(y - 5.0) + "v10M" +
                                          svg_.number(left) + " " + svg_.number(y) + "H" + svg_.number(right) + "M" +
                                          svg_.number(right) + " " + svg_.number(y - 5.0) + "v10");
    svg_.attribute("stroke", "#1d2730").attribute("stroke-width", 2.0).attribute("fill", "none");
    char buffer[32];
    std::string length{buffer, std::to_chars(buffer, buffer + sizeof buffer, bar_m, std::chars_format::general, 3).ptr};
    text(left - 10.0, y + 5.0, 14.0).align(drawing::TextAlign::end).attribute("fill", "#1d2730").text(length + " m");
  }

  const TrafficZone& zone_;
  const std::vector<Primitive>& primitives_;
  Bounds box_;
  std::vector<std::vector<const Primitive*>> by_style_;
  std::vector<Entry> legend_;
  double legend_rows_{1.0};
  double px_per_m_{};
  double width_px_{};
  double height_px_{};
  double left_px_{};
  drawing::SvgWriter svg_{2};
};

}  // namespace

std::string to_svg(const TrafficZone& zone, const std::vector<Primitive>& primitives) {
  return Svg{zone, primitives}.write();
}

}  // namespace cosiva::zone
