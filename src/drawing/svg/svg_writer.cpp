#include "cosiva/drawing/svg/svg_writer.h"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <cstdio>
#include <utility>

#include "cosiva/base/expect.h"

namespace cosiva::drawing {

std::string readable(double number, int digits) {
  if (!std::isfinite(number)) return "–";
  char buffer[64];
  const bool large = std::fabs(number) >= 1e15;
  const auto form = large ? std::chars_format::scientific : std::chars_format::fixed;
  const auto end = std::to_chars(buffer, buffer + sizeof buffer, number, form, large ? 3 : digits).ptr;
  std::string text{buffer, end};
  if (!large && text.find('.') != std::string::npos) {
    text.erase(text.find_last_not_of('0') + 1);
    if (text.back() == '.') text.pop_back();
  }
  return text == "-0" ? "0" : text;
}

std::string escaped(std::string_view text) {
  std::string out;
  out.reserve(text.size());
  for (const char c : text) {
    switch (c) {
      case '&': out += "&amp;"; break;
      case '<': out += "&lt;"; break;
      case '>': out += "&gt;"; break;
      case '"': out += "&quot;"; break;
      default:
        if (static_cast<unsigned char>(c) >= 0x20 || c == '\t' || c == '\n' || c == '\r') out += c;
    }
  }
  return out;
}

std::string colour_between(std::span<const Rgb> stops, double ratio) {
  COSIVA_EXPECT(stops.size() >= 2);
  const double at = std::clamp(ratio, 0.0, 1.0) * static_cast<double>(stops.size() - 1);
  const auto from = std::min(static_cast<std::size_t>(at), stops.size() - 2);
  const double part = at - static_cast<double>(from);
  const auto channel = [&](std::size_t i) {
    return static_cast<unsigned>(std::lround(stops[from][i] + part * (stops[from + 1][i] - stops[from][i])));
  };
  char text[8];
  std::snprintf(text, sizeof text, "#%02x%02x%02x", channel(0), channel(1), channel(2));
  return text;
}

SvgWriter::SvgWriter(int digits) : digits_{digits} { COSIVA_EXPECT(digits >= 0 && digits <= 9); }

SvgWriter& SvgWriter::open(std::string_view container) {
  finish();
  out_.append("<").append(container);
  containers_.emplace_back(container);
  part_ = Part::container_head;
  return *this;
}

SvgWriter& SvgWriter::close() {
  COSIVA_EXPECT(!containers_.empty());
  finish();
  out_.append("</").append(containers_.back()).append(">\n");
  containers_.pop_back();
  return *this;
}

SvgWriter& SvgWriter::shape(std::string_view name) {
  finish();
  out_.append("<").append(name);
  shape_ = name;
  part_ = Part::shape_head;
  return *this;
}

SvgWriter& SvgWriter::attribute(std::string_view name, std::string_view value) {
  COSIVA_EXPECT(part_ == Part::container_head || part_ == Part::shape_head);
  out_.append(" ").append(name).append("=\"").append(escaped(value)).append("\"");
  return *this;
}

SvgWriter& SvgWriter::attribute(std::string_view name, double value) { return attribute(name, number(value)); }

SvgWriter& SvgWriter::attribute(std::string_view name, std::initializer_list<double> values) {
  std::string list;
  for (const double value : values) list.append(list.empty() ? "" : " ").append(number(value));
  return attribute(name, list);
}

SvgWriter& SvgWriter::at(double x, double y) { return attribute("x", x).attribute("y", y); }

SvgWriter& SvgWriter::size(double width, double height) {
  return attribute("width", width).attribute("height", height);
}

SvgWriter& SvgWriter::align(TextAlign align) {
  COSIVA_EXPECT(part_ == Part::container_head || part_ == Part::shape_head);
  out_ += align == TextAlign::centre ? " text-anchor=\"middle\"" : " text-anchor=\"end\"";
  return *this;
}

SvgWriter& SvgWriter::title(std::string_view text) {
  begin_content();
  out_.append("<title>").append(escaped(text)).append("</title>");
  if (part_ == Part::content) out_ += '\n';
  return *this;
}

SvgWriter& SvgWriter::text(std::string_view text) {
  COSIVA_EXPECT(part_ == Part::shape_head || part_ == Part::shape_content);
  begin_content();
  out_ += escaped(text);
  return *this;
}

std::string SvgWriter::take() {
  finish();
  COSIVA_EXPECT(containers_.empty());
  return std::exchange(out_, {});
}

void SvgWriter::begin_content() {
  if (part_ == Part::container_head) {
    out_ += ">\n";
    part_ = Part::content;
  } else if (part_ == Part::shape_head) {
    out_ += '>';
    part_ = Part::shape_content;
  }
}

void SvgWriter::finish() {
  if (part_ == Part::container_head)
    out_ += ">\n";
  else if (part_ == Part::shape_head)
    out_ += "/>\n";
  else if (part_ == Part::shape_content)
    out_.append("</").append(shape_).append(">\n");
  part_ = Part::content;
}

}  // namespace cosiva::drawing
