#include "cosiva/aiv/v2x/intent_topic.h"

#include "cosiva/base/expect.h"

namespace cosiva::aiv {

const std::string& IntentTopic::at(const std::string& map_id, wire::Cell cell) {
  if (text_.empty() || cell_ != cell || map_id_ != map_id) {
    map_id_ = map_id;
    cell_ = cell;
    text_ = wire::v2x_topic(map_id, cell, vehicle_);
  }
  COSIVA_EXPECT(!text_.empty());
  return text_;
}

}  // namespace cosiva::aiv
