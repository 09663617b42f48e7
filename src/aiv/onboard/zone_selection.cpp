#include "cosiva/aiv/onboard/zone_selection.h"

#include <utility>

#include "cosiva/base/archive.h"
#include "cosiva/base/expect.h"
#include "cosiva/zone/edit/edit.h"

namespace cosiva::aiv {
namespace {

wire::MapInfo map_info(const std::string& name, const zone::ZoneConfiguration& configuration, bool enabled) {
  return {name, zone::version_of(configuration), {}, enabled};
}

}  // namespace

ZoneSelection::Decision ZoneSelection::on_announced(const zone::ZoneConfiguration& announced,
                                                    std::shared_ptr<const zone::Rtm> built,
                                                    const zone::TrafficZone* in_force, wire::Effects& effects) {
  COSIVA_EXPECT((in_force != nullptr) == configuration_.has_value());
  if (pending_ && same_content(announced, pending_->configuration())) return {Verdict::unchanged, nullptr};
  if (in_force != nullptr && same_content(announced, *configuration_)) {
    refusal_.clear();
    return {call_off(*in_force, effects) ? Verdict::called_off : Verdict::unchanged, nullptr};
  }
  COSIVA_EXPECT(!built || built->configuration() == announced);
  if (!built) {
    auto rtm = zone::Rtm::initialise(announced);
    if (!rtm) return refuse(rtm.error(), in_force == nullptr ? 'e' : 'w', effects);
    built = std::make_shared<const zone::Rtm>(std::move(*rtm));
  }
  refusal_.clear();
  if (in_force == nullptr) return {Verdict::first, std::move(built)};
  if (zone::same_geometry(*in_force, built->zone())) {
    (void)call_off(*in_force, effects);
    return {Verdict::edited, std::move(built)};
  }
  effects.emplace_back(wire::Log{
      'i', "zone '" + built->zone().name + "' follows '" + in_force->name + "' as soon as this vehicle has stopped"});
  pending_ = std::move(built);
  list_maps();
  return {Verdict::pending, nullptr};
}

ZoneSelection::Decision ZoneSelection::refuse(const Error& error, char level, wire::Effects& effects) {
  refusal_ = "a zone was announced and is not used: " + to_string(error);
  effects.emplace_back(wire::Log{level, refusal_});
  return {Verdict::refused, nullptr};
}

bool ZoneSelection::call_off(const zone::TrafficZone& in_force, wire::Effects& effects) {
  if (!pending_) return false;
  effects.emplace_back(wire::Log{'i', "zone '" + in_force.name + "' stays"});
  pending_.reset();
  list_maps();
  return true;
}

void ZoneSelection::enforce(const zone::Rtm& rtm) {
  configuration_ = rtm.configuration();
  name_ = rtm.zone().name;
  pending_.reset();  // last: `rtm` may be the pending one
  list_maps();
}

void ZoneSelection::list_maps() {
  COSIVA_EXPECT(configuration_);
  maps_ = {map_info(name_, *configuration_, true)};
  if (pending_) maps_.push_back(map_info(pending_->zone().name, pending_->configuration(), false));
}

void ZoneSelection::archive(Archive& archive) { archive(configuration_, name_, pending_, refusal_, maps_); }

}  // namespace cosiva::aiv
