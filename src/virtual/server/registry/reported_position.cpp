#include "cosiva/virtual/server/registry/reported_position.h"

#include <cmath>
#include <utility>

#include "cosiva/base/archive.h"
#include "cosiva/base/expect.h"
#include "cosiva/virtual/server/registry/reordering.h"

namespace cosiva::virtual_side {

ReportedPosition::Order ReportedPosition::order_of(SimTime stamp) const {
  if (!stamp_) return Order::newer;
  if (stamp == *stamp_) return Order::same;
  return is_late(stamp, *stamp_) ? Order::overtaken : Order::newer;
}

bool ReportedPosition::plausible(const Pose2& pose) {
  return std::fabs(pose.x_m) <= coordinate_m_max && std::fabs(pose.y_m) <= coordinate_m_max;
}

void ReportedPosition::take(SimTime stamp, std::string map_id) {
  COSIVA_EXPECT(order_of(stamp) == Order::newer);
  stamp_ = stamp;
  map_id_ = std::move(map_id);
}

void ReportedPosition::know(const Pose2& pose) {
  COSIVA_EXPECT(plausible(pose));
  pose_ = pose;
  known_ = true;
  lost_since_.reset();
}

void ReportedPosition::on_position(SimTime stamp, std::string map_id, const Pose2& pose) {
  take(stamp, std::move(map_id));
  know(pose);
}

void ReportedPosition::on_lost(SimTime stamp, std::string map_id, SimTime now) {
  take(stamp, std::move(map_id));
  known_ = false;
  if (!lost_since_) lost_since_ = now;
}

void ReportedPosition::on_implausible(SimTime stamp, std::string map_id) { take(stamp, std::move(map_id)); }

void ReportedPosition::on_handover(const Pose2& pose) { know(pose); }

void ReportedPosition::on_session() {
  stamp_.reset();
  known_ = false;
  lost_since_.reset();
}

void ReportedPosition::on_initialisation_sent(SimTime now) {
  COSIVA_EXPECT(pose_);
  initialisation_sent_at_ = now;
}

void ReportedPosition::archive(Archive& archive) {
  archive(stamp_, pose_, map_id_, known_, lost_since_, initialisation_sent_at_);
}

}  // namespace cosiva::virtual_side
