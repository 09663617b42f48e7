#include "cosiva/virtual/server/context/awaited_vehicles.h"

#include <algorithm>
#include <map>
#include <utility>

#include "cosiva/base/archive.h"
#include "cosiva/base/expect.h"

namespace cosiva::virtual_side {
namespace {

/// A vehicle that has signed off has no base any more.
bool reports(const AivProxy& proxy) {
  return proxy.state() != nullptr && !proxy.augmented() && !proxy.retired() && !proxy.membership.handed_over() &&
         proxy.connection.state() != wire::ConnectionState::offline;
}

std::string joined(const std::vector<std::string>& names) {
  std::string text;
  for (const std::string& name : names) text += (text.empty() ? "" : ", ") + name;
  return text;
}

}  // namespace

void AwaitedVehicles::write(JsonWriter& json) const {
  std::vector<std::string> names;
  for (const Awaited& awaited : awaited_) names.push_back(awaited.name);
  for (const AivProxy& proxy : context_.registry)
    if (reports(proxy) && std::ranges::find(names, proxy.name()) == names.end()) names.push_back(proxy.name());
  if (names.empty()) return;
  json.key("vehicles").begin_array();
  for (const std::string& name : names) json.value(name);
  json.end_array();
  write_held(json);
}

void AwaitedVehicles::write_held(JsonWriter& json) const {
  std::map<std::string, std::string> held;
  if (may_hold()) {
    for (const Awaited& awaited : awaited_)
      for (const std::string& crossing : awaited.crossings) held.emplace(crossing, awaited.name);
  }
  if (missions_.map() != nullptr) {
    const auto& crossings = missions_.map()->zone().crossings;
    for (CrossingIndex x = 0; x < crossings.size(); ++x)
      if (traffic_.holder(x) != no_vehicle && reports(context_.registry[traffic_.holder(x)]))
        held.emplace(crossings[x].name, context_.registry[traffic_.holder(x)].name());
  }
  if (held.empty()) return;
  json.key("held").begin_object().field("zone", missions_.map() != nullptr ? missions_.map()->zone().name : zone_);
  json.key("crossings").begin_object();
  for (const auto& [crossing, name] : held) json.field(crossing, name);
  json.end_object().end_object();
}

void AwaitedVehicles::restore(const JsonValue& names, const JsonValue* held) {
  if (names.array() == nullptr) return;
  for (const JsonValue& name : *names.array())
    if (name.text() != nullptr && awaited_.size() < context_.registry.vehicles_max())
      awaited_.push_back({*name.text(), {}});
  const JsonValue* crossings = held == nullptr ? nullptr : held->find("crossings");
  if (crossings == nullptr || crossings->object() == nullptr) return;
  zone_ = held->text("zone").value_or("");
  for (const auto& [crossing, name] : *crossings->object()) {
    const auto by = name.text() == nullptr ? awaited_.end() : std::ranges::find(awaited_, *name.text(), &Awaited::name);
    if (by != awaited_.end()) by->crossings.push_back(crossing);
  }
}

std::vector<std::string> AwaitedVehicles::holders() const {
  std::vector<std::string> names;
  for (const Awaited& awaited : awaited_)
    if (!awaited.crossings.empty()) names.push_back(awaited.name);
  return names;
}

bool AwaitedVehicles::have_reported() {
  if (awaited_.empty()) return true;
  if (!until_) until_ = context_.now + wait_max;
  end_those_that_reported();
  reserve_crossings();
  if (awaited_.empty() || given_up_) return true;
  COSIVA_EXPECT(until_);
  if (context_.now < *until_) return false;
  give_up();
  return true;
}

bool AwaitedVehicles::is_awaited(const Awaited& awaited) const {
  const auto vehicle = context_.registry.find(awaited.name);
  if (!vehicle) return true;
  const AivProxy& proxy = context_.registry[*vehicle];
  return proxy.state() == nullptr && !proxy.retired() && proxy.connection.state() != wire::ConnectionState::offline;
}

bool AwaitedVehicles::may_hold() const { return missions_.map() == nullptr || missions_.map()->zone().name == zone_; }

void AwaitedVehicles::end_those_that_reported() {
  std::erase_if(awaited_, [this](const Awaited& awaited) {
    if (is_awaited(awaited)) return false;
    if (const auto vehicle = context_.registry.find(awaited.name)) {
      context_.registry[*vehicle].membership.on_awaited_end();
      traffic_.reserve(*vehicle, {});
    }
    return true;
  });
}

void AwaitedVehicles::reserve_crossings() {
  if (missions_.map() == nullptr) return;
  for (Awaited& awaited : awaited_) {
    // In another zone its base leads nowhere: the vehicle gets no order there before it reports.
    if (!may_hold()) awaited.crossings.clear();
    const auto vehicle = context_.registry.find(awaited.name);
    if (!vehicle) continue;
    context_.registry[*vehicle].membership.on_awaited();
    std::vector<CrossingIndex> reserved;
    const auto& crossings = missions_.map()->zone().crossings;
    for (CrossingIndex x = 0; x < crossings.size(); ++x)
      if (std::ranges::find(awaited.crossings, crossings[x].name) != awaited.crossings.end()) reserved.push_back(x);
    traffic_.reserve(*vehicle, std::move(reserved));
  }
}

void AwaitedVehicles::give_up() {
  given_up_ = true;
  std::string text;
  for (const Awaited& awaited : awaited_) {
    text += (text.empty() ? "" : ", ") + awaited.name;
    if (!awaited.crossings.empty()) text += " (holds " + joined(awaited.crossings) + " until it reports or is retired)";
  }
  context_.publisher.log('w',
                         "orders are extended although these vehicles have not reported since the restart: " + text);
  std::erase_if(awaited_, [this](const Awaited& awaited) {
    if (!awaited.crossings.empty()) return false;
    if (const auto vehicle = context_.registry.find(awaited.name))
      context_.registry[*vehicle].membership.on_awaited_end();
    return true;
  });
}

void AwaitedVehicles::archive(Archive& archive) { archive(awaited_, zone_, until_, given_up_); }

}  // namespace cosiva::virtual_side
