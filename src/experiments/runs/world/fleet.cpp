#include "cosiva/experiments/runs/world/fleet.h"

#include "cosiva/base/json_value.h"

namespace cosiva::experiments {

bool fleet_is_complete(const virtual_side::ServerCore& server, std::uint32_t aivs) {
  JsonWriter json;
  server.write_bijection(json);
  const auto metrics = JsonValue::parse(json.text());
  return metrics && metrics->number("matched").value_or(0.0) >= aivs &&
         metrics->number("physical").value_or(0.0) >= aivs;
}

}  // namespace cosiva::experiments
