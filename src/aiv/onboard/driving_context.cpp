#include "cosiva/aiv/onboard/driving_context.h"

#include <utility>

#include "cosiva/base/archive.h"
#include "cosiva/base/expect.h"
#include "cosiva/zone/edit/edit.h"

namespace cosiva::aiv {
namespace {

std::unique_ptr<SpeedPolicy> speed_policy_of(const OnboardOptions& options, const zone::TrafficZone& zone) {
  auto policy = make_speed_policy(options.rules, zone.profiles);
  COSIVA_EXPECT(policy);  // the rules were read when the options were made
  return std::move(*policy);
}

}  // namespace

DrivingContext::DrivingContext(const zone::TrafficZone& zone, const OnboardOptions& options)
    : zone_{std::make_shared<zone::TrafficZone>(zone)},
      agent_{*zone_, speed_policy_of(options, *zone_), Lateness::of(options.cycle), options.actions},
      virtual_bodies_{*zone_},
      neighbours_{*zone_, options.id},
      crossings_{*zone_} {
  if (options.link_loss == LinkLoss::finish_base) base_watch_.emplace(*zone_);
  if (options.autonomy == Autonomy::negotiate) negotiation_.emplace(*zone_, options.id);
}

DrivingContext::DrivingContext(const zone::TrafficZone& zone, const OnboardOptions& options, const Agent& before)
    : DrivingContext{zone, options} {
  COSIVA_EXPECT(before.vehicle().motion().stopped());
  agent_.take_over(before);
}

void DrivingContext::adopt_fiducials(const zone::TrafficZone& edited) {
  COSIVA_EXPECT(zone::same_geometry(*zone_, edited));
  // Field by field into the same object: all parts find tags and beacons in this object when one is read.
  zone_->tags = edited.tags;
  zone_->beacons = edited.beacons;
  zone_->stations = edited.stations;
  zone_->starts = edited.starts;
  zone_->priorities = edited.priorities;
  zone_->loops = edited.loops;
  zone_->closed = edited.closed;
  zone_->diagnostics = edited.diagnostics;
  agent_.vehicle().estimator().forget_doubt();
}

void DrivingContext::archive(Archive& archive) {
  // The zone was made from the configuration in force, except for these, which an edit of fiducials leaves as they are.
  archive(zone_->edges_are_sections, zone_->clearance_m, zone_->spacing_m, zone_->nodes_only);
  archive(agent_, virtual_bodies_, neighbours_, sighting_);
  if (base_watch_) archive(*base_watch_);
}

}  // namespace cosiva::aiv
