#include "cosiva/aiv/v2x/base_watch.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "cosiva/aiv/v2x/intent.h"
#include "cosiva/base/archive.h"
#include "cosiva/base/expect.h"

namespace cosiva::aiv {
namespace {

constexpr std::size_t crossings_max = 64;

bool is_before(const wire::VehicleId& a, const wire::VehicleId& b) {
  return a.manufacturer != b.manufacturer ? a.manufacturer < b.manufacturer : a.serial_number < b.serial_number;
}

}  // namespace

BaseWatch::BaseWatch(const zone::TrafficZone& zone, Model model)
    : zone_{zone}, model_{model}, gap_{zone, model.gap_model}, crossing_finder_{zone} {
  COSIVA_EXPECT(model.fresh > SimDuration::zero() && model.kept > model.fresh && model.count_max > 0);
}

void BaseWatch::forget_old(SimTime now) {
  // An intent received later than now is from before the clock was set back.
  std::erase_if(senders_, [&](const Sender& s) { return s.at > now || now - s.at > model_.kept; });
  if (senders_.empty()) crowded_ = false;
}

void BaseWatch::on_intent(SimTime now, std::shared_ptr<const wire::Intent> intent) {
  COSIVA_EXPECT(intent != nullptr);
  const auto name = [](const Sender& s) -> const wire::VehicleId& { return s.intent->vehicle; };
  const auto known = std::ranges::lower_bound(senders_, intent->vehicle, is_before, name);
  if (known != senders_.end() && name(*known) == intent->vehicle) {
    *known = {std::move(intent), now};
    return;
  }
  if (senders_.size() >= model_.count_max) {
    forget_old(now);
    crowded_ = senders_.size() >= model_.count_max;
    if (!crowded_) on_intent(now, std::move(intent));
    return;
  }
  senders_.insert(known, Sender{std::move(intent), now});
  COSIVA_EXPECT(senders_.size() <= model_.count_max);
}

bool BaseWatch::fresh(SimTime now, const Sender& sender) const { return now - sender.at < model_.fresh; }

bool BaseWatch::lists_crossing(const Sender& sender) const {
  return std::ranges::any_of(sender.intent->crossings, [&](const wire::CrossingIntent& crossing) {
    return std::ranges::any_of(
        on_base_, [&](const CrossingSpan& span) { return zone_.crossings[span.crossing].name == crossing.name; });
  });
}

bool BaseWatch::may_finish(SimTime now, const Agent& agent) {
  const VehicleState& vehicle = agent.vehicle();
  const PositionEstimator& position = vehicle.position();
  if (!position.known() || position.off_path() || vehicle.joining() || !vehicle.order().base_left()) return false;
  forget_old(now);
  if (crowded_) return false;
  const double base_m = vehicle.order().distance_to_base_end_m();
  // To the end of the base the vehicle's front leads its origin; behind a base there is the clearance.
  const double reach_m = base_m + clearance_m;
  if (reach_m > model_.gap_model.reach_m) return false;
  const Outlook outlook = position.outlook();
  crossing_finder_.ahead(outlook, base_m, crossings_max, on_base_);
  gap_.update(outlook);
  const double sensed_m = vehicle.watch().ahead_m(position);
  bool explained = sensed_m > reach_m;
  for (const Sender& sender : senders_) {
    const double carried_s = to_seconds(now - sender.at);
    const wire::Body body = body_of(*sender.intent, zone_.vehicle);
    const double gap_m = gap_.gap_m(body, 0.0);
    if (fresh(now, sender)) {
      explained = explained || std::fabs(gap_.gap_m(body, carried_s) - sensed_m) <= model_.same_body_m;
    } else if (gap_m <= reach_m || lists_crossing(sender)) {
      return false;
    }
  }
  return explained;
}

void BaseWatch::Sender::archive(Archive& archive) { archive(intent, at); }

void BaseWatch::archive(Archive& archive) { archive(senders_, crowded_); }

}  // namespace cosiva::aiv
