#include "cosiva/virtual/server/deadlocks/deadlocks.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "cosiva/base/archive.h"
#include "cosiva/base/expect.h"
#include "cosiva/virtual/server/right_of_way/convoys.h"

namespace cosiva::virtual_side {
namespace {

constexpr std::array all_means{Means::move_up, Means::wait, Means::detour, Means::other_position, Means::back_up};

std::string deed(Means means, double cost_m) {
  switch (means) {
    case Means::move_up: return "moves up to its leader and lets its follower out of a crossing";
    case Means::wait: return "releases what it holds ahead and lets the others go first";
    case Means::detour: return "takes another route";
    case Means::other_position: return "joins the path at another position";
    case Means::back_up: return "backs up " + std::to_string(std::lround(cost_m * 100.0)) + " cm";
  }
  return {};
}

}  // namespace

std::string_view to_string(Deadlock::State state) {
  switch (state) {
    case Deadlock::State::forming: return "forming";
    case Deadlock::State::reported: return "confirmed";
    case Deadlock::State::yielding: return "yielding";
    case Deadlock::State::unresolved: return "unresolved";
    case Deadlock::State::resolved: return "resolved";
  }
  return "?";
}

void Deadlocks::tick() {
  graph_.begin(registry_.size());
  orders_.waits().add_waits(graph_);
  for (const Knot& knot : graph_.find_knots()) record(knot);
  if (forming_.empty() && open() == 0) return;
  for (Deadlock& deadlock : forming_) follow(deadlock);
  for (Deadlock& deadlock : forming_)
    if (deadlock.state != Deadlock::State::forming) list_.push_back(std::move(deadlock));
  const SimTime now = publisher_.now();
  std::erase_if(forming_, [&](const Deadlock& deadlock) {
    return deadlock.state != Deadlock::State::forming || now - deadlock.detected_at > rules_.flicker;
  });
  for (Deadlock& deadlock : list_)
    if (deadlock.state != Deadlock::State::resolved) follow(deadlock);
  for (std::size_t over = list_.size() - open(); over > kept_max; --over)
    list_.erase(std::ranges::find(list_, Deadlock::State::resolved, &Deadlock::state));
}

Deadlock* Deadlocks::find(const std::vector<VehicleIndex>& members) {
  for (auto* all : {&list_, &forming_})
    for (Deadlock& deadlock : *all)
      if (deadlock.state != Deadlock::State::resolved && intersect(deadlock.members, members)) return &deadlock;
  return nullptr;
}

void Deadlocks::record(const Knot& knot) {
  const SimTime now = publisher_.now();
  Deadlock* known = find(knot.members);
  if (known == nullptr) {
    ++counters_.cycles;
    forming_.push_back({});
    known = &forming_.back();
    known->since = known->closed_since = now;
    known->members = knot.members;
    known->reason = describe(knot);
    traces_.add(now, "AIV_Server", "AIV_Server", "cycle", known->reason);
  } else if (now - known->detected_at > rules_.flicker) {
    known->closed_since = now;
  }
  known->detected_at = now;
  if (known->members == knot.members) return;
  // The cycle has grown, or another one has developed from it; a vehicle that yields remains a member.
  std::vector<VehicleIndex> members = knot.members;
  for (const VehicleIndex v : known->yielded)
    if (!std::ranges::binary_search(members, v)) members.insert(std::ranges::lower_bound(members, v), v);
  if (members == known->members) return;
  known->members = std::move(members);
  known->reason = describe(knot);
  ++revision_;
}

std::string Deadlocks::describe(const Knot& knot) const {
  std::string text;
  for (const Wait& wait : knot.cycle) text += (text.empty() ? "" : ", ") + orders_.waits().sentence(wait);
  return text;
}

bool Deadlocks::has_vehicle_off_path(const Deadlock& deadlock) const {
  return std::ranges::any_of(deadlock.members, [&](VehicleIndex v) { return orders_.is_off_path(v); });
}

void Deadlocks::follow(Deadlock& deadlock) {
  const SimTime now = publisher_.now();
  const bool closed = now - deadlock.detected_at <= rules_.flicker;
  const SimDuration for_long = now - deadlock.closed_since;
  switch (deadlock.state) {
    case Deadlock::State::forming:
      if (closed && for_long >= (has_vehicle_off_path(deadlock) ? rules_.off_path_grace : rules_.grace))
        begin(deadlock);
      return;
    case Deadlock::State::reported: break;
    case Deadlock::State::yielding:
      if (closed && for_long >= rules_.works_within) resolve(deadlock);
      break;
    case Deadlock::State::unresolved:
      if (closed && for_long >= rules_.again_after) resolve(deadlock);
      break;
    case Deadlock::State::resolved: return;
  }
  const bool yields = std::ranges::any_of(deadlock.yielded, [&](VehicleIndex v) { return orders_.yields(v); });
  if (!yields && now - deadlock.detected_at > rules_.calm) end(deadlock);
}

void Deadlocks::begin(Deadlock& deadlock) {
  COSIVA_EXPECT(deadlock.state == Deadlock::State::forming && deadlock.number == 0);
  deadlock.number = ++counters_.detected;
  COSIVA_EXPECT(counters_.detected <= counters_.cycles);
  deadlock.state = Deadlock::State::reported;
  send('w', "deadlock " + std::to_string(deadlock.number) + ": " + deadlock.reason);
  resolve(deadlock);
}

std::vector<Wait> Deadlocks::waits_for(const Deadlock& deadlock, VehicleIndex vehicle) const {
  std::vector<Wait> waits;
  for (const Wait& wait : graph_.waits())
    if (wait.blocker == vehicle && std::ranges::binary_search(deadlock.members, wait.waiter)) waits.push_back(wait);
  return waits;
}

void Deadlocks::resolve(Deadlock& deadlock) {
  deadlock.closed_since = publisher_.now();
  std::vector<std::int32_t> priorities;
  for (const VehicleIndex v : deadlock.members) priorities.push_back(registry_[v].settings.priority());
  std::ranges::sort(priorities);
  priorities.erase(std::unique(priorities.begin(), priorities.end()), priorities.end());
  for (const std::int32_t priority : priorities)
    if (let_yield(deadlock, priority)) return;
  give_up(deadlock);
}

bool Deadlocks::let_yield(Deadlock& deadlock, std::int32_t priority) {
  for (const Means means : all_means) {
    struct Offer {
      double cost_m;
      VehicleIndex vehicle;
    };
    std::vector<Offer> offers;
    for (const VehicleIndex v : deadlock.members) {
      if (registry_[v].settings.priority() != priority ||
          std::ranges::find(deadlock.tried, std::pair{v, means}) != deadlock.tried.end())
        continue;
      const auto waits = waits_for(deadlock, v);
      if (waits.empty()) continue;
      if (const auto cost_m = orders_.can_yield(v, means, waits)) offers.push_back({*cost_m, v});
    }
    std::ranges::sort(offers, [](const Offer& a, const Offer& b) {
      return a.cost_m != b.cost_m ? a.cost_m < b.cost_m : a.vehicle > b.vehicle;
    });
    for (const auto& [cost_m, v] : offers) {
      deadlock.tried.emplace_back(v, means);
      if (!orders_.yield(v, means, waits_for(deadlock, v))) continue;
      deadlock.state = Deadlock::State::yielding;
      deadlock.yielded.push_back(v);
      const std::string how = registry_[v].name() + " " + deed(means, cost_m);
      deadlock.how = how;
      send('w', "deadlock " + std::to_string(deadlock.number) + ": " + how);
      return true;
    }
  }
  return false;
}

void Deadlocks::give_up(Deadlock& deadlock) {
  const bool first = deadlock.state != Deadlock::State::unresolved;
  deadlock.state = Deadlock::State::unresolved;
  deadlock.tried.clear();
  if (!first) return;
  deadlock.how = "none of its vehicles can yield; remove one of them, or close a section";
  send('e', "deadlock " + std::to_string(deadlock.number) + " is unresolved: " + deadlock.reason + "; " + deadlock.how);
}

void Deadlocks::end(Deadlock& deadlock) {
  COSIVA_EXPECT(deadlock.number > 0 && deadlock.state != Deadlock::State::resolved);
  const SimDuration lasted = deadlock.detected_at - deadlock.since;
  if (deadlock.state != Deadlock::State::yielding) deadlock.how = "it dissolved by itself";
  deadlock.state = Deadlock::State::resolved;
  deadlock.ended_at = deadlock.detected_at;
  ++counters_.resolved;
  COSIVA_EXPECT(counters_.resolved <= counters_.detected);
  counters_.longest = std::max(counters_.longest, lasted);
  for (const VehicleIndex v : deadlock.yielded) orders_.need_not_avoid(v);
  send('i', "deadlock " + std::to_string(deadlock.number) + " is resolved after " +
                std::to_string(std::lround(to_seconds(lasted))) + " s: " + deadlock.how);
}

void Deadlocks::forget() {
  forming_.clear();
  for (Deadlock& deadlock : list_) {
    if (deadlock.state == Deadlock::State::resolved) continue;
    end(deadlock);
    deadlock.how = "the zone was switched";
  }
}

void Deadlocks::send(char level, const std::string& text) {
  ++revision_;
  publisher_.log(level, text);
  traces_.add(publisher_.now(), "AIV_Server", "AIV_Server", "deadlock", text);
}

std::size_t Deadlocks::unresolved() const {
  return static_cast<std::size_t>(std::ranges::count(list_, Deadlock::State::unresolved, &Deadlock::state));
}

std::size_t Deadlocks::open() const {
  return list_.size() -
         static_cast<std::size_t>(std::ranges::count(list_, Deadlock::State::resolved, &Deadlock::state));
}

void Deadlocks::write_counters(JsonWriter& json) const {
  json.field("cycles", counters_.cycles)
      .field("detected", counters_.detected)
      .field("resolved", counters_.resolved)
      .field("open", static_cast<std::uint64_t>(open()))
      .field("unresolved", static_cast<std::uint64_t>(unresolved()))
      .field("longest_s", to_seconds(counters_.longest))
      .field("longest_wait_s", to_seconds(orders_.longest_wait()));
}

void Deadlocks::write(JsonWriter& json) const {
  json.begin_object();
  write_counters(json);
  json.key("list").begin_array();
  for (const auto* all : {&list_, &forming_}) {
    for (const Deadlock& deadlock : *all) {
      json.begin_object()
          .field("number", deadlock.number)
          .field("since_ms", to_milliseconds_scaled(deadlock.since))
          .field("state", to_string(deadlock.state))
          .key("members")
          .begin_array();
      for (const VehicleIndex v : deadlock.members) json.value(registry_[v].name());
      json.end_array().field("reason", deadlock.reason).field("how", deadlock.how).key("ended_ms");
      if (deadlock.ended_at)
        json.value(to_milliseconds_scaled(*deadlock.ended_at));
      else
        json.null();
      json.end_object();
    }
  }
  json.end_array().end_object();
}

void Deadlocks::fold(Digest& digest) const {
  digest.add(counters_.cycles);
  digest.add(counters_.detected);
  digest.add(counters_.resolved);
}

void Deadlocks::archive(Archive& archive) { archive(graph_, forming_, list_, counters_, revision_); }

}  // namespace cosiva::virtual_side
