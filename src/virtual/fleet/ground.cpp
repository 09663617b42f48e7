#include "cosiva/virtual/fleet/ground.h"

#include <algorithm>
#include <cstdio>
#include <deque>
#include <string>
#include <utility>

#include "cosiva/aiv/motion/outlook.h"
#include "cosiva/zone/check/deadlock.h"
#include "cosiva/zone/routing/route.h"

namespace cosiva::virtual_side {
namespace {

/// Limits per line: the number of chains, one for each route through, and the number of sections of a chain. A zone
/// where all paths cross each other would exceed any limit.
constexpr std::size_t chains_max = 256;
constexpr std::size_t chain_sections_max = 512;
/// The number of sections examined for one line: in a net of lanes driven both ways the routes are innumerable.
constexpr std::size_t checks_max = 1U << 14U;

}  // namespace

Result<Ground> Ground::make(std::shared_ptr<const zone::TrafficZone> zone) {
  if (!zone || zone->circuit.size() == 0) return fail("fleet.zone", "a fleet needs a zone with sections");
  Ground ground;
  ground.zone_ = std::move(zone);
  ground.gap_m_ = zone::stopping_room_m(ground.zone_->vehicle);
  ground.lay_sections();
  ground.lay_defaults();
  ground.lay_parted();
  if (auto laid = ground.lay_lines(); !laid) return tl::unexpected(laid.error());
  return ground;
}

double Ground::turn_rad(zone::SectionId from, zone::SectionId to) const {
  return has_turns_ ? aiv::bend_rad(circuit(), from, to) : 0.0;
}

void Ground::lay_sections() {
  const zone::Circuit& circuit = zone_->circuit;
  for (zone::SectionId id = 0; id < circuit.size(); ++id) {
    const zone::Circuit::Part& part = circuit.part(id);
    length_m_.push_back(part.section.length_m());
    limit_mps_.push_back(part.speed_mps_max.value_or(far_m));
    has_limits_ |= part.speed_mps_max.has_value();
    has_turns_ |= part.pivots;
  }
  spans_.resize(size());
  for (std::uint32_t x = 0; x < zone_->crossings.size(); ++x)
    for (const zone::CrossingSpan& span : zone_->crossings[x].spans)
      spans_[span.section].push_back({span.from_m, span.to_m, x});
  for (auto& spans : spans_)
    std::ranges::sort(spans, [](const Span& a, const Span& b) {
      return a.from_m != b.from_m ? a.from_m < b.from_m : a.crossing < b.crossing;
    });
}

void Ground::lay_defaults() {
  const zone::Circuit& circuit = zone_->circuit;
  const std::vector<bool> for_ever = zone::Router{*zone_}.goes_on_for_ever(zone_->closed);
  const std::vector<zone::SectionId> back = zone::opposites(*zone_);
  default_next_.assign(size(), zone::no_section);
  for (zone::SectionId id = 0; id < size(); ++id) {
    const auto branches = circuit.next(id);
    // A vehicle turns back only if it cannot drive on.
    auto best =
        std::ranges::find_if(branches, [&](zone::SectionId branch) { return for_ever[branch] && branch != back[id]; });
    if (best == branches.end())
      best = std::ranges::find_if(branches, [&](zone::SectionId branch) { return for_ever[branch]; });
    if (!branches.empty()) default_next_[id] = best != branches.end() ? *best : branches.front();
  }
  if (zone_->loops.empty()) return;
  // Along the loop, and from everywhere else to it with the fewest sections.
  const std::vector<zone::SectionId>& loop = zone_->loops.front().sections;
  std::vector<bool> known(size(), false);
  std::deque<zone::SectionId> found;
  for (std::size_t i = 0; i < loop.size(); ++i) {
    if (known[loop[i]]) continue;
    default_next_[loop[i]] = loop[(i + 1) % loop.size()];
    known[loop[i]] = true;
    found.push_back(loop[i]);
  }
  for (; !found.empty(); found.pop_front()) {
    for (const zone::SectionId before : circuit.previous(found.front())) {
      if (known[before]) continue;
      known[before] = true;
      default_next_[before] = found.front();
      found.push_back(before);
    }
  }
}

void Ground::lay_parted() {
  const zone::Circuit& circuit = zone_->circuit;
  parted_m_.assign(size(), 0.0);
  for (zone::SectionId id = 0; id < size(); ++id) {
    const bool is_branch = std::ranges::any_of(circuit.previous(id),
                                               [&](zone::SectionId before) { return circuit.next(before).size() > 1; });
    if (!is_branch) continue;
    double parted = 0.5 * zone_->vehicle.length_m;
    for (const Span& span : spans_[id])
      if (span.from_m <= left_m) parted = std::max(parted, span.to_m + left_m);
    parted_m_[id] = std::min(parted, length_m_[id]);
  }
}

Result<void> Ground::lay_lines() {
  for (zone::SectionId id = 0; id < size(); ++id) {
    first_line_.push_back(static_cast<std::uint32_t>(lines_.size()));
    double busy_m = -1.0;
    for (const Span& span : spans_[id]) {
      if (span.from_m <= busy_m) {
        busy_m = std::max(busy_m, span.to_m);
        continue;
      }
      busy_m = span.to_m;
      const auto first = static_cast<std::uint32_t>(chains_.size());
      Laying laying{{id}, {}, 0.0, span.from_m};
      Search search{first + chains_max, checks_max};
      if (!follow(laying, span.from_m, span.from_m, search) || search.is_over(chains_.size()))
        return no_stopping_position(id);
      lines_.push_back({span.from_m, first, static_cast<std::uint32_t>(chains_.size()) - first});
    }
  }
  first_line_.push_back(static_cast<std::uint32_t>(lines_.size()));
  return defaults_have_chains();
}

Result<void> Ground::defaults_have_chains() const {
  const auto is_default = [this](const Chain& chain) {
    const auto sections = sections_of(chain);
    for (std::size_t k = 1; k < sections.size(); ++k)
      if (default_next_[sections[k - 1]] != sections[k]) return false;
    return true;
  };
  for (zone::SectionId id = 0; cuts_ && id < size(); ++id)
    for (const Line& line : lines(id))
      if (std::ranges::none_of(std::span(chains_).subspan(line.first_chain, line.chains), is_default))
        return no_stopping_position(id);
  return {};
}

tl::unexpected<Error> Ground::no_stopping_position(zone::SectionId section) const {
  char room_text[32];
  std::snprintf(room_text, sizeof room_text, "%.2f m", gap_m_);
  const std::string room = room_text;
  const zone::SectionId back = zone::opposites(*zone_)[section];
  const std::string why =
      back == zone::no_section
          ? "from here on vehicles cannot stop between them; leave " + room + " between two of them"
          : "this section and '" + circuit().part(back).name +
                "' are one track driven both ways, and vehicles on it cannot stop next to it; let the route lead "
                "over sections next to the track that have " +
                room + " outside crossings, or give each direction a lane of its own";
  return fail("fleet.zone",
              "too many crossings close together to be reserved at once: " + why +
                  "; `cosiva zone check` lists these (zone.single_track, deadlock.loop, deadlock.no_room)",
              "zone '" + zone_->name + "', section '" + circuit().part(section).name + "'");
}

bool Ground::follow(Laying& laying, double from_m, double entry_m, Search& search) {
  const zone::SectionId here = laying.sections.back();
  for (const Span& span : spans_[here]) {
    if (span.from_m < from_m) continue;
    const double at_m = laying.start_m + span.from_m;
    if (at_m - laying.exit_m >= gap_m_) {
      finish(laying, entry_m);
      return true;
    }
    const double to_m = laying.start_m + span.to_m;
    const auto known = std::ranges::find(laying.leaves, span.crossing, &Leave::crossing);
    if (known == laying.leaves.end())
      laying.leaves.push_back({span.crossing, to_m});
    else
      known->at_m = std::max(known->at_m, to_m);
    laying.exit_m = std::max(laying.exit_m, to_m);
  }
  const double end_m = laying.start_m + length_m_[here];
  const auto branches = circuit().next(here);
  if (end_m - laying.exit_m >= gap_m_ || branches.empty()) {
    finish(laying, entry_m);
    return true;
  }
  if (laying.sections.size() >= chain_sections_max || search.is_over(chains_.size())) return false;
  bool leads_on = false;
  for (const zone::SectionId branch : branches) {
    // No vehicle needs to return within the crossings that it holds, nor in and out of a dead end repeatedly; such a
    // chain would have no end.
    bool follows = std::ranges::find(laying.sections, branch) == laying.sections.end();
    if (follows) {
      Laying on = laying;
      on.sections.push_back(branch);
      on.start_m = end_m;
      --search.checks_left;
      follows = follow(on, 0.0, entry_m, search);
    }
    if (search.is_over(chains_.size())) return false;
    leads_on |= follows;
    cuts_ |= !follows;
  }
  return leads_on;
}

void Ground::finish(const Laying& laying, double entry_m) {
  Chain chain{static_cast<std::uint32_t>(chain_sections_.size()), 0,       static_cast<std::uint32_t>(leaves_.size()),
              static_cast<std::uint32_t>(laying.leaves.size()),   entry_m, laying.exit_m};
  // The sections up to the exit; sections examined only for another crossing do not count.
  double start_m = 0.0;
  for (const zone::SectionId section : laying.sections) {
    if (chain.sections > 0 && start_m >= laying.exit_m) break;
    chain_sections_.push_back(section);
    ++chain.sections;
    start_m += length_m_[section];
  }
  leaves_.insert(leaves_.end(), laying.leaves.begin(), laying.leaves.end());
  std::stable_sort(leaves_.begin() + chain.first_leave, leaves_.end(),
                   [](const Leave& a, const Leave& b) { return a.at_m < b.at_m; });
  chains_.push_back(chain);
}

bool Ground::may_stop(zone::TrackPosition position) const {
  if (!zone_->may_stop(position)) return false;
  return std::ranges::none_of(spans_[position.section], [&](const Span& span) {
    return position.s_m > span.from_m - 0.005 && position.s_m < span.to_m + left_m;
  });
}

std::size_t Ground::bytes() const {
  std::size_t bytes = sizeof(Ground) + size() * (2 * sizeof(double) + sizeof(zone::SectionId) + sizeof(double));
  for (const auto& spans : spans_) bytes += sizeof(std::vector<Span>) + spans.capacity() * sizeof(Span);
  bytes += first_line_.capacity() * sizeof(std::uint32_t) + lines_.capacity() * sizeof(Line);
  bytes += chains_.capacity() * sizeof(Chain) + chain_sections_.capacity() * sizeof(zone::SectionId);
  return bytes + leaves_.capacity() * sizeof(Leave);
}

}  // namespace cosiva::virtual_side
