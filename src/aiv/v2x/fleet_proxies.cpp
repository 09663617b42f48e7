#include "cosiva/aiv/v2x/fleet_proxies.h"

#include <algorithm>
#include <utility>

#include "cosiva/base/archive.h"
#include "cosiva/base/expect.h"
#include "cosiva/wire/in_process/typed_message.h"
#include "cosiva/wire/own/v2x_port.h"

namespace cosiva::aiv {

FleetProxies::FleetProxies(wire::VehicleId self, bool as_values)
    : as_values_{as_values}, intent_topic_{std::move(self)} {}

void FleetProxies::send(SimTime now, wire::Cell cell, wire::Intent&& intent, Links links, wire::Effects& effects) {
  if (!links.broker && !links.direct) return;
  intent.header_id = next_++;
  intent.timestamp = now;
  for (Proxy& proxy : proxies_)
    if (now - proxy.received_at <= receives_for) ++proxy.counts.sent;
  // One number on both links: a vehicle that receives the message twice drops the second one.
  const std::string& topic = intent_topic_.at(intent.map_id, cell);
  if (as_values_) {
    const auto values = wire::typed(std::move(intent));
    if (links.direct) effects.emplace_back(wire::SendBytes{std::string(wire::v2x_port), {}, values});
    if (links.broker) effects.emplace_back(wire::Publish{topic, {}, 0, false, values});
    return;
  }
  std::string json = to_json(intent);
  if (links.direct) effects.emplace_back(wire::SendBytes{std::string(wire::v2x_port), json});
  if (links.broker) effects.emplace_back(wire::Publish{topic, std::move(json), 0, false});
}

void FleetProxies::deliver(SimTime now, const wire::VehicleId& sender) {
  const std::string name = wire::to_string(sender);
  const auto of = [](const Proxy& proxy) -> const std::string& { return proxy.counts.agent; };
  auto at = std::ranges::lower_bound(proxies_, name, {}, of);
  if (at == proxies_.end() || of(*at) != name) {
    if (proxies_.size() >= count_max) {
      proxies_.erase(std::ranges::min_element(proxies_, {}, &Proxy::received_at));
      at = std::ranges::lower_bound(proxies_, name, {}, of);
    }
    at = proxies_.insert(at, Proxy{{name, 0, 0}, now});
  }
  ++at->counts.delivered;
  at->received_at = now;
  COSIVA_EXPECT(proxies_.size() <= count_max);
}

std::vector<wire::ProxyCounts> FleetProxies::counts() const {
  std::vector<wire::ProxyCounts> counts;
  counts.reserve(proxies_.size() + 1);
  for (const Proxy& proxy : proxies_) counts.push_back(proxy.counts);
  return counts;
}

void FleetProxies::archive(Archive& archive) { archive(next_, proxies_); }

}  // namespace cosiva::aiv
