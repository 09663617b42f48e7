#include "cosiva/aiv/perception/perceived_world.h"

#include <algorithm>
#include <utility>

#include "cosiva/base/archive.h"
#include "cosiva/base/expect.h"

namespace cosiva::aiv {

PerceivedWorld::PerceivedWorld(const zone::TrafficZone& zone, Model model)
    : model_{model}, gap_{zone, model.gap_model} {}

bool PerceivedWorld::receive(SimTime now, wire::VirtualObstacles ahead) {
  const auto was_there = [this](const wire::Body& body) {
    return std::ranges::find(ahead_.bodies, body.id, &wire::Body::id) != ahead_.bodies.end();
  };
  const bool same = ahead.bodies.size() == ahead_.bodies.size() && std::ranges::all_of(ahead.bodies, was_there);
  ahead_ = std::move(ahead);
  received_at_ = now;
  news_at_ = now;
  return !same;
}

void PerceivedWorld::forget() {
  ahead_.bodies.clear();
  news_at_.reset();
}

void PerceivedWorld::age(SimTime now) {
  if (news_at_ && now - *news_at_ > model_.memory_span) forget();
}

PerceivedWorld::Contact PerceivedWorld::first(SimTime now, const Outlook& outlook) {
  Contact contact;
  if (ahead_.bodies.empty()) return contact;
  COSIVA_EXPECT(informed());
  gap_.update(outlook);
  const double carried_s = to_seconds(std::clamp(now - received_at_, SimDuration::zero(), model_.carry_max));
  for (const wire::Body& body : ahead_.bodies) {
    const double gap_m = gap_.gap_m(body, carried_s);
    if (gap_m < contact.gap_m) contact = {gap_m, body.id};
  }
  return contact;
}

void PerceivedWorld::fold(Digest& digest) const {
  digest.add(std::uint64_t{informed()});
  digest.add(std::uint64_t{ahead_.header_id});
  digest.add(std::uint64_t{ahead_.bodies.size()});
  for (const wire::Body& body : ahead_.bodies) {
    digest.add(std::string_view{body.id});
    digest.add(body.x_m);
    digest.add(body.y_m);
  }
}

void PerceivedWorld::archive(Archive& archive) { archive(ahead_, received_at_, news_at_); }

}  // namespace cosiva::aiv
