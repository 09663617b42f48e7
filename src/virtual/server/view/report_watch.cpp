#include "cosiva/virtual/server/view/report_watch.h"

#include <algorithm>
#include <utility>

#include "cosiva/base/archive.h"
#include "cosiva/base/expect.h"
#include "cosiva/virtual/server/view/decimetres.h"

namespace cosiva::virtual_side {
void ReportWatch::on_tag(SimTime now, AivProxy& proxy) {
  COSIVA_EXPECT(proxy.reported_state.last_tag().has_value());
  const std::uint32_t number = *proxy.reported_state.last_tag();
  const double shift_m = proxy.twin_link.take_shift_m(now);
  if (shift_m < displaced_m) {
    tags_.erase(number);
    return;
  }
  const auto known = tags_.find(number);
  if (known == tags_.end() && tags_.size() >= tags_max) return;
  const SimTime since = known == tags_.end() ? now : known->second.since;
  tags_[number] = {since, proxy.name(), shift_m};
}

void ReportWatch::tick(SimTime now) {
  if (std::exchange(zone_revision_, simulator_.zone_revision()) != simulator_.zone_revision()) tags_.clear();
  const bool any = !tags_.empty() || std::ranges::any_of(registry_, [now](const AivProxy& proxy) {
    return proxy.received.senders().several_since(now).has_value();
  });
  if (any || any_) simulator_.monitor().set_findings(Observer::reports, find(now));
  any_ = any;
}

std::vector<Finding> ReportWatch::find(SimTime now) const {
  std::vector<Finding> findings;
  for (const AivProxy& proxy : registry_) {
    if (const auto since = proxy.received.senders().several_since(now))
      findings.push_back({Finding::Kind::two_programs, proxy.name(), "two programs report under this name", *since});
  }
  for (const auto& [number, tag] : tags_) {
    findings.push_back({Finding::Kind::displaced_tag, "tag " + std::to_string(number),
                        tag.vehicle + " was displaced by " + decimetres(tag.shift_m) +
                            " m when it read the tag: the tag is elsewhere on one side, or the vehicle was moved",
                        tag.since});
  }
  return findings;
}

void ReportWatch::archive(Archive& archive) { archive(tags_, zone_revision_, any_); }

}  // namespace cosiva::virtual_side
