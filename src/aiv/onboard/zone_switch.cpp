// Which zone is in force on board: the first one, the same with other tags, and another one while it runs.
#include <utility>

#include "aiv/onboard/inside.h"
#include "base/expect.h"
#include "zone/edit.h"

namespace cosiva::aiv {
namespace {

wire::MapInfo map_info(const std::string& name, const zone::ZoneConfiguration& configuration, bool enabled) {
  return {name, zone::version_of(configuration), {}, enabled};
}

}  // namespace

void OnboardCore::Inside::on_zone(const wire::Input& input, wire::Effects& effects) {
  // The topic of another format than the zone's is cleared by whoever changes formats.
  if (input.payload.empty()) return;
  auto announced = zone::from_payload(input.source.substr(topics.zone_prefix.size()), input.source, input.payload);
  if (!agent) return use_zone(std::move(announced), effects);
  if (coming_zone && same_content(announced, coming_zone->configuration())) return;
  if (same_content(announced, configuration)) {
    zone_refused.clear();
    return call_off_switch(effects);
  }
  auto rtm = zone::Rtm::initialise(std::move(announced));
  if (!rtm) return refuse_zone(rtm.error(), 'w', effects);
  zone_refused.clear();
  if (!zone::same_ways(*zone, rtm->zone())) return begin_switch(std::move(*rtm), effects);
  call_off_switch(effects);
  take_over_marks(*rtm, effects);
}

void OnboardCore::Inside::refuse_zone(const Error& error, char level, wire::Effects& effects) {
  zone_refused = "a zone was announced and is not used: " + to_string(error);
  state_due = true;
  log(effects, level, zone_refused);
}

void OnboardCore::Inside::take_over_marks(const zone::Rtm& edited, wire::Effects& effects) {
  // Field by field into the same object: whoever refers to the zone looks tags and beacons up when one is read.
  const zone::TrafficZone& from = edited.zone();
  zone->tags = from.tags;
  zone->beacons = from.beacons;
  zone->stations = from.stations;
  zone->starts = from.starts;
  zone->priorities = from.priorities;
  zone->loops = from.loops;
  zone->closed = from.closed;
  zone->notes = from.notes;
  configuration = edited.configuration();
  note_maps();
  agent->on_marks_moved();
  log(effects, 'i',
      "tags and beacons of '" + zone->name + "' as announced: " + std::to_string(zone->tags.size()) + " tags");
}

void OnboardCore::Inside::use_zone(zone::ZoneConfiguration first, wire::Effects& effects) {
  auto rtm = zone::Rtm::initialise(std::move(first));
  if (!rtm) return refuse_zone(rtm.error(), 'e', effects);
  zone_refused.clear();
  zone = std::make_shared<zone::TrafficZone>(rtm->zone());
  configuration = rtm->configuration();
  note_maps();
  agent.emplace(*zone, chooser_for(*zone), Lateness::of(options.cycle));
  felt.emplace(*zone);
  neighbours.emplace(*zone, options.id);
  passages.emplace(*zone);
  if (power) agent->on_charge(power->charge());
  if (memory) {
    agent->hold(Hold::paused, memory->paused);
    agent->impose(memory->imposed);
  }
  if (options.start && !zone->circuit.find(options.start->section))
    log(effects, 'e', "start: no section '" + options.start->section + "' in zone '" + zone->name + "'");
  publish_factsheet(now, effects);
  state_due = true;
}

void OnboardCore::Inside::begin_switch(zone::Rtm rtm, wire::Effects& effects) {
  log(effects, 'i', "zone '" + rtm.zone().name + "' follows '" + zone->name + "' as soon as this vehicle stands");
  coming_zone = std::move(rtm);
  agent->hold(Hold::zone_change, true);
  note_maps();
}

void OnboardCore::Inside::call_off_switch(wire::Effects& effects) {
  if (!coming_zone) return;
  log(effects, 'i', "zone '" + zone->name + "' stays");
  coming_zone.reset();
  agent->hold(Hold::zone_change, false);
  note_maps();
}

std::unique_ptr<SpeedChooser> OnboardCore::Inside::chooser_for(const zone::TrafficZone& in) const {
  auto chooser = make_chooser(options.rules, in.profiles);
  COSIVA_EXPECT(chooser);  // whoever made the options has read the rules
  return std::move(*chooser);
}

void OnboardCore::Inside::end_switch(wire::Effects& effects) {
  if (!coming_zone || !agent->standing()) return;
  end_waits();
  const std::string from = zone->name;
  auto next = std::make_shared<zone::TrafficZone>(coming_zone->zone());
  std::optional<Agent> before = std::move(agent);
  agent.emplace(*next, chooser_for(*next), Lateness::of(options.cycle));
  agent->take_over(*before);
  before.reset();
  felt.emplace(*next);
  neighbours.emplace(*next, options.id);
  passages.emplace(*next);
  zone = std::move(next);
  configuration = coming_zone->configuration();
  coming_zone.reset();
  note_maps();
  start_counts = false;

  actions.end_running(action::enable_map, wire::ActionStatus::finished);
  actions.end_running(action::cancel_order, wire::ActionStatus::finished);
  actions.end_running({}, wire::ActionStatus::failed, "the zone was switched");
  sighting = {};
  estimating.on_zone_switched();
  contact = {};
  owes_answer = true;
  ahead_complaints.clear();
  v2x_complaints.clear();
  if (memory && memory->zone == zone->name) find_place();
  must_remember = true;
  state_due = true;
  publish_factsheet(now, effects);
  const PositionEstimator& position = agent->position();
  const auto way_off = std::to_string(position.off_by_m()) + " m";
  log(effects, position.away() ? 'w' : 'i',
      "zone '" + zone->name + "' in force after '" + from + "'" +
          (position.away()     ? ", whose nearest way passes " + way_off + " from here: parked"
           : position.beside() ? ", " + way_off + " beside its nearest way"
                               : ""));
}

void OnboardCore::Inside::note_maps() {
  maps = {map_info(zone->name, configuration, true)};
  if (coming_zone) maps.push_back(map_info(coming_zone->zone().name, coming_zone->configuration(), false));
  state_due = true;
}

void OnboardCore::Inside::enable_map(const wire::Action& action, wire::Effects& effects) {
  const auto map_id = action.text("mapId");
  const auto version = action.text("mapVersion");
  if (!map_id || map_id->empty())
    return give_up(action, "instantActionError", action.action_type + " needs a mapId", effects);
  for (const wire::MapInfo& map : maps) {
    if (map.map_id != *map_id || (version && !version->empty() && *version != map.map_version)) continue;
    if (map.enabled || action.action_type == action::download_map) return finish(action);
    return actions.set(action.action_id, wire::ActionStatus::running);  // ends with the switch
  }
  give_up(action, "instantActionError",
          "map '" + *map_id + "' is not here; it comes with a message on " + topics.zone_prefix, effects);
}

}  // namespace cosiva::aiv
