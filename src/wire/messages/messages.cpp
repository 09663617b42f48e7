#include "cosiva/wire/messages/messages.h"

#include <algorithm>

namespace cosiva::wire {

const ParameterValue* Action::find(std::string_view key) const {
  const auto it = std::ranges::find(parameters, key, &Parameter::key);
  return it == parameters.end() ? nullptr : &it->value;
}

std::optional<double> Action::number(std::string_view key) const {
  const ParameterValue* value = find(key);
  if (value == nullptr) return std::nullopt;
  if (const auto* number = std::get_if<double>(value)) return *number;
  return std::nullopt;
}

std::optional<std::string> Action::text(std::string_view key) const {
  const ParameterValue* value = find(key);
  if (value == nullptr) return std::nullopt;
  if (const auto* text = std::get_if<std::string>(value)) return *text;
  return std::nullopt;
}

}  // namespace cosiva::wire
