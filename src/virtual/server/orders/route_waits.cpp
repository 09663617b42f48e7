#include "cosiva/virtual/server/orders/route_waits.h"

#include <algorithm>
#include <chrono>
#include <numeric>

#include "cosiva/base/archive.h"
#include "cosiva/base/expect.h"

namespace cosiva::virtual_side {
namespace {

constexpr std::uint32_t longest_s = 24 * 3600;  // longer waits count as this

}  // namespace

void RouteWaits::record(VehicleIndex vehicle, std::optional<Route> route, SimTime now) {
  Vehicle& known = vehicles_[vehicle];
  const bool same_goal = route && known.goal == route->goal;
  if (same_goal && std::min(route->steps, route->next) >= known.nearest) {
    longest_ = std::max(longest_, now - known.since);
    return;
  }
  if (known.goal) end_wait(known, now);
  known.since = now;
  known.goal.reset();
  if (!route) return;
  known.has_route = true;
  known.nearest = same_goal ? std::min(known.nearest, route->steps) : route->steps;
  known.goal = route->goal;
}

void RouteWaits::end_wait(Vehicle& vehicle, SimTime now) {
  const auto waited_s = std::chrono::duration_cast<std::chrono::seconds>(now - vehicle.since).count();
  if (waited_s < counted_s_min) return;
  const auto seconds = static_cast<std::uint32_t>(std::min<std::int64_t>(waited_s, longest_s));
  ended_.resize(std::max<std::size_t>(ended_.size(), seconds + std::size_t{1}));
  ++ended_[seconds];
  COSIVA_EXPECT(ended_.front() == 0);
}

std::uint32_t RouteWaits::p99_s() const {
  const auto all = std::accumulate(ended_.begin(), ended_.end(), std::uint64_t{0});
  std::uint64_t up_to = 0;
  for (std::uint32_t s = 0; s < ended_.size(); ++s) {
    up_to += ended_[s];
    if (100 * up_to >= 99 * all && all > 0) return s + 1;
  }
  return 0;
}

void RouteWaits::write(JsonWriter& json) const {
  std::uint32_t arrivals = 0;
  std::optional<std::uint32_t> least;
  for (const Vehicle& vehicle : vehicles_) {
    arrivals += vehicle.arrivals;
    if (vehicle.has_route) least = std::min(least.value_or(vehicle.arrivals), vehicle.arrivals);
  }
  json.begin_object()
      .field("waits", std::accumulate(ended_.begin(), ended_.end(), std::uint64_t{0}))
      .field("wait_p99_s", p99_s())
      .field("longest_wait_s", to_seconds(longest_))
      .field("arrivals", arrivals)
      .field("least_arrivals", least.value_or(0))
      .end_object();
}

void RouteWaits::archive(Archive& archive) { archive(vehicles_, ended_, longest_); }

}  // namespace cosiva::virtual_side
