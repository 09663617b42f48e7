#include "cosiva/adapters/lossy_radio.h"

#include <algorithm>
#include <utility>

#include "cosiva/base/expect.h"
#include "cosiva/wire/messages/topics.h"
#include "cosiva/wire/own/control_areas.h"
#include "cosiva/wire/own/own_messages.h"

namespace cosiva::adapters {

LossyRadio::LossyRadio(EventLoop& loop, std::string vehicle)
    : vehicle_{std::move(vehicle)}, random_{1, "radio/" + vehicle_}, incoming_{loop}, outgoing_{loop} {}

bool LossyRadio::take(std::string_view topic, std::string_view payload) {
  if (topic != wire::plant_radio_topic) return false;
  const auto radio = wire::radio_from_json(payload);
  if (radio && (radio->vehicle == "*" || radio->vehicle == vehicle_)) loss_ = radio->loss;
  COSIVA_EXPECT(loss_ >= 0.0 && loss_ <= 1.0);
  return true;
}

void LossyRadio::pass(Lane& lane, int qos, std::function<void()> deliver) {
  if (qos == 0) {
    if (loss_ > 0.0 && random_.chance(loss_)) return;
    return deliver();
  }
  std::chrono::milliseconds later{};
  for (int tries = 0; loss_ > 0.0 && tries < tries_max && random_.chance(loss_); ++tries) later += retry;
  if (later == std::chrono::milliseconds::zero() && lane.late.empty()) return deliver();
  Clock::time_point due = Clock::now() + later;
  if (!lane.late.empty()) due = std::max(due, lane.late.back().due);
  lane.late.push_back({due, std::move(deliver)});
  if (lane.late.size() == 1) lane.timer.after(due - Clock::now(), [this, &lane] { deliver_due(lane); });
}

void LossyRadio::deliver_due(Lane& lane) {
  while (!lane.late.empty() && lane.late.front().due <= Clock::now()) {
    const auto deliver = std::move(lane.late.front().deliver);
    lane.late.pop_front();
    deliver();
  }
  if (lane.late.empty()) return;
  lane.timer.after(std::max(lane.late.front().due - Clock::now(), Clock::duration::zero()),
                   [this, &lane] { deliver_due(lane); });
}

void LossyRadio::end() {
  loss_ = 0.0;
  incoming_.timer.cancel();
  incoming_.late.clear();
  outgoing_.timer.cancel();
  for (const Late& late : std::exchange(outgoing_.late, {})) late.deliver();
}

int qos_of_received(std::string_view topic) {
  const bool of_a_control_area = topic.starts_with(wire::area_topic_prefix) && !topic.ends_with("/server/heartbeat");
  const bool kept = topic.starts_with(wire::zone_topic_prefix) || topic.starts_with(wire::owner_topic_prefix);
  return kept || of_a_control_area || topic == wire::server_connection_topic ? 1 : 0;
}

}  // namespace cosiva::adapters
