// Whose the vehicle is, where several servers share a broker: it obeys that one only, on its zone.
#include "aiv/onboard/inside.h"
#include "wire/v2x.h"

namespace cosiva::aiv {

void OnboardCore::Inside::on_owner(const wire::Input& input, wire::Effects& effects) {
  std::string next;
  if (!input.payload.empty()) {
    auto owner = wire::owner_from_json(input.payload);
    if (!owner) {
      log(effects, 'w', "whose this vehicle is cannot be read, so nothing changes: " + to_string(owner.error()));
      return;
    }
    next = std::move(owner->hall);
  }
  if (next == hall) return;
  log(effects, 'i', next.empty() ? std::string("is nobody's any more") : "is hall " + next + "'s");
  hall = std::move(next);
  topics = wire::server_topics(hall);
  // Its new server has yet to be heard, and what the old one told of its virtual world is over.
  supervision.server_left();
  if (felt) felt->forget();
  owes_answer = true;
  listen(effects);
}

void OnboardCore::Inside::listen(wire::Effects& effects) const {
  std::vector<std::string> filters;
  if (options.v2x && cell) filters = wire::v2x_filters(cell_map, *cell);
  if (!hall.empty())
    filters.insert(filters.end(), {wire::topics_below(topics.zone_prefix, 1), topics.connection, topics.heartbeat});
  effects.emplace_back(wire::Listen{std::move(filters)});
}

}  // namespace cosiva::aiv
