// to_svg: the picture of a zone as a file that any browser opens.
#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>

#include "zone/draw.h"

namespace cosiva::zone {
namespace {

constexpr double picture_px = 960.0;  // the longer side of the map
constexpr double margin_px = 36.0;
constexpr double head_px = 56.0;
constexpr double foot_px = 64.0;

struct LayerStyle {
  std::string_view layer;
  std::string_view fill;
  std::string_view stroke;
};

// Bottom to top. Colours keep a contrast of at least 3:1 with the road they lie on.
constexpr std::array<LayerStyle, 8> styles{{
    {"beacon", "#9aa7b4", "none"},
    {"road", "none", "#dfe5ec"},
    {"crossing", "#ffd9a0", "#e08a1e"},
    {"line", "none", "#8797a8"},
    {"tag", "#2563c9", "#ffffff"},
    {"station", "#2f8f5b", "#ffffff"},
    {"section", "#44525f", "none"},
    {"label", "#44525f", "none"},
}};

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
        if (static_cast<unsigned char>(c) >= 0x20) out += c;  // XML 1.0 has no way to say most control characters
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
    px_per_m_ = picture_px / std::max({width_m, height_m, 1e-9});
    // A zone narrower than its legend still gets the legend's room.
    width_px_ = std::max(width_m * px_per_m_ + 2.0 * margin_px, 760.0);
    height_px_ = height_m * px_per_m_ + 2.0 * margin_px + head_px + foot_px;
    left_px_ = 0.5 * (width_px_ - width_m * px_per_m_);
  }

  std::string write() {
    head();
    for (const LayerStyle& style : styles) layer(style);
    foot();
    out_ += "</svg>\n";
    return std::move(out_);
  }

 private:
  [[nodiscard]] std::string xy(Point2 p) const {
    return number(left_px_ + (p.x_m - box_.low.x_m) * px_per_m_) + "," +
           number(head_px + margin_px + (box_.high.y_m - p.y_m) * px_per_m_);
  }

  void text(double x_px, double y_px, double size_px, std::string_view attributes, std::string_view words) {
    out_ += "<text x=\"" + number(x_px) + "\" y=\"" + number(y_px) + "\" font-size=\"" + number(size_px) + "\" ";
    out_.append(attributes).append(">").append(escaped(words)).append("</text>\n");
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

  void layer(const LayerStyle& style) {
    out_ += "<g id=\"" + std::string(style.layer) + "\" fill=\"" + std::string(style.fill) + "\" stroke=\"" +
            std::string(style.stroke) + "\" stroke-linejoin=\"round\">\n";
    for (const Primitive& primitive : primitives_) {
      if (primitive.layer == style.layer && !primitive.points.empty()) shape(primitive);
    }
    out_ += "</g>\n";
  }

  void shape(const Primitive& primitive) {
    const double size_px = primitive.size_m * px_per_m_;
    std::string title;
    if (!primitive.label.empty()) title = "<title>" + escaped(primitive.label) + "</title>";
    switch (primitive.shape) {
      case Primitive::Shape::polyline:
        out_ += "<polyline" + points(primitive) + " stroke-width=\"" + number(size_px) + "\"";
        // The dash is four strokes long: a line to follow, not a wall.
        if (primitive.layer == "line")
          out_ += " stroke-dasharray=\"" + number(4.0 * size_px) + " " + number(3.0 * size_px) + "\"";
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
        const std::string at = xy(primitive.points.front());
        const auto comma = at.find(',');
        out_ += "<text x=\"" + at.substr(0, comma) + "\" y=\"" + at.substr(comma + 1) + "\" font-size=\"" +
                number(size_px) +
                "\" text-anchor=\"middle\" dominant-baseline=\"central\" stroke=\"#fbfcfd\" stroke-width=\"3\" "
                "paint-order=\"stroke\">" +
                escaped(primitive.label) + "</text>\n";
        break;
      }
    }
  }

  [[nodiscard]] std::string points(const Primitive& primitive) const {
    std::string text = " points=\"";
    for (const Point2& p : primitive.points) text += (text.back() == '"' ? "" : " ") + xy(p);
    return text + "\"";
  }

  void foot() {
    const double y = height_px_ - 34.0;
    double x = margin_px;
    for (const std::string_view name : {"road", "crossing", "tag", "beacon", "station"}) {
      const auto* style =
          std::find_if(styles.begin(), styles.end(), [&](const LayerStyle& s) { return s.layer == name; });
      const bool drawn = std::any_of(primitives_.begin(), primitives_.end(),
                                     [&](const Primitive& primitive) { return primitive.layer == name; });
      if (!drawn) continue;
      const std::string colour{style->fill == "none" ? style->stroke : style->fill};
      const bool round = name == "tag" || name == "beacon";
      out_ +=
          round ? "<circle cx=\"" + number(x + 8.0) + "\" cy=\"" + number(y) + "\" r=\"6\" fill=\"" + colour + "\"/>\n"
                : "<rect x=\"" + number(x) + "\" y=\"" + number(y - 7.0) +
                      "\" width=\"16\" height=\"14\" rx=\"2\" fill=\"" + colour + "\"/>\n";
      text(x + 24.0, y + 5.0, 14.0, "fill=\"#44525f\"", name);
      x += 44.0 + 8.0 * static_cast<double>(name.size()) + 8.0;
    }
    scale_bar(y);
  }

  /// A round length (1, 2 or 5 times a power of ten) of at most 180 px.
  void scale_bar(double y) {
    double bar_m = 1.0;
    while (bar_m * px_per_m_ > 180.0) bar_m /= 10.0;
    while (bar_m * px_per_m_ * 10.0 <= 180.0) bar_m *= 10.0;
    for (const double factor : {5.0, 2.0}) {
      if (factor * bar_m * px_per_m_ <= 180.0) {
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
