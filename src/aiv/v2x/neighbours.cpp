#include "cosiva/aiv/v2x/neighbours.h"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <utility>

#include "cosiva/base/archive.h"
#include "cosiva/base/expect.h"

namespace cosiva::aiv {
namespace {

constexpr double infinite = std::numeric_limits<double>::infinity();
/// Largest distance of a vehicle from the cell in which it publishes: the slack, and the distance driven since.
constexpr double outside_cell_m_max = 2.0 * wire::v2x_cell_slack_m;
/// Over so short a time a body's path is straight; the change of the gap to the body gives its speed along the own
/// path.
constexpr double glance_s = 0.1;
/// The envelope and the crossing finder may differ by rounding in where a chain begins.
constexpr double entry_slack_m = 0.05;
constexpr double rests_mps = 0.02;

/// Newer, on a counter that wraps.
bool newer(std::uint32_t a, std::uint32_t b) { return static_cast<std::int32_t>(a - b) > 0; }

/// The serial number distinguishes nearly all vehicles, and its last character most of those with one of equal length.
bool differ_at_once(const std::string& serial_number, const std::string& other) {
  return serial_number.size() != other.size() || (!other.empty() && serial_number.back() != other.back());
}

bool same(const wire::VehicleId& a, const wire::VehicleId& b) {
  if (differ_at_once(a.serial_number, b.serial_number)) return false;
  return a.serial_number == b.serial_number && a.manufacturer == b.manufacturer;
}

/// By manufacturer, then by serial number.
bool is_before(const wire::VehicleId& a, const wire::VehicleId& b) {
  const int order = a.manufacturer.compare(b.manufacturer);
  return order != 0 ? order < 0 : a.serial_number < b.serial_number;
}

double sign_of(double x) { return x > 0.0 ? 1.0 : x < 0.0 ? -1.0 : 0.0; }

}  // namespace

std::string_view to_string(Neighbours::Verdict verdict) {
  switch (verdict) {
    case Neighbours::Verdict::taken: return "taken";
    case Neighbours::Verdict::first: return "received for the first time";
    case Neighbours::Verdict::old: return "old";
    case Neighbours::Verdict::own: return "published under this vehicle's own name";
    case Neighbours::Verdict::other_map: return "published for another map";
    case Neighbours::Verdict::far: return "published from beyond the range of reception";
    case Neighbours::Verdict::implausible: return "the reported pose or speed is impossible";
    case Neighbours::Verdict::crowded: return "more vehicles are near than are stored";
  }
  return "?";
}

Neighbours::Neighbours(const zone::TrafficZone& zone, wire::VehicleId self, Model model)
    : zone_{zone},
      self_{std::move(self)},
      model_{model},
      speed_mps_max_{model.speed_ratio_max * std::max({zone.profiles.slow.speed_mps, zone.profiles.medium.speed_mps,
                                                       zone.profiles.fast.speed_mps})},
      gap_{zone, model.gap_model},
      crossing_finder_{zone} {}

bool Neighbours::leaps(const KnownIntent& before, SimTime now, const wire::Intent& intent) const {
  const double since_s = to_seconds(std::max(SimDuration::zero(), now - before.at));
  return distance(before.intent->pose, intent.pose) > model_.leap_m + speed_mps_max_ * since_s;
}

Neighbours::Verdict Neighbours::receive(SimTime now, const wire::V2xTopic& topic,
                                        std::shared_ptr<const wire::Intent> received, Point2 own) {
  const wire::Intent& intent = *received;
  if (same(intent.vehicle, self_) || same(topic.vehicle, self_)) return Verdict::own;
  if (intent.map_id != zone_.name) return Verdict::other_map;
  const Point2 at = position(intent.pose);
  if (!same(intent.vehicle, topic.vehicle) || wire::outside_cell_m(topic.cell, at) > outside_cell_m_max ||
      !(std::fabs(intent.speed_mps) <= speed_mps_max_))
    return Verdict::implausible;
  const auto off_m = [&](Point2 p) { return std::max(std::fabs(p.x_m - own.x_m), std::fabs(p.y_m - own.y_m)); };
  if (!(off_m(at) <= model_.near_m)) return Verdict::far;

  age(now);
  const auto by_name = [](const KnownIntent& h) -> const wire::VehicleId& { return h.intent->vehicle; };
  const auto known = std::ranges::find_if(received_, [&](const KnownIntent& h) {
    return !differ_at_once(by_name(h).serial_number, intent.vehicle.serial_number) && same(by_name(h), intent.vehicle);
  });
  oldest_at_ = std::min(oldest_at_, now);
  newest_at_ = std::max(newest_at_, now);
  if (known != received_.end()) {
    if (!newer(intent.header_id, known->intent->header_id)) return Verdict::old;
    if (leaps(*known, now, intent)) {
      // Two senders use one name, or one reports a false pose: neither is known to be right.
      received_.erase(known);
      return Verdict::implausible;
    }
    *known = {std::move(received), now};
    return Verdict::taken;
  }
  if (received_.size() >= model_.count_max) {
    const auto furthest =
        std::ranges::max_element(received_, {}, [&](const KnownIntent& h) { return off_m(position(h.intent->pose)); });
    if (off_m(position(furthest->intent->pose)) <= off_m(at)) return Verdict::crowded;
    received_.erase(furthest);
  }
  const auto before = std::ranges::lower_bound(received_, intent.vehicle, is_before, by_name);
  const auto added = received_.insert(before, KnownIntent{std::move(received), now});
  COSIVA_EXPECT(received_.size() <= model_.count_max);
  COSIVA_EXPECT(added == received_.begin() || is_before(by_name(*std::prev(added)), by_name(*added)));
  COSIVA_EXPECT(std::next(added) == received_.end() || is_before(by_name(*added), by_name(*std::next(added))));
  return Verdict::first;
}

void Neighbours::age(SimTime now) {
  const SimTime since = now - model_.memory_span;
  if (oldest_at_ >= since && newest_at_ <= now) return;
  // An intent received later than now is from before the clock was set back.
  std::erase_if(received_, [&](const KnownIntent& h) { return h.at < since || h.at > now; });
  oldest_at_ = SimTime::max();
  newest_at_ = SimTime::min();
  for (const KnownIntent& h : received_) {
    oldest_at_ = std::min(oldest_at_, h.at);
    newest_at_ = std::max(newest_at_, h.at);
  }
}

Others Neighbours::around(SimTime now, const Agent& agent) {
  Others others;
  age(now);
  if (received_.empty()) return others;
  // A leader counts only where the vehicle itself perceives a body.
  if (agent.finds_body()) find_leader(now, agent, others);
  find_rivals(now, agent, others);
  return others;
}

void Neighbours::find_leader(SimTime now, const Agent& agent, Others& others) {
  gap_.update(agent.vehicle().position().outlook());
  for (const KnownIntent& received : received_) {
    const wire::Body body = body_of(*received.intent, zone_.vehicle);
    const double carried_s = to_seconds(std::min(now - received.at, model_.carry_max));
    const double gap_m = gap_.gap_m(body, carried_s);
    if (!(gap_m < others.leader_gap_m)) continue;
    const double later_m = gap_.gap_m(body, carried_s + glance_s);
    others.leader_gap_m = gap_m;
    others.leader_mps = std::isfinite(later_m) ? std::optional{(later_m - gap_m) / glance_s} : std::nullopt;
  }
}

void Neighbours::find_rivals(SimTime now, const Agent& agent, Others& others) {
  const double stop_m = agent.decision().crossing_ahead_m;
  if (!std::isfinite(stop_m)) return;
  crossing_finder_.ahead(agent.vehicle().position().outlook(), stop_m + entry_slack_m, wire::Intent::crossings_max,
                         approached_);
  const auto in_chain = [&](const wire::CrossingIntent& crossing) {
    return std::ranges::any_of(approached_, [&](const CrossingSpan& crossing_span) {
      return crossing_span.entry_m >= stop_m - entry_slack_m &&
             zone_.crossings[crossing_span.crossing].name == crossing.name;
    });
  };
  const double own_s = earliest_s(stop_m, agent.vehicle().motion().speed_mps(), zone_.profiles.medium);
  const double slow_s = stop_m / zone_.profiles.slow.speed_mps;
  const double own_priority = zone_.priority_of(wire::to_string(self_));
  for (const KnownIntent& received : received_) {
    const double ago_s = to_seconds(now - received.at);
    double arrival_s = infinite;
    double departure_s = -infinite;
    bool may_enter = false;
    for (const wire::CrossingIntent& crossing : received.intent->crossings) {
      if (!in_chain(crossing)) continue;
      arrival_s = std::min(arrival_s, crossing.arrival_s - ago_s);
      departure_s = std::max(departure_s, crossing.departure_s - ago_s);
      may_enter = may_enter || crossing.may_enter;
    }
    if (!std::isfinite(arrival_s)) continue;
    // A vehicle that finds the crossing free again even after a slow approach has no reason to be slow.
    const double wait_s = departure_s - slow_s;
    if (wait_s <= 0.0) continue;
    // A vehicle that may enter goes first, whatever the times; of two equal vehicles that may not yet, the earlier one.
    const double priority = may_enter ? -1.0 : sign_of(own_priority - static_cast<double>(received.intent->priority));
    const double margin_s = may_enter ? -wait_s : arrival_s - own_s;
    if (priority == 0.0 && margin_s >= 0.0) continue;
    // A vehicle that is stopped before a crossing waits for a third one, or for room beyond, possibly for long.
    if (!may_enter && std::fabs(received.intent->speed_mps) < rests_mps) continue;
    if (margin_s >= others.crossing_margin_s) continue;
    others.crossing_margin_s = margin_s;
    others.crossing_priority = priority;
  }
}

void Neighbours::fold(Digest& digest) const {
  digest.add(std::uint64_t{received_.size()});
  for (const KnownIntent& received : received_) {
    digest.add(std::string_view{received.intent->vehicle.serial_number});
    digest.add(std::uint64_t{received.intent->header_id});
    digest.add(received.at);
  }
}

void Neighbours::archive(Archive& archive) {
  archive(received_);
  if (archive.reads()) oldest_at_ = SimTime::min();  // the next call of age() finds them
}

}  // namespace cosiva::aiv
