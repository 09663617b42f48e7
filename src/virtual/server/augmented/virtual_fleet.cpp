#include "cosiva/virtual/server/augmented/virtual_fleet.h"

#include <algorithm>
#include <utility>
#include <variant>

#include "cosiva/base/archive.h"
#include "cosiva/base/expect.h"
#include "cosiva/wire/vda5050/typed_messages.h"

namespace cosiva::virtual_side {

void VirtualFleet::send(Host& host) {
  for (wire::Effect& effect : effects_) {
    if (auto* message = std::get_if<wire::Publish>(&effect)) {
      publisher_.publish(std::move(message->topic), std::move(message->payload), message->qos, message->retained);
    } else if (auto* log = std::get_if<wire::Log>(&effect)) {
      publisher_.log(log->level, registry_[host.vehicle].name() + ": " + log->text);
    } else if (auto* listen = std::get_if<wire::Listen>(&effect)) {
      host.listens = std::move(listen->filters);
    }
  }
  effects_.clear();
}

void VirtualFleet::add(VehicleIndex vehicle, SimTime now, bool link_up, const std::shared_ptr<const zone::Rtm>& rtm,
                       zone::TrackPosition start) {
  COSIVA_EXPECT(effects_.empty());
  host(vehicle, now, {rtm, start});
  if (!link_up) return;
  hosts_.back().aiv.link(now, true, effects_);
  send(hosts_.back());
}

void VirtualFleet::host(VehicleIndex vehicle, SimTime now, const VirtualAiv::Origin& origin) {
  const AivProxy& proxy = registry_[vehicle];
  COSIVA_EXPECT(proxy.augmented() && find(vehicle) == nullptr);
  hosts_.push_back({vehicle, now,
                    VirtualAiv(proxy.id().serial_number, proxy.identity.number(), origin.rtm, origin.start,
                               registry_.interface_name(), rules_, v2x_)});
}

void VirtualFleet::remove(VehicleIndex vehicle, SimTime now) {
  Host* host = find_host(vehicle);
  if (host == nullptr) return;
  host->aiv.farewell(now, effects_);
  send(*host);
  std::erase_if(hosts_, [vehicle](const Host& h) { return h.vehicle == vehicle; });
}

VirtualFleet::Host* VirtualFleet::find_host(VehicleIndex vehicle) {
  const auto it = std::ranges::find(hosts_, vehicle, &Host::vehicle);
  return it == hosts_.end() ? nullptr : &*it;
}

const VirtualFleet::Host* VirtualFleet::find(VehicleIndex vehicle) const {
  const auto it = std::ranges::find(hosts_, vehicle, &Host::vehicle);
  return it == hosts_.end() ? nullptr : &*it;
}

zone::TrackPosition VirtualFleet::position_of(const Host& host, const zone::Circuit& circuit) {
  const Pose2 X_MB = host.aiv.X_MB();
  return circuit.locate(position(X_MB), X_MB.heading_rad).position;
}

void VirtualFleet::link(SimTime now, bool up) {
  for (Host& host : hosts_) {
    host.aiv.link(now, up, effects_);
    send(host);
  }
}

void VirtualFleet::zone(SimTime now, const std::shared_ptr<const zone::Rtm>& rtm) {
  for (Host& host : hosts_) {
    host.aiv.zone(now, rtm, effects_);
    send(host);
  }
}

void VirtualFleet::message(SimTime now, const std::string& topic, const std::string& payload) {
  for (Host& host : hosts_) {
    host.aiv.message(now, topic, payload, effects_);
    send(host);
  }
}

void VirtualFleet::message(SimTime now, VehicleIndex vehicle, const std::string& topic, const std::string& payload) {
  Host* host = find_host(vehicle);
  if (host == nullptr) return;
  host->aiv.message(now, topic, payload, effects_);
  send(*host);
}

bool VirtualFleet::from_broker(SimTime now, const wire::Input& input) {
  for (Host& host : hosts_) {
    const AivProxy& proxy = registry_[host.vehicle];
    if (input.source != proxy.identity.order_topic() && input.source != proxy.identity.actions_topic()) continue;
    const std::string payload = input.typed ? wire::vda5050::text_of(*input.typed) : input.payload;
    host.aiv.message(now, input.source, payload, effects_);
    send(host);
    return true;
  }
  return false;
}

void VirtualFleet::talk(SimTime now, const wire::Input& input) {
  const auto* intent = wire::value_as<wire::Intent>(input.typed);
  const std::string payload = intent == nullptr ? input.payload : wire::to_json(*intent);
  for (Host& host : hosts_) {
    const bool receives = std::ranges::any_of(
        host.listens, [&](const std::string& filter) { return wire::topic_matches(filter, input.source); });
    if (!receives) continue;
    host.aiv.message(now, input.source, payload, effects_);
    send(host);
  }
}

void VirtualFleet::tick(SimTime now) {
  for (Host& host : hosts_) {
    host.aiv.tick(now, effects_);
    send(host);
  }
}

void VirtualFleet::farewell(SimTime now) {
  for (Host& host : hosts_) {
    host.aiv.farewell(now, effects_);
    send(host);
  }
}

void VirtualFleet::fold(Digest& digest) const {
  for (const Host& host : hosts_) {
    digest.add(std::uint64_t{host.vehicle});
    host.aiv.fold(digest);
  }
}

void VirtualFleet::archive(Archive& archive) {
  const std::size_t hosts = archive.count(hosts_.size());
  if (archive.reads() && !hosts_.empty()) archive.fail("virtual AIVs are hosted already");
  for (std::size_t i = 0; i < hosts && !archive.failed(); ++i) {
    VehicleIndex vehicle = archive.reads() ? no_vehicle : hosts_[i].vehicle;
    VirtualAiv::Origin origin = archive.reads() ? VirtualAiv::Origin{} : hosts_[i].aiv.origin();
    archive(vehicle, origin);
    if (archive.failed()) return;
    if (archive.reads()) {
      if (vehicle >= registry_.size() || !registry_[vehicle].augmented() || find(vehicle) != nullptr || !origin.rtm ||
          origin.start.section >= origin.rtm->zone().circuit.size())
        return archive.fail("a virtual AIV that is no vehicle of the registry, or on no zone");
      host(vehicle, {}, origin);
    }
    archive(hosts_[i].since, hosts_[i].aiv, hosts_[i].listens);
  }
}

}  // namespace cosiva::virtual_side
