// MovingAI maps with their sidecar files as zones; what is accepted is written as a native file and reads back the
// same.
#include "cosiva/zone/edit/edit.h"
#include "cosiva/zone/movingai/movingai_factory.h"
#include "cosiva/zone/toml/toml_factory.h"
#include "target.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace cosiva::zone;
  // A zero byte ends the sidecar file, as it does on the wire.
  const ZoneConfiguration file = from_payload("movingai", "fuzz.map", cosiva::fuzz::as_text(data, size));
  const auto zone = MovingAiCircuitFactory{}.make_zone(file);
  if (!zone) {
    COSIVA_EXPECT(!zone.error().code.empty() && !zone.error().message.empty());
    COSIVA_EXPECT(zone.error().location.starts_with("fuzz."));
    return 0;
  }
  COSIVA_EXPECT(zone->circuit.size() >= 2);
  for (const Diagnostic& diagnostic : zone->diagnostics) COSIVA_EXPECT(!diagnostic.text.empty());
  if (zone->circuit.size() > 100) return 0;
  std::vector<Diagnostic> lost;
  const auto written = TomlCircuitFactory{}.written(*zone, lost);
  COSIVA_EXPECT(written.has_value() && lost.empty());
  const auto again = TomlCircuitFactory{}.make_zone(*written);
  COSIVA_EXPECT(again.has_value() && same_geometry(*zone, *again));
  return 0;
}
