#include "cosiva/virtual/server/reports/v2x_intake.h"

#include <cmath>
#include <cstdlib>
#include <limits>

#include "cosiva/base/expect.h"
#include "cosiva/wire/in_process/received_intents.h"
#include "cosiva/wire/own/v2x.h"

namespace cosiva::virtual_side {
namespace {

/// "0.40 m/s, brakes; X1 in 0.9 s, its own".
std::string summary_of(const wire::Intent& intent) {
  std::string text = metres_text(intent.speed_mps) + " m/s";
  if (intent.braking) text += ", brakes";
  if (intent.crossings.empty()) return text;
  const wire::CrossingIntent& next = intent.crossings.front();
  text += "; " + next.name + (next.entry_m > 0.0 ? " in " + metres_text(next.arrival_s) + " s" : ", inside");
  text += next.may_enter ? ", its own" : ", not yet its own";
  return text;
}

bool adjacent(wire::Cell a, wire::Cell b) { return std::abs(a.x - b.x) <= 1 && std::abs(a.y - b.y) <= 1; }

}  // namespace

void V2xIntake::receive(const wire::Input& input) {
  if (input.flag) return;
  const std::size_t vehicles = context_.registry.size();
  if (!augmented_.hosted.empty()) augmented_.hosted.talk(context_.now, input);
  COSIVA_EXPECT(context_.registry.size() == vehicles);
  const wire::V2xTopic* topic = wire::received_v2x_topic(input.source);
  if (!topic) return;
  // A vehicle that is known only by its V2X messages does not belong to this server.
  const auto vehicle = context_.registry.find(wire::to_string(topic->vehicle));
  if (!vehicle) return;
  AivProxy& proxy = context_.registry[*vehicle];
  if (proxy.on_board.on_v2x(context_.now)) trace(proxy, input);
}

void V2xIntake::trace(AivProxy& proxy, const wire::Input& input) {
  const auto received = wire::received_intent(input);
  if (!received || (*received)->vehicle != proxy.id()) {
    proxy.counters.on_v2x_refused();
    return;
  }
  const wire::Intent& intent = **received;
  const wire::Cell cell = wire::cell_of(position(intent.pose));
  const AivProxy* nearest = nullptr;
  double nearest_m = std::numeric_limits<double>::infinity();
  std::size_t listeners = 0;
  for (const AivProxy& other : context_.registry) {
    if (&other == &proxy || !other.here() || !other.position.pose()) continue;
    if (!adjacent(cell, wire::cell_of(position(*other.position.pose())))) continue;
    ++listeners;
    const double off_m = distance(intent.pose, *other.position.pose());
    if (off_m >= nearest_m) continue;
    nearest_m = off_m;
    nearest = &other;
  }
  std::string summary = summary_of(intent);
  if (listeners > 1) summary += "; to " + std::to_string(listeners) + " near it";
  context_.traces.add(context_.now, proxy.name(),
                      nearest == nullptr ? std::string_view{"*"} : std::string_view{nearest->name()}, "V2X", summary,
                      input.source, input.payload);
}

}  // namespace cosiva::virtual_side
