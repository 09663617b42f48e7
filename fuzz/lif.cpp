// The reader of LIF files, and the writer's output for the zones read: that must be readable again.
#include "cosiva/zone/lif/lif_factory.h"
#include "target.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace cosiva::zone;
  // A zero byte ends the sidecar file, as it does on the wire.
  const LifCircuitFactory factory;
  const auto zone = factory.make_zone(from_payload("lif", "fuzz.lif.json", cosiva::fuzz::as_text(data, size)));
  if (!zone) {
    COSIVA_EXPECT(!zone.error().code.empty() && !zone.error().message.empty());
    return 0;
  }
  COSIVA_EXPECT(zone->circuit.size() > 0);
  for (const Diagnostic& diagnostic : zone->diagnostics) COSIVA_EXPECT(!diagnostic.text.empty());
  if (zone->circuit.size() > 200) return 0;
  std::vector<Diagnostic> lost;
  const auto written = factory.written(*zone, lost);
  COSIVA_EXPECT(written.has_value());
  const auto again = factory.make_zone(*written);
  COSIVA_EXPECT(again.has_value());
  return 0;
}
