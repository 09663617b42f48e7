#include <cmath>
#include <memory>

#include "cosiva/battery/cell_table.h"
#include "cosiva/battery/pack.h"
#include "cosiva/battery/type_json.h"
#include "target.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace cosiva;
  const auto type = battery::read_type(fuzz::as_text(data, size), "fuzz.json");
  if (!type) {
    COSIVA_EXPECT(type.error().code == "battery.type" && !type.error().message.empty());
    COSIVA_EXPECT(type.error().location.starts_with("fuzz.json"));
    return 0;
  }
  // An accepted type reads back the same, and makes a pack that withstands any load.
  COSIVA_EXPECT(battery::read_type(battery::to_json(*type), "again") == type);
  battery::Pack pack{std::make_shared<battery::CellTable>(*type), {2, 2, 1.0}, {"B", 1, true, 3.0}};
  for (const double power_w : {0.0, 1.0, 1e6, -1.0, 10.0}) {
    const battery::PackStep step = pack.draw_power(power_w, 25.0, 1e-3);
    COSIVA_EXPECT(std::isfinite(step.voltage_v) && std::isfinite(step.current_a));
    COSIVA_EXPECT(pack.charge() >= 0.0 && pack.charge() <= 1.0);
  }
  return 0;
}
