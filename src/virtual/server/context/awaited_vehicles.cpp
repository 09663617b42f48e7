#include "cosiva/virtual/server/context/awaited_vehicles.h"

#include <algorithm>

#include "cosiva/base/archive.h"
#include "cosiva/base/expect.h"

namespace cosiva::virtual_side {
namespace {

/// A vehicle that has signed off has no base any more.
bool reports(const AivProxy& proxy) {
  return proxy.state() != nullptr && !proxy.augmented() && !proxy.retired() && !proxy.membership.handed_over() &&
         proxy.connection.state() != wire::ConnectionState::offline;
}

}  // namespace

void AwaitedVehicles::write(JsonWriter& json) const {
  std::vector<std::string> names = names_;
  for (const AivProxy& proxy : context_.registry)
    if (reports(proxy) && std::ranges::find(names, proxy.name()) == names.end()) names.push_back(proxy.name());
  if (names.empty()) return;
  json.key("vehicles").begin_array();
  for (const std::string& name : names) json.value(name);
  json.end_array();
}

void AwaitedVehicles::restore(const JsonValue& names) {
  if (names.array() == nullptr) return;
  for (const JsonValue& name : *names.array())
    if (name.text() != nullptr && names_.size() < context_.registry.vehicles_max()) names_.push_back(*name.text());
}

bool AwaitedVehicles::have_reported() {
  if (names_.empty()) return true;
  if (!until_) until_ = context_.now + wait_max;
  for (const AivProxy& proxy : context_.registry)
    if (proxy.state() != nullptr) std::erase(names_, proxy.name());
  if (names_.empty()) return true;
  COSIVA_EXPECT(until_);
  if (context_.now < *until_) return false;
  std::string text;
  for (const std::string& name : names_) text += (text.empty() ? "" : ", ") + name;
  context_.publisher.log('w',
                         "orders are extended although these vehicles have not reported since the restart: " + text);
  names_.clear();
  return true;
}

void AwaitedVehicles::archive(Archive& archive) { archive(names_, until_); }

}  // namespace cosiva::virtual_side
