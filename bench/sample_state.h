#pragma once

#include <cstdint>
#include <string>

#include "cosiva/base/time.h"
#include "cosiva/wire/messages/messages.h"
#include "cosiva/wire/messages/topics.h"

namespace cosiva::fixture {

/// A state as a driving vehicle sends it: about 1 kB of JSON. `number` makes messages differ as they do in a run.
inline wire::State sample_state(const wire::VehicleId& id, std::uint32_t number, SimTime at, const Pose2& X_MB,
                                const std::string& map_id) {
  wire::State state;
  state.header = {number, at, "2.1.0", id.manufacturer, id.serial_number};
  state.order_id = "order-" + std::to_string(number / 1000);
  state.order_update_id = number % 1000;
  state.last_node_id = "east@300";
  state.last_node_sequence_id = 2 * (number % 100);
  state.driving = true;
  state.distance_since_last_node_m = 0.01 * (number % 30);
  for (std::uint32_t i = 1; i <= 2; ++i) {
    const std::uint32_t sequence = state.last_node_sequence_id + 2 * i;
    state.edge_states.push_back({"edge-" + std::to_string(sequence - 1), sequence - 1, i < 2});
    state.node_states.push_back({"node-" + std::to_string(sequence), sequence, i < 2, std::nullopt});
  }
  state.position = wire::AgvPosition{X_MB, map_id, true, 0.97, 0.01};
  state.velocity = wire::Velocity{0.3, 0.0, 0.001 * (number % 7)};
  state.battery = {87.25 - 0.001 * (number % 1000), 12.1, std::nullopt, false};
  state.information.push_back({"lastTag", "", {{"tag", std::to_string(number % 12)}, {"distance_m", "0.212"}}});
  return state;
}

}  // namespace cosiva::fixture
