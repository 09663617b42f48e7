#include <algorithm>

#include "cosiva/zone/opendrive/short_sections.h"

namespace cosiva::zone::opendrive {
namespace {

// Exporters leave lane sections of a few millimetres behind, too short for any vehicle.
constexpr double short_m = 0.05;

template <typename Visit>
void each_lane(LaneSection& section, const Visit& visit) {
  for (Lane& lane : section.left) visit(lane);
  for (Lane& lane : section.right) visit(lane);
}

const Lane* find(const LaneSection& section, int id) {
  const auto& side = id > 0 ? section.left : section.right;
  const auto at = std::find_if(side.begin(), side.end(), [&](const Lane& lane) { return lane.id == id; });
  return at == side.end() ? nullptr : &*at;
}

/// The lanes that `links` lead to beyond the removed section: its lanes' own links, or, without any, the same id.
void lead_through(std::vector<int>& links, const LaneSection& removed, std::vector<int> Lane::*onward) {
  std::vector<int> through;
  for (const int id : links) {
    const Lane* lane = find(removed, id);
    if (lane == nullptr) continue;
    const auto& further = lane->*onward;
    if (further.empty())
      through.push_back(id);
    else
      through.insert(through.end(), further.begin(), further.end());
  }
  std::sort(through.begin(), through.end());
  through.erase(std::unique(through.begin(), through.end()), through.end());
  links = std::move(through);
}

/// Others refer to the lanes of the removed section by their ids: what these lead to within the road.
void rename(std::vector<std::pair<int, int>>& names, const LaneSection& removed, std::vector<int> Lane::*onward) {
  const auto onto = [&](int id) {
    const Lane* lane = find(removed, id);
    return lane == nullptr || (lane->*onward).empty() ? id : (lane->*onward).front();
  };
  if (names.empty()) {
    for (const auto* side : {&removed.left, &removed.right}) {
      for (const Lane& lane : *side) names.emplace_back(lane.id, onto(lane.id));
    }
  } else {
    for (auto& name : names) name.second = onto(name.second);
  }
}

/// @param after  the next section that stays; sections.size(): none
void drop(Road& road, std::size_t index, std::size_t after_index) {
  const LaneSection removed = std::move(road.sections[index]);
  if (index > 0) {
    each_lane(road.sections[index - 1], [&](Lane& lane) { lead_through(lane.successors, removed, &Lane::successors); });
  } else {
    rename(road.first_names, removed, &Lane::successors);
  }
  if (after_index < road.sections.size()) {
    LaneSection& after = road.sections[after_index];
    each_lane(after, [&](Lane& lane) {
      lead_through(lane.predecessors, removed, &Lane::predecessors);
      // Its records count from the same position as before.
      const double later = index == 0 ? after.s - removed.s : 0.0;
      for (auto* records : {&lane.widths, &lane.borders}) {
        for (Polynomial& record : *records) record.s += later;
      }
      for (SpeedFrom& limit : lane.speeds) limit.s += later;
    });
    if (index == 0) after.s = removed.s;
  } else {
    rename(road.last_names, removed, &Lane::predecessors);
  }
}

}  // namespace

void drop_short_sections(Network& network, Report& report) {
  for (Road& road : network.roads) {
    double end = road.plan.empty() ? 0.0 : road.plan.back().s + road.plan.back().length;
    std::vector<bool> stays(road.sections.size());
    std::size_t left = road.sections.size();
    std::size_t after = left;
    // From the end, so that each leads on to one that stays.
    for (std::size_t i = road.sections.size(); i-- > 0;) {
      const double length = end - road.sections[i].s;
      if (length < short_m && length >= 0.0 && left > 1) {
        drop(road, i, after);
        --left;
        continue;
      }
      end = road.sections[i].s;
      after = i;
      stays[i] = true;
    }
    if (left == road.sections.size()) continue;
    std::vector<LaneSection> kept;
    for (std::size_t i = 0; i < stays.size(); ++i) {
      if (stays[i]) kept.push_back(std::move(road.sections[i]));
    }
    road.sections = std::move(kept);
    report.add(Diagnostic::Kind::mended, "roads with lane sections of less than 5 cm", road.location,
               "has lane sections of less than 5 cm; their neighbours replace them");
  }
}

}  // namespace cosiva::zone::opendrive
