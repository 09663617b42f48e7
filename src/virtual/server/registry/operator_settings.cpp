#include "cosiva/virtual/server/registry/operator_settings.h"

#include <cmath>

#include "cosiva/base/archive.h"
#include "cosiva/base/expect.h"
#include "cosiva/zone/layout/traffic_zone.h"

namespace cosiva::virtual_side {

void OperatorSettings::set_priority(std::int32_t priority) {
  COSIVA_EXPECT(priority >= 0 && priority <= zone::priority_max);
  priority_ = priority;
}

void OperatorSettings::on_restart() {
  paused_for_body_ = stop_awaited_ = false;
  no_orders_ = false;
  speed_mps_max_.reset();
}

void OperatorSettings::on_limit(double speed_mps) {
  COSIVA_EXPECT(speed_mps > 0.0 && std::isfinite(speed_mps));
  speed_mps_max_ = speed_mps;
}

void OperatorSettings::on_body_in_path() {
  COSIVA_EXPECT(!paused_for_body_);
  paused_for_body_ = true;
}

void OperatorSettings::on_body_left() {
  COSIVA_EXPECT(paused_for_body_);
  paused_for_body_ = false;
}

void OperatorSettings::archive(Archive& archive) {
  archive(priority_, speed_mps_max_, no_orders_, stop_awaited_, excluded_, paused_for_body_);
}

}  // namespace cosiva::virtual_side
