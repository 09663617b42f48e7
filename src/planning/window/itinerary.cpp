#include "cosiva/planning/window/itinerary.h"

#include <algorithm>

#include "cosiva/base/expect.h"

namespace cosiva::planning {

Itinerary::Itinerary(StateId at, std::span<const Stop> stops, const Floor& floor, Distances& distances) {
  std::span<const StateId> from{&at, 1};
  std::vector<std::uint32_t> between;
  for (const Stop& stop : stops) {
    const Distances::Steps* const to = distances.to(stop.goal);
    Distances::Steps least = Distances::unreachable;
    for (const StateId state : from) least = std::min(least, to[state]);
    if (least == Distances::unreachable) {
      complete_ = false;
      break;
    }
    legs_.push_back({to, stop.stay, 0});
    between.push_back(least);
    from = floor.goal(stop.goal);
  }
  std::uint32_t after = 0;
  for (std::size_t i = legs_.size(); i-- > 0;) {
    after += legs_[i].stay;
    legs_[i].after = after;
    after += between[i];
  }
  COSIVA_EXPECT(legs_.size() == between.size());
}

Itinerary::Progress Itinerary::next(Progress progress, StateId at) const noexcept {
  while (!done(progress)) {
    const Leg& leg = legs_[progress.leg];
    progress.at_goal = leg.to[at] == 0 ? progress.at_goal + 1 : 0;
    if (progress.at_goal == 0 || progress.at_goal <= leg.stay) break;
    progress = {progress.leg + 1, 0};
  }
  return progress;
}

std::uint32_t Itinerary::cost(std::span<const StateId> path) const noexcept {
  Progress progress = start(path[0]);
  std::uint32_t step = 0;
  for (; !done(progress) && step + 1 < path.size(); ++step) progress = next(progress, path[step + 1]);
  return step + remaining(progress, path[step]);
}

Itinerary::Progress Itinerary::end(std::span<const StateId> path) const noexcept {
  Progress progress = start(path[0]);
  for (const StateId state : path.subspan(1)) progress = next(progress, state);
  return progress;
}

}  // namespace cosiva::planning
