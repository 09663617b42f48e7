#include "cosiva/zone/opendrive/xml.h"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <cstring>

#include "cosiva/base/text.h"

namespace cosiva::zone::opendrive {
namespace {

constexpr std::size_t bytes_max = std::size_t{64} << 20U;
// A tree costs some 70 bytes an element and 40 an attribute: this limits the memory for a file of "<a/>". Real files of
// the greatest size have a quarter of these.
constexpr std::ptrdiff_t elements_max = 2'000'000;
constexpr std::ptrdiff_t attributes_max = 8'000'000;

constexpr std::string_view blanks = " \t\r\n";

/// Without strtod, whose decimal point depends on the locale.
std::optional<double> parsed(std::string_view text) {
  text = trimmed(text, blanks);
  if (text.starts_with('+') && !text.starts_with("+-")) text.remove_prefix(1);
  double value = 0.0;
  const auto [end, fault] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (end != text.data() + text.size()) return std::nullopt;
  // Out of range is too great, or so small that it is 0; the exponent's sign shows which.
  if (fault == std::errc::result_out_of_range)
    return text.find("e-") != std::string_view::npos || text.find("E-") != std::string_view::npos ? std::optional{0.0}
                                                                                                  : std::nullopt;
  if (fault != std::errc{} || !std::isfinite(value)) return std::nullopt;
  return value;
}

std::string in_quotes(std::string_view text) {
  std::string shown = "\"";
  for (const char c : text.substr(0, 40)) shown += static_cast<unsigned char>(c) < 0x20 ? ' ' : c;
  shown += text.size() > 40 ? "…\"" : "\"";
  return shown;
}

}  // namespace

Result<std::unique_ptr<XmlFile>> XmlFile::parse(std::string_view origin, std::string_view text) {
  std::string location{origin};
  if (text.size() > bytes_max)
    return fail("zone.size", "expected at most 64 MiB, found " + std::to_string(text.size()) + " bytes", location);
  if (std::count(text.begin(), text.end(), '<') > elements_max)
    return fail("zone.size", "expected at most 2000000 elements, found more", location);
  if (std::count(text.begin(), text.end(), '=') > attributes_max)
    return fail("zone.size", "expected at most 8000000 attributes, found more", location);

  auto file = std::make_unique<XmlFile>();
  file->origin_ = origin;
  const std::string_view head = text.substr(0, 120);
  const bool utf8 = head.find('\0') == std::string_view::npos && head.find("8859") == std::string_view::npos &&
                    head.find("latin") == std::string_view::npos;
  if (utf8) {
    for (auto at = text.find('\n'); at != std::string_view::npos; at = text.find('\n', at + 1))
      file->line_ends_.push_back(at);
    file->line_ends_.push_back(text.size());
  }
  const auto result = file->document_.load_buffer(text.data(), text.size());
  if (!result) {
    if (utf8 && result.offset >= 0) {
      const auto at =
          std::lower_bound(file->line_ends_.begin(), file->line_ends_.end(), static_cast<std::size_t>(result.offset));
      location += ':' + std::to_string(at - file->line_ends_.begin() + 1);
    }
    return fail("zone.syntax", std::string("cannot be read as XML: ") + result.description(), location);
  }
  return file;
}

double XmlFile::number(pugi::xml_node node, const char* name, const Range& range, std::optional<double> fallback) {
  const auto attribute = node.attribute(name);
  std::string expected = "expected ";
  expected += range.what;
  if (!attribute) {
    if (fallback) return *fallback;
    fault(node, name, "zone.missing", expected + ", found nothing");
    return range.low;
  }
  const auto value = parsed(attribute.value());
  if (value && *value >= range.low && *value <= range.high) return *value;
  fault(node, name, "zone.field", expected + ", found " + in_quotes(attribute.value()));
  return range.low;
}

std::optional<int> XmlFile::whole(pugi::xml_node node, const char* name) {
  const auto attribute = node.attribute(name);
  if (!attribute) return std::nullopt;
  const auto value = parsed(attribute.value());
  if (value && std::fabs(*value) <= 1e6 && std::floor(*value) == *value) return static_cast<int>(*value);
  fault(node, name, "zone.field", "expected a whole number, found " + in_quotes(attribute.value()));
  return std::nullopt;
}

std::string XmlFile::id(pugi::xml_node node, const char* name) {
  const std::string_view text = trimmed(node.attribute(name).value(), blanks);
  const bool printable =
      std::all_of(text.begin(), text.end(), [](char c) { return static_cast<unsigned char>(c) >= 0x20; });
  if (!text.empty() && text.size() <= 128 && printable) return std::string(text);
  fault(node, name, text.empty() ? "zone.missing" : "zone.field",
        "expected an id of 1 to 128 characters, found " + (text.empty() ? "nothing" : in_quotes(text)));
  return "?";
}

void XmlFile::fault(pugi::xml_node node, std::string_view attribute, std::string code, std::string message) {
  if (!error_) error_ = Error{std::move(code), std::move(message), location(node, attribute)};
}

std::string XmlFile::path(pugi::xml_node node, std::string_view attribute) {
  std::string text;
  if (!attribute.empty()) text = "/@" + std::string(attribute);
  for (; node.parent().parent(); node = node.parent()) {  // up to below the root element
    const std::string_view name = node.name();
    const bool named = (name == "road" || name == "junction") && node.attribute("id");
    std::string step{name};
    if (named) {
      step += ' ' + std::string(std::string_view(node.attribute("id").value()).substr(0, 40));
    } else if (name == "lane" && node.attribute("id")) {
      step += '[' + std::string(std::string_view(node.attribute("id").value()).substr(0, 12)) + ']';
    } else {
      std::size_t index = 1;
      for (auto twin = node.previous_sibling(node.name()); twin; twin = twin.previous_sibling(node.name())) ++index;
      if (index > 1 || node.next_sibling(node.name())) step += '[' + std::to_string(index) + ']';
    }
    if (!text.empty()) step += named ? ", " : text.front() == '/' ? "" : "/";
    if (named && text.starts_with("/@")) text.erase(0, 1);
    text.insert(0, step);
  }
  return text;
}

std::string XmlFile::location(pugi::xml_node node, std::string_view attribute) const {
  std::string text = origin_;
  const std::ptrdiff_t offset = node.offset_debug();
  if (!line_ends_.empty() && offset >= 0) {
    const auto at = std::lower_bound(line_ends_.begin(), line_ends_.end(), static_cast<std::size_t>(offset));
    text += ':' + std::to_string(at - line_ends_.begin() + 1);
  }
  const std::string where = path(node, attribute);
  return where.empty() ? text : text + ": " + where;
}

}  // namespace cosiva::zone::opendrive
