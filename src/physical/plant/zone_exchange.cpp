#include "physical/plant/zone_exchange.h"

#include <cstdint>
#include <utility>

#include "wire/topics.h"
#include "zone/edit.h"

namespace cosiva::physical {

ZoneExchange::ZoneExchange(zone::ZoneConfiguration own, zone::TrafficZone zone, bool publish)
    : own_{std::move(own)}, zone_{std::move(zone)}, publish_{publish} {}

void ZoneExchange::on_link(bool up, SimTime at) {
  due_.reset();
  if (up && publish_) due_ = at + listens_for;
}

void ZoneExchange::tick(SimTime at, wire::Effects& effects) {
  if (!due_ || at < *due_) return;
  due_.reset();
  effects.emplace_back(wire::Publish{std::string(wire::zone_topic_prefix) + own_.format, own_.text, 1, true});
}

const zone::TrafficZone* ZoneExchange::on_message(std::string_view topic, std::string_view text,
                                                  wire::Effects& effects) {
  const std::string format{topic.substr(wire::zone_topic_prefix.size())};
  if (text.empty()) return nullptr;  // somebody cleared what the broker keeps
  if (format == own_.format && text == own_.text) {
    due_.reset();  // the broker has it already, or this is what we said
    return nullptr;
  }
  zone::ZoneConfiguration heard{format, std::string(topic), std::string(text)};
  const auto rtm = zone::Rtm::initialise(heard);
  if (!rtm) {
    effects.emplace_back(
        wire::Log{'w', "a zone was sent that cannot be read, so the plant keeps its own: " + to_string(rtm.error())});
    return nullptr;
  }
  if (!zone::same_ways(zone_, rtm->zone())) {
    effects.emplace_back(wire::Log{'w', "zone '" + rtm->zone().name + "' was sent, whose ways are not those of '" +
                                            zone_.name +
                                            "'; the plant keeps its own: start it with the other zone to drive there"});
    return nullptr;
  }
  due_.reset();
  own_ = std::move(heard);
  zone_ = rtm->zone();
  const std::uint64_t beacons = zone_.beacons ? std::uint64_t{zone_.beacons->columns} * zone_.beacons->rows : 0;
  effects.emplace_back(wire::Log{'i', "took over zone '" + zone_.name +
                                          "' as it was edited: " + std::to_string(zone_.tags.size()) + " tags, " +
                                          std::to_string(beacons) + " beacons"});
  return &zone_;
}

}  // namespace cosiva::physical
