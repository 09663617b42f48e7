#include "cosiva/aiv/partners/server_selection.h"

#include <utility>

#include "cosiva/base/archive.h"
#include "cosiva/base/expect.h"
#include "cosiva/wire/messages/topics.h"

namespace cosiva::aiv {

bool ServerSelection::on_owner(std::string_view payload, wire::Effects& effects) {
  std::string next;
  if (!payload.empty()) {
    auto owner = wire::owner_from_json(payload);
    if (!owner) {
      effects.emplace_back(
          wire::Log{'w', "the owner of this vehicle cannot be read, so nothing changes: " + to_string(owner.error())});
      return false;
    }
    next = std::move(owner->area);
  }
  if (next == area_) return false;
  effects.emplace_back(wire::Log{
      'i', next.empty() ? std::string("belongs to no control area any more") : "belongs to control area " + next});
  area_ = std::move(next);
  topics_ = wire::server_topics(area_);
  COSIVA_EXPECT(area_.empty() == (topics_.heartbeat == wire::server_heartbeat_topic));
  return true;
}

std::vector<std::string> ServerSelection::filters() const {
  if (area_.empty()) return {};
  return {wire::topics_below(topics_.zone_prefix, 1), topics_.connection, topics_.heartbeat};
}

void ServerSelection::archive(Archive& archive) { archive(area_, topics_); }

}  // namespace cosiva::aiv
