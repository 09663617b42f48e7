// to_svg: the drawing of a zone as a file that any browser opens.
#include "cosiva/zone/drawing/svg.h"

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>

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

std::string number(double value) {
  char buffer[48];
  std::string text{buffer, std::to_chars(buffer, buffer + sizeof buffer, value, std::chars_format::fixed, 2).ptr};
  text.erase(text.find_last_not_of('0') + 1);
  if (text.back() == '.') text.pop_back();
  return text == "-0" ? "0" : text;
}

std::string escaped(std::string_view text) {
  std::string out;
  for (const char c : text) {
    switch (c) {
      case '&': out += "&amp;"; break;
      case '<': out += "&lt;"; break;
      case '>': out += "&gt;"; break;
      case '"': out += "&quot;"; break;
      default:
        if (static_cast<unsigned char>(c) >= 0x20) out += c;  // XML 1.0 cannot express most control characters
    }
  }
  return out;
}

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
    left_px_ = 0.5 * (width_px_ - width_m * px_per_m_);
  }

  std::string write() {
    head();
    for (std::size_t i = 0; i < styles.size(); ++i)
      if (!by_style_[i].empty()) layer(styles[i], by_style_[i]);
    foot();
    out_ += "</svg>\n";
    return std::move(out_);
  }

 private:
  [[nodiscard]] std::string xy(Point2 p) const {
    return number(left_px_ + (p.x_m - box_.low.x_m) * px_per_m_) + "," +
           number(head_px + margin_px + (box_.high.y_m - p.y_m) * px_per_m_);
  }

  void text(double x_px, double y_px, double size_px, std::string_view attributes, std::string_view phrase) {
    out_ += "<text x=\"" + number(x_px) + "\" y=\"" + number(y_px) + "\" font-size=\"" + number(size_px) + "\" ";
    out_.append(attributes).append(">").append(escaped(phrase)).append("</text>\n");
  }

  void head() {
    out_ += "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 " + number(width_px_) + " " + number(height_px_) +
            "\" width=\"" + number(width_px_) + "\" height=\"" + number(height_px_) +
            "\" font-family=\"system-ui, 'Segoe UI', 'DejaVu Sans', sans-serif\">\n";
    out_ += "<title>" + escaped(zone_.name) + "</title>\n";
    out_ += "<rect width=\"100%\" height=\"100%\" fill=\"#fbfcfd\"/>\n";
    text(margin_px, 40.0, 24.0, "font-weight=\"600\" fill=\"#1d2730\"", zone_.name);
    const auto count = [](std::size_t n, std::string_view one) {
      return std::to_string(n) + " " + std::string(one) + (n == 1 ? "" : "s");
    };
    text(width_px_ - margin_px, 40.0, 14.0, "text-anchor=\"end\" fill=\"#5d6b78\"",
         count(zone_.circuit.size(), "section") + ", " + number(zone_.circuit.total_length_m()) + " m, " +
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
    out_.append("<g id=\"").append(style.layer);
    if (!style.kind.empty()) out_.append("-").append(style.kind);
    out_.append("\" fill=\"").append(style.fill).append("\" stroke=\"").append(style.stroke);
    out_ += "\" stroke-linejoin=\"round\">\n";
    if (shapes.size() > titled_max && shapes.front()->shape == Primitive::Shape::polyline) {
      gathered(style, shapes);
    } else {
      for (const Primitive* primitive : shapes) shape(style, *primitive);
    }
    out_ += "</g>\n";
  }

  /// Many lines as one path, without their names.
  void gathered(const Style& style, const std::vector<const Primitive*>& shapes) {
    out_ += "<path stroke-width=\"" + number(std::max({shapes.front()->size_m * px_per_m_, least_px(style), 0.05})) +
            "\" stroke-linecap=\"round\" d=\"";
    for (const Primitive* primitive : shapes) {
      char command = 'M';
      for (const Point2& p : primitive->points) {
        out_ += command;
        out_ += xy(p);
        command = 'L';
      }
    }
    out_ += "\"/>\n";
  }

  void shape(const Style& style, const Primitive& primitive) {
    const double size_px = std::max(primitive.size_m * px_per_m_, least_px(style));
    const bool widened = size_px > primitive.size_m * px_per_m_;
    std::string title;
    if (!primitive.label.empty()) title = "<title>" + escaped(primitive.label) + "</title>";
    switch (primitive.shape) {
      case Primitive::Shape::polyline:
        out_ += "<polyline" + points(primitive) + " stroke-width=\"" + number(size_px) + "\"";
        // The dash is four strokes long: a line to follow, not a wall. A closed section is a fence across the road.
        if (style.layer == "line" && !widened)
          out_ += " stroke-dasharray=\"" + number(4.0 * size_px) + " " + number(3.0 * size_px) + "\"";
        else if (style.layer == "closed")
          out_ += " stroke-opacity=\"0.6\" stroke-dasharray=\"" + number(0.12 * size_px) + " " + number(0.3 * size_px) +
                  "\"";
        else
          out_ += " stroke-linecap=\"round\"";
        out_ += ">" + title + "</polyline>\n";
        break;
      case Primitive::Shape::polygon: out_ += "<polygon" + points(primitive) + ">" + title + "</polygon>\n"; break;
      case Primitive::Shape::disc: {
        const std::string at = xy(primitive.points.front());
        const auto comma = at.find(',');
        out_ += "<circle cx=\"" + at.substr(0, comma) + "\" cy=\"" + at.substr(comma + 1) + "\" r=\"" +
                number(size_px) + "\">" + title + "</circle>\n";
        break;
      }
      case Primitive::Shape::text: {
        // An illegible name would only hide the section under its halo; the name is in the title of its line.
        if (size_px < text_least_px) break;
        const std::string at = xy(primitive.points.front());
        const auto comma = at.find(',');
        out_ += "<text x=\"" + number(inside_px(primitive, size_px)) + "\" y=\"" + at.substr(comma + 1) +
                "\" font-size=\"" + number(size_px) +
                "\" text-anchor=\"middle\" dominant-baseline=\"central\" stroke=\"#fbfcfd\" stroke-width=\"3\" "
                "paint-order=\"stroke\">" +
                escaped(primitive.label) + "</text>\n";
        break;
      }
    }
  }

  /// The centre of a name, moved so that no part of it extends beyond the drawing's edge.
  [[nodiscard]] double inside_px(const Primitive& name, double size_px) const {
    constexpr double letter = 0.56;  // of the size, on average
    const double half_px = 0.5 * letter * size_px * static_cast<double>(name.label.size());
    const double at_px = left_px_ + (name.points.front().x_m - box_.low.x_m) * px_per_m_;
    return std::clamp(at_px, half_px, std::max(half_px, width_px_ - half_px));
  }

  [[nodiscard]] std::string points(const Primitive& primitive) const {
    std::string text = " points=\"";
    for (const Point2& p : primitive.points) text += (text.back() == '"' ? "" : " ") + xy(p);
    return text + "\"";
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
      text(entry.x_px + 26.0, y_px + 5.0, 14.0, "fill=\"#44525f\"", entry.style->name);
    }
    scale_bar(height_px_ - 34.0);
  }

  void swatch(const Style& style, double x_px, double y_px) {
    const bool line = style.fill == "none";
    std::string colours = " fill=\"";
    colours.append(style.fill).append("\" stroke=\"").append(line ? "none" : style.stroke).append("\"");
    if (line) {
      const bool fence = style.layer == "closed";
      out_ += "<path d=\"M" + number(x_px) + " " + number(y_px) + "h20\" stroke=\"" + std::string(style.stroke) +
              (fence ? "\" stroke-width=\"14\" stroke-opacity=\"0.6\" stroke-dasharray=\"2 4\"/>\n"
                     : "\" stroke-width=\"3\"/>\n");
    } else if (style.layer == "tag" || style.layer == "beacon" || style.layer == "pivot") {
      out_ += "<circle cx=\"" + number(x_px + 10.0) + "\" cy=\"" + number(y_px) + "\" r=\"6\"" + colours + "/>\n";
    } else {
      out_ += "<rect x=\"" + number(x_px + 2.0) + "\" y=\"" + number(y_px - 7.0) +
              "\" width=\"16\" height=\"14\" rx=\"2\"" + colours + "/>\n";
    }
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
    out_ += "<path d=\"M" + number(left) + " " + number(y - 5.0) + "v10M" + number(left) + " " + number(y) + "H" +
            number(right) + "M" + number(right) + " " + number(y - 5.0) +
            "v10\" stroke=\"#1d2730\" stroke-width=\"2\" fill=\"none\"/>\n";
    char buffer[32];
    std::string length{buffer, std::to_chars(buffer, buffer + sizeof buffer, bar_m, std::chars_format::general, 3).ptr};
    text(left - 10.0, y + 5.0, 14.0, "text-anchor=\"end\" fill=\"#1d2730\"", length + " m");
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
  std::string out_;
};

}  // namespace

std::string to_svg(const TrafficZone& zone, const std::vector<Primitive>& primitives) {
  return Svg{zone, primitives}.write();
}

}  // namespace cosiva::zone
