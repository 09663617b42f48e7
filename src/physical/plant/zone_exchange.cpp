#include "cosiva/physical/plant/zone_exchange.h"

#include <cstdint>
#include <utility>

#include "cosiva/base/expect.h"
#include "cosiva/wire/messages/topics.h"
#include "cosiva/zone/edit/edit.h"

namespace cosiva::physical {
namespace {

void log(char level, std::string text, wire::Effects& effects) {
  effects.emplace_back(wire::Log{level, std::move(text)});
}

}  // namespace

ZoneExchange::ZoneExchange(zone::ZoneConfiguration own, std::shared_ptr<const zone::TrafficZone> zone, bool publish)
    : own_{std::move(own)}, zone_{std::move(zone)}, publish_{publish} {}

void ZoneExchange::on_link(bool up, SimTime at) {
  listens_until_.reset();
  others_.clear();
  due_ = up && publish_;
  if (up) listens_until_ = at + listens_for;
}

void ZoneExchange::tick(SimTime at, wire::Effects& effects) {
  if (!listens_until_ || at < *listens_until_) return;
  listens_until_.reset();
  COSIVA_EXPECT(publish_ || !due_);
  if (due_) publish(effects);
}

void ZoneExchange::publish(wire::Effects& effects) {
  due_ = false;
  const std::string prefix{wire::zone_topic_prefix};
  effects.emplace_back(wire::Publish{prefix + own_.format, zone::to_payload(own_), 1, true});
  for (const std::string& format : others_) {
    if (format != own_.format) effects.emplace_back(wire::Publish{prefix + format, "", 1, true});
  }
  others_.clear();
}

std::optional<ZoneExchange::News> ZoneExchange::on_message(std::string_view topic, std::string_view payload, SimTime at,
                                                           wire::Effects& effects) {
  if (payload.empty()) return std::nullopt;  // another client cleared the retained zone
  auto received =
      zone::from_payload(std::string(topic.substr(wire::zone_topic_prefix.size())), std::string(topic), payload);
  if (same_content(received, own_)) {
    due_ = due_ && !others_.empty();  // the broker has it already, or this is the plant's own message
    return std::nullopt;
  }
  const bool listens = listens_until_ && at < *listens_until_;
  const auto rtm = zone::Rtm::initialise(received);
  if (!rtm) {
    log('w', "a zone was sent that cannot be read, so the plant keeps its own: " + to_string(rtm.error()), effects);
    return std::nullopt;
  }
  if (listens && received.format != own_.format) others_.push_back(received.format);
  if (listens && !zone::same_geometry(*zone_, rtm->zone())) {
    log('w',
        "the broker retains zone '" + rtm->zone().name + "', whose sections are not those of '" + zone_->name +
            "', on which this plant's vehicles are; the plant keeps its own zone" +
            (publish_ ? " and publishes it" : "") +
            ": to drive in the other, start the plant with that zone's file, or switch to it now",
        effects);
    return std::nullopt;
  }
  due_ = false;
  return take(std::move(received), *rtm, effects);
}

Result<ZoneExchange::News> ZoneExchange::switch_to(zone::ZoneConfiguration given, wire::Effects& effects) {
  const auto rtm = zone::Rtm::initialise(given);
  if (!rtm) return tl::unexpected(rtm.error());
  if (given.format != own_.format) others_.push_back(own_.format);
  News news = take(std::move(given), *rtm, effects);
  publish(effects);
  return news;
}

ZoneExchange::News ZoneExchange::take(zone::ZoneConfiguration given, const zone::Rtm& rtm, wire::Effects& effects) {
  News news{rtm.shared_zone(), zone::same_geometry(*zone_, rtm.zone())};
  const std::uint64_t beacons =
      news.zone->beacons ? std::uint64_t{news.zone->beacons->columns} * news.zone->beacons->rows : 0;
  if (news.same_geometry) {
    log('i',
        "took over zone '" + news.zone->name + "' as it was edited: " + std::to_string(news.zone->tags.size()) +
            " tags, " + std::to_string(beacons) + " beacons",
        effects);
  } else {
    log('i',
        "switched from zone '" + zone_->name + "' to '" + news.zone->name + "': " +
            std::to_string(news.zone->circuit.size()) + " sections; each vehicle is on it as soon as it is stopped",
        effects);
  }
  own_ = std::move(given);
  zone_ = news.zone;
  return news;
}

}  // namespace cosiva::physical
