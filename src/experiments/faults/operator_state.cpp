#include "cosiva/experiments/faults/operator_state.h"

#include <utility>

#include "cosiva/base/expect.h"

namespace cosiva::experiments {
namespace {

constexpr std::size_t state_bytes_max = std::size_t{16} << 20U;

}  // namespace

void OperatorState::Intention::take(std::string_view name) {
  if (name == "stop")
    stopped = true;
  else if (name == "cancel")
    cancelled = true;
  else if (name == "restart")
    *this = Intention{};
  else
    profile = std::string(name);
}

std::string OperatorState::Intention::text() const {
  std::string text;
  if (stopped) text += " stopped";
  if (cancelled) text += " cancelled";
  if (!profile.empty()) text += " " + profile;
  return text.empty() ? " none" : text;
}

const OperatorState::Intention& OperatorState::of(const std::string& vehicle) const {
  const auto own = own_.find(vehicle);
  return own == own_.end() ? everyone_ : own->second;
}

void OperatorState::set(const std::string& vehicle, const Intention& intention) {
  if (intention == everyone_)
    own_.erase(vehicle);
  else
    own_[vehicle] = intention;
}

void OperatorState::take_objects(const std::string& order, const JsonValue& command) {
  if (order == "add") {
    const JsonValue* object = command.find("virtualObject");
    if (object == nullptr) return;
    (object->text("kind") == std::optional<std::string>{"aiv"} ? aivs_ : objects_)
        .insert(object->text("id").value_or(""));
    return;
  }
  const std::string id = command.text("id").value_or("");
  for (std::set<std::string>* ids : {&objects_, &aivs_}) {
    if (id == "*")
      ids->clear();
    else
      ids->erase(id);
  }
}

void OperatorState::take(std::string_view command_json) {
  const auto json = JsonValue::parse(command_json);
  COSIVA_EXPECT(json);
  const std::string order = json->text("command").value_or("");
  if (order == "add" || order == "remove") return take_objects(order, *json);
  const auto vehicle = json->text("vehicle");
  if (!vehicle) return;
  if (*vehicle == "*") {
    everyone_.take(order);
    for (auto& [name, intention] : own_) intention.take(order);
    std::erase_if(own_, [this](const auto& entry) { return entry.second == everyone_; });
    return;
  }
  Intention intention = of(*vehicle);
  intention.take(order);
  set(*vehicle, intention);
}

Result<OperatorState> OperatorState::from_persisted(std::string_view text) {
  const auto json = JsonValue::parse(text, state_bytes_max);
  if (!json) return fail("simulate.state", "the persisted state is no JSON: " + json.error().message);
  OperatorState state;
  const auto read = [](const JsonValue& from) {
    return Intention{from.flag("stopped").value_or(false), from.flag("cancelled").value_or(false),
                     std::string(from.text("profile").value_or(""))};
  };
  if (const JsonValue* intentions = json->find("intentions")) {
    if (const JsonValue* all = intentions->find("all")) state.everyone_ = read(*all);
    const JsonValue* vehicles = intentions->find("vehicles");
    if (vehicles != nullptr && vehicles->object() != nullptr)
      for (const auto& [name, value] : *vehicles->object()) state.set(name, read(value));
  }
  const auto ids_in = [&json](std::string_view field, std::set<std::string>& ids) {
    const JsonValue* objects = json->find(field);
    if (objects == nullptr || objects->array() == nullptr) return;
    for (const JsonValue& object : *objects->array()) ids.insert(std::string(object.text("id").value_or("")));
  };
  ids_in("virtualObjects", state.objects_);
  ids_in("aivs", state.aivs_);
  return state;
}

std::string OperatorState::text() const {
  std::string text = "all:" + everyone_.text();
  for (const auto& [name, intention] : own_) text += "; " + name + ":" + intention.text();
  text += "; objects:";
  for (const std::string& id : objects_) text += " " + id;
  text += "; AIVs:";
  for (const std::string& id : aivs_) text += " " + id;
  return text;
}

}  // namespace cosiva::experiments
