#include "cosiva/base/json_value.h"

#include <simdjson.h>

#include <algorithm>

#include "cosiva/base/archive.h"
#include "cosiva/base/json_parse_count.h"

namespace cosiva {
namespace {

constexpr std::size_t depth_max = 64;
/// A parser needs about ten times the memory of its text.
constexpr std::size_t kept_bytes_max = 16U << 10U;

JsonValue convert(simdjson::dom::element element) {
  switch (element.type()) {
    case simdjson::dom::element_type::ARRAY: {
      JsonValue::Array items;
      items.reserve(simdjson::dom::array(element).size());
      for (const auto item : simdjson::dom::array(element)) items.push_back(convert(item));
      return JsonValue{std::move(items)};
    }
    case simdjson::dom::element_type::OBJECT: {
      JsonValue::Object members;
      members.reserve(simdjson::dom::object(element).size());
      for (const auto member : simdjson::dom::object(element))
        members.emplace_back(std::string(member.key), convert(member.value));
      return JsonValue{std::move(members)};
    }
    case simdjson::dom::element_type::INT64: return JsonValue{static_cast<double>(int64_t(element))};
    case simdjson::dom::element_type::UINT64: return JsonValue{static_cast<double>(uint64_t(element))};
    case simdjson::dom::element_type::DOUBLE: return JsonValue{double(element)};
    case simdjson::dom::element_type::STRING: return JsonValue{std::string(std::string_view(element))};
    case simdjson::dom::element_type::BOOL: return JsonValue{bool(element)};
    case simdjson::dom::element_type::NULL_VALUE: break;
  }
  return {};
}

}  // namespace

Result<JsonValue> JsonValue::parse(std::string_view text, std::size_t bytes_max) {
  if (text.size() > bytes_max) {
    return fail("json.syntax",
                std::to_string(text.size()) + " bytes of JSON, at most " + std::to_string(bytes_max) + " are accepted");
  }
  count_json_parse();
  try {
    // Reused between messages: allocating its memory anew would cost more than reading a short message.
    static thread_local simdjson::dom::parser kept;
    simdjson::dom::parser large;
    simdjson::dom::parser& parser = text.size() < kept_bytes_max ? kept : large;
    if (const std::size_t wanted = std::max(text.size() + 1, kept_bytes_max); parser.capacity() < wanted) {
      if (const auto error = parser.allocate(wanted, depth_max))
        return fail("json.syntax", simdjson::error_message(error));
    }
    simdjson::dom::element element;
    if (const auto error = parser.parse(simdjson::padded_string(text)).get(element)) {
      return fail("json.syntax", std::string("not JSON: ") + simdjson::error_message(error));
    }
    return convert(element);
  } catch (const simdjson::simdjson_error& error) {
    return fail("json.syntax", error.what());
  }
}

const JsonValue* JsonValue::find(std::string_view key) const {
  const Object* members = object();
  if (members == nullptr) return nullptr;
  for (const auto& [name, member] : *members) {
    if (name == key) return &member;
  }
  return nullptr;
}

std::optional<double> JsonValue::number(std::string_view key) const {
  const JsonValue* member = find(key);
  const double* value = member == nullptr ? nullptr : member->number();
  return value == nullptr ? std::nullopt : std::optional(*value);
}

std::optional<std::string> JsonValue::text(std::string_view key) const {
  const JsonValue* member = find(key);
  const std::string* value = member == nullptr ? nullptr : member->text();
  return value == nullptr ? std::nullopt : std::optional(*value);
}

std::optional<bool> JsonValue::flag(std::string_view key) const {
  const JsonValue* member = find(key);
  const bool* value = member == nullptr ? nullptr : member->flag();
  return value == nullptr ? std::nullopt : std::optional(*value);
}

void JsonValue::archive(Archive& archive) { archive(value_); }

}  // namespace cosiva
