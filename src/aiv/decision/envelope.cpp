#include "cosiva/aiv/decision/envelope.h"

#include <algorithm>
#include <cmath>

#include "cosiva/aiv/motion/speed.h"

namespace cosiva::aiv {
namespace {

/// The last part of the path to a bend is driven at creep speed: PILS turns where it detects the joint, whatever the
/// estimate.
constexpr double bend_margin_m = 0.015;
/// Rounding between the distances of the order and of the crossing.
constexpr double rounding_m = 0.005;
/// Look-ahead beyond the vehicle's stopping distance.
constexpr double look_ahead_m = 0.5;

/// Within this distance a crossing is an input of the rules: further than the envelope needs, because vehicles in a
/// queue before it must not fall back.
constexpr double foreseen_within_m = 1.6;

using plain::speed_before;

}  // namespace

CrossingLookAhead::CrossingLookAhead(const zone::TrafficZone& zone)
    : circuit_{zone.circuit}, gap_m_{zone::stopping_room_m(zone.vehicle)}, spans_(zone.circuit.size()) {
  for (const zone::Crossing& crossing : zone.crossings) {
    for (const zone::CrossingSpan& span : crossing.spans) spans_[span.section].push_back({span.from_m, span.to_m});
  }
  for (auto& spans : spans_) {
    std::ranges::sort(spans, {}, &Span::from_m);
    std::size_t last = 0;
    for (std::size_t i = 1; i < spans.size(); ++i) {
      if (spans[i].from_m <= spans[last].to_m) {
        spans[last].to_m = std::max(spans[last].to_m, spans[i].to_m);
      } else {
        spans[++last] = spans[i];
      }
    }
    if (!spans.empty()) spans.resize(last + 1);
  }
}

CrossingLookAhead::Chain CrossingLookAhead::first(const Outlook& outlook, double reach_m) const {
  Chain chain;
  bool found = false;
  double start_m = -outlook.here.s_m;  // of the present section, relative to the vehicle
  double busy_until_m = 0.0;           // the end of the span that the vehicle is in
  zone::SectionLookAhead ahead = section_look_ahead(circuit_, outlook);
  // Two rounds are more than any chain needs; this limit ends the search on a loop that is one chain.
  for (std::size_t steps = 0; steps < 2 * circuit_.size(); ++steps) {
    for (const Span& span : spans_[ahead.section()]) {
      const double from_m = start_m + span.from_m;
      const double to_m = start_m + span.to_m;
      if (found) {
        if (from_m - chain.exit_m >= gap_m_) return chain;
        chain.exit_m = std::max(chain.exit_m, to_m);
      } else if (from_m <= busy_until_m) {
        // Entered already, or the same crossing continues over the joint of two sections.
        if (to_m > 0.0) busy_until_m = std::max(busy_until_m, to_m);
      } else {
        if (from_m > reach_m) return chain;
        chain = {from_m, to_m};
        found = true;
      }
    }
    start_m += circuit_.section(ahead.section()).length_m();
    if (start_m > (found ? chain.exit_m + gap_m_ : reach_m)) return chain;
    if (!ahead.step()) return chain;
  }
  return chain;
}

double CrossingLookAhead::passed_m(const Outlook& outlook, double reach_m) const {
  zone::SectionId section = outlook.here.section;
  double here_m = outlook.here.s_m;  // the vehicle, from the start of `section`
  for (std::size_t steps = 0; steps < circuit_.size(); ++steps) {
    for (auto span = spans_[section].rbegin(); span != spans_[section].rend(); ++span)
      if (span->from_m <= here_m) return std::max(0.0, here_m - span->to_m);
    const auto previous = circuit_.previous(section);
    if (previous.empty() || here_m > reach_m) break;
    section = previous.front();
    here_m += circuit_.section(section).length_m();
  }
  return std::numeric_limits<double>::infinity();
}

Lateness Lateness::of(SimDuration cycle) {
  // The parts of the usual delays: a tick of 20 ms, and a frame of the obstacle sensor every 60 ms.
  constexpr SimDuration usual_tick = std::chrono::milliseconds{20};
  constexpr SimDuration usual_scan = std::chrono::milliseconds{60};
  const double slower_s = to_seconds(std::max(cycle, usual_tick) - usual_tick);
  return {reaction_s + slower_s, obstacle_reaction_s + slower_s + to_seconds(std::max(cycle, usual_scan) - usual_scan)};
}

Envelope::Envelope(const zone::TrafficZone& zone, Lateness late)
    : zone_{zone},
      late_{late},
      crossings_{zone},
      braking_mps2_max_{std::max(
          {zone.profiles.slow.braking_mps2, zone.profiles.medium.braking_mps2, zone.profiles.fast.braking_mps2})},
      sections_have_limits_{false},
      has_bends_{false} {
  for (zone::SectionId id = 0; id < zone.circuit.size(); ++id) {
    sections_have_limits_ |= zone.circuit.part(id).speed_mps_max.has_value();
    has_bends_ |= zone.circuit.part(id).pivots;
  }
}

Limit Envelope::limit(const View& view, const zone::SpeedProfile& target_speed) const {
  const double braking = target_speed.braking_mps2;
  const double speed = std::fabs(view.speed_mps);
  const double reach_m = speed * speed / (2.0 * braking) + speed * late_.command_s + look_ahead_m;

  double end_m = view.order.distance_to_base_end_m();
  Limit limit{target_speed.speed_mps, braking, false, std::numeric_limits<double>::infinity()};
  const auto chain = crossings_.first(view.outlook, reach_m);
  const bool leads_through = end_m >= chain.exit_m - rounding_m;
  const bool ends_there_on_purpose = !view.order.horizon_left();
  if (!leads_through && !ends_there_on_purpose) {
    limit.crossing_ahead_m = chain.entry_m;
    if (chain.entry_m < end_m) end_m = std::max(0.0, chain.entry_m - stop_line_m);
  }
  if (view.barrier_m < limit.crossing_ahead_m && view.barrier_m <= reach_m) {
    limit.crossing_ahead_m = view.barrier_m;
    if (view.barrier_m < end_m) end_m = std::max(0.0, view.barrier_m - stop_line_m);
  }
  // Whether a crossing may be entered is the order's matter; within it a commanded move may end anywhere.
  end_m = std::min(end_m, std::max(0.0, view.path_left_m));
  limit.end_m = end_m;
  const double obstacle_m = view.obstacle_ahead_m - clearance_m;

  limit.speed_mps = std::min(limit.speed_mps, stoppable_speed(end_m, braking, late_.command_s));
  if (sections_have_limits_)
    limit.speed_mps = std::min(limit.speed_mps, section_limit_mps(view, target_speed, reach_m));
  if (has_bends_) {
    limit.bend_ahead_m = bend_ahead_m(view.outlook, reach_m);
    limit.speed_mps =
        std::min(limit.speed_mps, speed_before(bend_creep_mps, limit.bend_ahead_m - bend_margin_m, braking));
  }
  limit.speed_mps = std::min(limit.speed_mps, edge_limit_mps(view, target_speed));
  const double obstacle_speed = stoppable_speed(obstacle_m, braking, late_.obstacle_s);
  if (obstacle_speed < limit.speed_mps) {
    limit.speed_mps = obstacle_speed;
    limit.by_obstacle = true;
  }
  // A base, a crossing or an obstacle that came nearer than the profile can brake for (a slower profile has weaker
  // brakes): the vehicle brakes as hard as possible.
  const double hard_m = std::min(end_m, obstacle_m);
  if (speed > 0.0 && plain::brakes_hard(speed, hard_m, braking)) limit.braking_mps2 = braking_mps2_max_;
  return limit;
}

double Envelope::foreseen_m(const Outlook& outlook, const OrderBook& order) const {
  const auto chain = crossings_.first(outlook, foreseen_within_m);
  const bool leads_through = order.distance_to_base_end_m() >= chain.exit_m - rounding_m;
  return leads_through || !order.horizon_left() ? std::numeric_limits<double>::infinity() : chain.entry_m;
}

double Envelope::passed_m(const Outlook& outlook) const { return crossings_.passed_m(outlook, foreseen_within_m); }

Limit Envelope::limit_off_path(double obstacle_ahead_m, const zone::SpeedProfile& target_speed) const {
  const double room_mps = stoppable_speed(obstacle_ahead_m - clearance_m, target_speed.braking_mps2, late_.obstacle_s);
  return {std::min(target_speed.speed_mps, room_mps), target_speed.braking_mps2, room_mps < target_speed.speed_mps,
          std::numeric_limits<double>::infinity()};
}

double Envelope::section_limit_mps(const View& view, const zone::SpeedProfile& target_speed, double reach_m) const {
  const zone::Circuit& circuit = zone_.circuit;
  double limit_mps = std::numeric_limits<double>::infinity();
  double start_m = -view.outlook.here.s_m;
  zone::SectionLookAhead ahead = section_look_ahead(circuit, view.outlook);
  while (start_m <= reach_m) {
    if (const auto& section_mps = circuit.part(ahead.section()).speed_mps_max)
      limit_mps = std::min(limit_mps, speed_before(*section_mps, std::max(0.0, start_m), target_speed.braking_mps2));
    start_m += circuit.section(ahead.section()).length_m();
    if (!ahead.step()) break;
  }
  return limit_mps;
}

double Envelope::bend_ahead_m(const Outlook& outlook, double reach_m) const {
  const zone::Circuit& circuit = zone_.circuit;
  double end_m = -outlook.here.s_m;
  zone::SectionLookAhead ahead = section_look_ahead(circuit, outlook);
  for (;;) {
    const zone::SectionId from = ahead.section();
    end_m += circuit.section(from).length_m();
    if (end_m > reach_m || !ahead.step()) return std::numeric_limits<double>::infinity();
    if (bend_rad(circuit, from, ahead.section()) != 0.0) return std::max(0.0, end_m);
  }
}

double Envelope::edge_limit_mps(const View& view, const zone::SpeedProfile& target_speed) const {
  double limit_mps = std::numeric_limits<double>::infinity();
  double starts_m = 0.0;  // of the edge, relative to the vehicle
  for (const OrderBook::Target& target : view.order.targets()) {
    if (target.max_speed_mps)
      limit_mps = std::min(limit_mps, speed_before(*target.max_speed_mps, starts_m, target_speed.braking_mps2));
    if (!target.node.released) break;
    starts_m = std::max(0.0, target.path_m - view.order.travelled_m());
  }
  return limit_mps;
}

}  // namespace cosiva::aiv
