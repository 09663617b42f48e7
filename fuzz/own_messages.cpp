#include "cosiva/wire/own/own_messages.h"

#include "cosiva/wire/own/actual_position.h"
#include "cosiva/wire/own/battery_exchange.h"
#include "cosiva/wire/own/control_areas.h"
#include "cosiva/wire/own/crossing_claims.h"
#include "cosiva/wire/own/crossing_status.h"
#include "cosiva/wire/own/estimate_exchange.h"
#include "cosiva/wire/own/v2x.h"
#include "target.h"

namespace {

/// A refusal states reason and location; an accepted message is written and read back unchanged.
template <typename Message>
void read(cosiva::Result<Message> (*reader)(std::string_view), std::string_view text) {
  const auto message = reader(text);
  if (!message) {
    COSIVA_EXPECT(!message.error().code.empty() && !message.error().message.empty());
    return;
  }
  const std::string json = to_json(*message);
  // Escapes make a text longer, so that a text that just fits may not fit again.
  if (json.size() > 16U << 10U) return;
  const auto again = reader(json);
  COSIVA_EXPECT(again && to_json(*again) == json);
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  namespace wire = cosiva::wire;
  const std::string_view text = cosiva::fuzz::as_text(data, size);
  read(wire::virtual_obstacles_from_json, text);
  read(wire::virtual_obstacles_ack_from_json, text);
  read(wire::detected_obstacle_from_json, text);
  read(wire::boards_report_from_json, text);
  read(wire::radio_from_json, text);
  read(wire::intent_from_json, text);
  read(wire::crossing_claims_from_json, text);
  read(wire::crossing_status_from_json, text);
  read(wire::unit_switch_from_json, text);
  read(wire::owner_from_json, text);
  read(wire::battery_change_from_json, text);
  read(wire::battery_request_from_json, text);
  read(wire::battery_ready_from_json, text);
  read(wire::battery_test_from_json, text);
  read(wire::estimate_request_from_json, text);
  read(wire::actual_position_request_from_json, text);
  read(wire::actual_position_from_json, text);
  read(wire::estimate_response_from_json, text);
  return 0;
}
