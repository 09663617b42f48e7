#include "cosiva/virtual/server/right_of_way/closed_sections.h"

#include <algorithm>
#include <functional>
#include <iterator>
#include <utility>

#include "cosiva/base/archive.h"
#include "cosiva/base/expect.h"

namespace cosiva::virtual_side {

void ClosedSections::configure(std::vector<zone::SectionId> sections) {
  configured_ = std::move(sections);
  closed_ = configured_;
}

void ClosedSections::set(std::vector<zone::SectionId> sections) {
  closed_ = std::move(sections);
  std::ranges::sort(closed_);
  closed_.erase(std::unique(closed_.begin(), closed_.end()), closed_.end());
  COSIVA_EXPECT(std::ranges::adjacent_find(closed_, std::greater_equal{}) == closed_.end());
}

bool ClosedSections::contains(zone::SectionId section) const { return std::ranges::binary_search(closed_, section); }

std::vector<zone::SectionId> ClosedSections::with(Sections avoided) const {
  std::vector<zone::SectionId> all;
  all.reserve(closed_.size() + avoided.size());
  std::ranges::set_union(closed_, avoided, std::back_inserter(all));
  return all;
}

std::vector<std::string> ClosedSections::names(const WaypointGraph* map) const {
  std::vector<std::string> names;
  if (map != nullptr)
    for (const zone::SectionId section : closed_) names.push_back(map->circuit().part(section).name);
  return names;
}

void ClosedSections::archive(Archive& archive) { archive(closed_, configured_); }

}  // namespace cosiva::virtual_side
