#include "cosiva/zone/opendrive/opendrive_factory.h"
#include "target.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  // The sidecar file comes first, up to a zero byte, as on its topic.
  const auto configuration = cosiva::zone::from_payload("opendrive", "fuzz.xodr", cosiva::fuzz::as_text(data, size));
  const auto zone = cosiva::zone::OpenDriveCircuitFactory{}.make_zone(configuration);
  if (!zone) COSIVA_EXPECT(!zone.error().code.empty() && !zone.error().message.empty());
  return 0;
}
