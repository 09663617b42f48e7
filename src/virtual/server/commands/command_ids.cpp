#include "cosiva/virtual/server/commands/command_ids.h"

#include <algorithm>
#include <array>
#include <charconv>
#include <optional>
#include <utility>

#include "cosiva/base/archive.h"
#include "cosiva/base/expect.h"

namespace cosiva::virtual_side {
namespace {

template <typename Integer>
std::string in_base(Integer value, int base) {
  std::array<char, 32> digits{};
  const auto end = std::to_chars(digits.data(), digits.data() + digits.size(), value, base).ptr;
  return {digits.data(), end};
}

/// ["mine","00c0ffee00c0ffee"]
std::optional<CommandIdentity> read_identity(const JsonValue& json) {
  const JsonValue::Array* pair = json.array();
  if (pair == nullptr || pair->size() != 2) return std::nullopt;
  const std::string* id = (*pair)[0].text();
  const std::string* digits = (*pair)[1].text();
  if (id == nullptr || digits == nullptr || id->empty() || id->size() > CommandIdentity::id_bytes_max)
    return std::nullopt;
  CommandIdentity command{*id, 0};
  const char* const end = digits->data() + digits->size();
  const auto read = std::from_chars(digits->data(), end, command.content, 16);
  if (read.ec != std::errc{} || read.ptr != end) return std::nullopt;
  return command;
}

}  // namespace

std::string CommandIds::next() {
  std::string id;
  do id = series_ + std::to_string(++count_);
  while (chosen(id));
  return id;
}

void CommandIds::begin_series(SimTime now) {
  const auto ms = std::chrono::duration_cast<std::chrono::milliseconds>(now.time_since_epoch()).count();
  series_ = "c-" + in_base(ms, 36) + "-";
  count_ = 0;
}

bool CommandIds::chosen(std::string_view id) const {
  return std::ranges::find(chosen_, id, &CommandIdentity::id) != chosen_.end();
}

void CommandIds::add(const CommandIdentity& command) {
  if (chosen(command.id)) return;
  chosen_.push_back(command);
  if (chosen_.size() > chosen_max) chosen_.pop_front();
  COSIVA_EXPECT(!chosen_.empty() && chosen_.size() <= chosen_max);
}

CommandIds::Known CommandIds::find(const CommandIdentity& command) const {
  const auto found = std::ranges::find(chosen_, command.id, &CommandIdentity::id);
  if (found == chosen_.end()) return Known::no;
  return found->content == command.content ? Known::same : Known::other;
}

void CommandIds::write(JsonWriter& json) const {
  json.begin_array();
  for (const CommandIdentity& command : chosen_)
    json.begin_array().value(command.id).value(in_base(command.content, 16)).end_array();
  json.end_array();
}

bool CommandIds::restore(const JsonValue& json) {
  chosen_.clear();
  if (json.array() == nullptr) return false;
  bool all_read = true;
  for (const JsonValue& one : *json.array()) {
    const auto command = read_identity(one);
    if (command) add(*command);
    all_read = all_read && command;
  }
  return all_read;
}

void CommandIds::fold(Digest& digest) const {
  for (const CommandIdentity& command : chosen_) {
    digest.add(std::string_view{command.id});
    digest.add(command.content);
  }
}

void CommandIds::archive(Archive& archive) { archive(series_, count_, chosen_); }

}  // namespace cosiva::virtual_side
