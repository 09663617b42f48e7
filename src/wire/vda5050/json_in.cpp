#include "cosiva/wire/vda5050/json_in.h"

#include <cmath>

#include "cosiva/base/math.h"

namespace cosiva::wire::vda5050 {
namespace {

constexpr std::size_t depth_max = 32;

std::string_view kind_of(simdjson::dom::element element) {
  switch (element.type()) {
    case simdjson::dom::element_type::ARRAY: return "an array";
    case simdjson::dom::element_type::OBJECT: return "an object";
    case simdjson::dom::element_type::INT64:
    case simdjson::dom::element_type::UINT64:
    case simdjson::dom::element_type::DOUBLE: return "a number";
    case simdjson::dom::element_type::STRING: return "a text";
    case simdjson::dom::element_type::BOOL: return "a flag";
    case simdjson::dom::element_type::NULL_VALUE: return "null";
  }
  return "something unknown";
}

std::string_view cut_utf8(std::string_view text, std::size_t bytes_max) {
  if (text.size() <= bytes_max) return text;
  while (bytes_max > 0 && (static_cast<unsigned char>(text[bytes_max]) & 0xC0U) == 0x80U) --bytes_max;
  return text.substr(0, bytes_max);
}

/// The part of a refused text that a message may show.
std::string in_quotes(std::string_view text) { return "'" + std::string(cut_utf8(text, 60)) + "'"; }

bool is_version_2(std::string_view version) {
  if (!version.empty() && (version.front() == 'v' || version.front() == 'V')) version.remove_prefix(1);
  return version == "2" || version.starts_with("2.");
}

}  // namespace

std::string to_string(const FieldLocation& location) {
  std::string text = location.up == nullptr ? std::string{} : to_string(*location.up);
  if (location.index != FieldLocation::none) return text + "[" + std::to_string(location.index) + "]";
  if (!text.empty()) text += '.';
  return text + std::string(location.key);
}

Result<simdjson::dom::object> parse_root(std::string_view json, std::string_view name) {
  if (json.size() > payload_bytes_max) {
    return fail("vda.size",
                std::to_string(json.size()) + " bytes, at most " + std::to_string(payload_bytes_max) + " are read",
                std::string(name));
  }
  // An empty view may have no address, which memcpy inside the parser must not be given.
  if (json.empty()) return fail("vda.json", "an empty message", std::string(name));
  // One parser per thread: its buffers are a few megabytes, and a message needs them for microseconds.
  thread_local simdjson::dom::parser parser{payload_bytes_max};
  thread_local bool allocated = false;
  if (!allocated) {
    if (const auto error = parser.allocate(payload_bytes_max, depth_max); error != simdjson::SUCCESS)
      return fail("vda.json", simdjson::error_message(error), std::string(name));
    allocated = true;
  }
  simdjson::dom::element root;
  if (const auto error = parser.parse(json.data(), json.size()).get(root); error != simdjson::SUCCESS)
    return fail("vda.json", std::string("not JSON: ") + simdjson::error_message(error), std::string(name));
  simdjson::dom::object object;
  if (root.get(object) != simdjson::SUCCESS)
    return fail("vda.json", "expected an object, found " + std::string(kind_of(root)), std::string(name));
  return object;
}

bool Fields::has(std::string_view key) const {
  simdjson::dom::element element;
  return object_.at_key(key).get(element) == simdjson::SUCCESS && !element.is_null();
}

std::optional<simdjson::dom::element> Fields::find(std::string_view key, Need need) {
  if (!ok()) return std::nullopt;
  simdjson::dom::element element;
  if (object_.at_key(key).get(element) == simdjson::SUCCESS && !element.is_null()) return element;
  if (need == Need::required) report(key, "vda.missing", "required, but not there");
  return std::nullopt;
}

void Fields::wrong_type(const FieldLocation& here, std::string_view expected, simdjson::dom::element found) {
  trouble_.set(here, "vda.type", "expected " + std::string(expected) + ", found " + std::string(kind_of(found)));
}

void Fields::unknown_word(std::string_view key, std::string_view text) {
  report(key, "vda.value", in_quotes(text) + " is not a term of the standard here");
}

bool Fields::bounded_array(simdjson::dom::element element, const FieldLocation& here, simdjson::dom::array& out) {
  if (element.get(out) != simdjson::SUCCESS) {
    wrong_type(here, "an array", element);
    return false;
  }
  if (out.size() > array_items_max) {
    trouble_.set(here, "vda.size", "more than " + std::to_string(array_items_max) + " entries");
    return false;
  }
  return true;
}

bool Fields::string(std::string_view key, std::string_view& out, Need need) {
  const auto element = find(key, need);
  if (!element) return false;
  if (element->get(out) == simdjson::SUCCESS) return true;
  wrong_type(FieldLocation{&location_, key}, "a text", *element);
  return false;
}

void Fields::text(std::string_view key, std::string& out, Need need) {
  std::string_view value;
  if (!string(key, value, need)) return;
  if (value.size() > text_bytes_max)
    return report(key, "vda.size", "a text of more than " + std::to_string(text_bytes_max) + " bytes");
  out.assign(value);
}

void Fields::description(std::string_view key, std::string& out) {
  std::string_view value;
  if (string(key, value, Need::optional)) out.assign(cut_utf8(value, text_bytes_max));
}

void Fields::number(std::string_view key, double& out, Need need, double low, double high) {
  const auto element = find(key, need);
  if (!element) return;
  double value{};
  if (element->get(value) != simdjson::SUCCESS) return wrong_type(FieldLocation{&location_, key}, "a number", *element);
  if (!(value >= low && value <= high)) return report(key, "vda.range", "the number is out of range");
  out = value;
}

void Fields::number(std::string_view key, std::optional<double>& out, double low, double high) {
  double value{};
  if (!has(key)) return;
  number(key, value, Need::optional, low, high);
  if (ok()) out = value;
}

void Fields::count(std::string_view key, std::uint32_t& out, Need need) {
  const auto element = find(key, need);
  if (!element) return;
  double value{};
  if (element->get(value) != simdjson::SUCCESS)
    return wrong_type(FieldLocation{&location_, key}, "a whole number", *element);
  if (value != std::floor(value)) return report(key, "vda.type", "expected a whole number");
  if (!(value >= 0.0 && value <= 4294967295.0))
    return report(key, "vda.range", "out of range: 0 to 4294967295 are counts");
  out = static_cast<std::uint32_t>(value);
}

void Fields::flag(std::string_view key, bool& out, Need need) {
  const auto element = find(key, need);
  if (!element) return;
  if (element->get(out) != simdjson::SUCCESS) wrong_type(FieldLocation{&location_, key}, "a flag", *element);
}

void Fields::timestamp(std::string_view key, SimTime& out, Need need) {
  std::string_view text;
  if (!string(key, text, need)) return;
  if (const auto time = parse_iso8601(text)) {
    out = *time;
  } else {
    report(key, "vda.time", time.error().message);
  }
}

void Fields::angle(std::string_view key, double& out, Need need) {
  double value = out;
  number(key, value, need);
  out = wrap_angle(value);
}

void Fields::angle(std::string_view key, std::optional<double>& out) {
  number(key, out);
  if (out) out = wrap_angle(*out);
}

void Fields::parameter_value(std::string_view key, ParameterValue& out) {
  const auto element = find(key, Need::required);
  if (!element) return;
  if (std::string_view text; element->get(text) == simdjson::SUCCESS) {
    if (text.size() > text_bytes_max)
      return report(key, "vda.size", "a text of more than " + std::to_string(text_bytes_max) + " bytes");
    out = std::string(text);
  } else if (double number{}; element->get(number) == simdjson::SUCCESS) {
    out = number;
  } else if (bool flag{}; element->get(flag) == simdjson::SUCCESS) {
    out = flag;
  } else {
    out = RawJson{simdjson::minify(*element)};
  }
}

void read_header(Fields& fields, Header& header, Need need) {
  fields.count("headerId", header.header_id, need);
  fields.timestamp("timestamp", header.timestamp, need);
  fields.text("version", header.version, need);
  fields.text("manufacturer", header.manufacturer, need);
  fields.text("serialNumber", header.serial_number, need);
  if (fields.ok() && fields.has("version") && !is_version_2(header.version))
    fields.report("version", "vda.version", in_quotes(header.version) + " is not a version 2 of VDA 5050");
}

}  // namespace cosiva::wire::vda5050
