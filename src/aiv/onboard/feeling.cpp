// What is only virtual and felt all the same (Ahead, Felt), and what the vehicle tells of what it sees and of its
// boards.
#include <algorithm>
#include <utility>

#include "aiv/onboard/inside.h"

namespace cosiva::aiv {
namespace {

/// While there is anything to feel it says so at least this often.
constexpr SimDuration answer_again = std::chrono::seconds{1};

}  // namespace

void OnboardCore::Inside::on_ahead(const wire::Input& input, wire::Effects& effects) {
  if (!agent || input.flag) return;  // a retained one is from who knows when
  auto ahead = wire::ahead_from_json(input.payload);
  if (!ahead)
    return complain_of_ahead(ahead.error().code + " " + ahead.error().place, to_string(ahead.error()), effects);
  if (ahead->map_id != zone->name)
    return complain_of_ahead("map", "it is of map '" + ahead->map_id + "', this is '" + zone->name + "'", effects);
  // A number that runs backwards is another server's, which does not know yet that this vehicle feels. And any answer
  // may have been lost on its way.
  const bool first = owes_answer || !felt->informed() || ahead->header_id < felt->header_id();
  const bool old_answer = now - told.decided >= answer_again || now < told.decided;
  const bool others = felt->hear(now, std::move(*ahead));
  owes_answer = false;
  drive(effects);
  const bool told_now = told.decided == now && told.ahead_header_id == felt->header_id();
  const bool other_body = agent->braking_for_felt() && contact.body != told.body;
  if (!told_now && (first || old_answer || others || other_body)) tell_felt(effects);
}

void OnboardCore::Inside::complain_of_ahead(std::string kind, std::string_view why, wire::Effects& effects) {
  constexpr std::size_t kinds_max = 16;
  if (ahead_complaints.size() == kinds_max || std::ranges::find(ahead_complaints, kind) != ahead_complaints.end())
    return;
  ahead_complaints.push_back(std::move(kind));
  log(effects, 'w', "ahead not used: " + std::string(why));
}

void OnboardCore::Inside::drive(wire::Effects& effects) {
  supervise();
  // Who is cut off from its server cannot be told that something went; and it stands.
  if (supervision.server_lost(now))
    felt->excuse_silence(now);
  else
    felt->age(now);
  contact = agent->position().known() ? felt->first(now, agent->position().outlook()) : FeltWorld::Contact{};
  agent->feel(contact.gap_m);
  agent->heed(look_around());
  boards.send(wire::Board::PILS, agent->decide(), effects);
  if (agent->braking_for_felt() != told.braking) tell_felt(effects);
}

void OnboardCore::Inside::tell_felt(wire::Effects& effects) {
  told = {felt->header_id(), now, agent->braking_for_felt(), {}, std::nullopt};
  if (told.braking) {
    told.body = std::string(contact.body);
    told.distance_m = contact.gap_m;
  }
  session.publish(told, effects);
}

void OnboardCore::Inside::tell_seen(wire::Effects& effects) {
  if (!agent || !agent->position().known() || !ranges) return;
  const Pose2 X_BS{0.5 * zone->vehicle.length_m, 0.0, 0.0};
  auto seen = sighting.on_frame(now, agent->look(), *ranges, agent->position().pose() * X_BS, agent->look_reach_m());
  if (!seen) return;
  seen->map_id = zone->name;
  session.publish(now, std::move(*seen), effects);
}

}  // namespace cosiva::aiv
