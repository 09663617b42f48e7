// V2X: what the vehicle says to those near it, and what it makes of what they say (docs/protocols/v2x.md).
#include <algorithm>
#include <utility>

#include "aiv/onboard/inside.h"
#include "wire/heard_intents.h"

namespace cosiva::aiv {
namespace {

/// Nobody answered yet: just so often that somebody who comes is found in time.
constexpr SimDuration alone_period = std::chrono::seconds{1};
constexpr SimDuration moving_period = std::chrono::milliseconds{200};
constexpr SimDuration standing_period = std::chrono::milliseconds{500};
/// What changes is told at once, but never more often than this.
constexpr SimDuration period_min = std::chrono::milliseconds{100};

}  // namespace

void OnboardCore::Inside::listen_around(wire::Effects& effects) {
  if (!agent->position().pose_known()) return;
  const Point2 here = position(agent->position().pose());
  if (cell && cell_map == zone->name && wire::outside_cell_m(*cell, here) <= wire::v2x_cell_slack_m) return;
  cell = wire::cell_of(here);
  cell_map = zone->name;
  listen(effects);
}

void OnboardCore::Inside::on_intent(const wire::Input& input, wire::Effects& effects) {
  // A retained one is from who knows when; one that comes before this vehicle knows where it is was not asked for.
  if (!options.v2x || !neighbours || input.flag || !agent->position().pose_known()) return;
  const auto topic = wire::parse_v2x_topic(input.source);
  if (!topic) return;
  auto intent = wire::heard_intent(input);
  if (!intent) {
    ++intents_refused;
    return complain_of_v2x(intent.error().code + " " + intent.error().place, input.source, to_string(intent.error()),
                           effects);
  }
  const auto verdict = neighbours->hear(now, *topic, std::move(*intent), position(agent->position().pose()));
  using enum Neighbours::Verdict;
  if (verdict == first) intent_due = true;
  // The network repeats and overtakes, and its own words come back where it listens: no reason to complain.
  const bool own_words = verdict == own && topic->vehicle == options.id;
  if (verdict == taken || verdict == first || verdict == old || own_words) return;
  ++intents_refused;
  complain_of_v2x(std::string(to_string(verdict)), input.source, to_string(verdict), effects);
}

void OnboardCore::Inside::complain_of_v2x(std::string kind, std::string_view topic, std::string_view why,
                                          wire::Effects& effects) {
  constexpr std::size_t kinds_max = 16;
  constexpr std::size_t topic_bytes_max = 120;
  if (v2x_complaints.size() == kinds_max || std::ranges::find(v2x_complaints, kind) != v2x_complaints.end()) return;
  v2x_complaints.push_back(std::move(kind));
  log(effects, 'w', "intent on '" + std::string(topic.substr(0, topic_bytes_max)) + "' not used: " + std::string(why));
}

Others OnboardCore::Inside::look_around() {
  if (!agent->heeds_others() || !agent->position().known() || agent->position().off_line()) return {};
  return neighbours->around(now, *agent);
}

void OnboardCore::Inside::tell_intent(wire::Effects& effects) {
  if (!session.online() || !cell || !agent->position().pose_known()) return;
  const SimDuration since = intent_sent ? now - *intent_sent : SimDuration::max();
  if (since >= SimDuration::zero() && since < period_min) return;
  neighbours->age(now);
  const bool alone = neighbours->empty();
  const SimDuration period = alone ? alone_period : agent->standing() ? standing_period : moving_period;
  const bool due = intent_due || since >= period || since < SimDuration::zero();
  if (!due && alone) return;
  const auto priority =
      static_cast<std::uint32_t>(std::clamp(zone->priority_of(wire::to_string(options.id)), 0, zone::priority_max));
  if (!due && said_intent.priority == priority && !is_news(said_intent, *agent, *zone, *passages)) return;
  wire::Intent intent = compose_intent(*agent, *zone, *passages);
  intent.vehicle = options.id;
  intent.priority = priority;
  intent_due = false;
  intent_sent = now;
  said_intent = intent;
  session.publish(now, *cell, std::move(intent), effects);
}

}  // namespace cosiva::aiv
