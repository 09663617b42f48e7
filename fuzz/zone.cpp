#include "cosiva/zone/rtm/rtm.h"
#include "target.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace cosiva::zone;
  const ZoneConfiguration configuration{"toml", "fuzz.toml", std::string(cosiva::fuzz::as_text(data, size))};
  const auto rtm = Rtm::initialise(configuration);
  if (!rtm) {
    COSIVA_EXPECT(!rtm.error().code.empty() && !rtm.error().message.empty());
    COSIVA_EXPECT(faults(configuration).front() == rtm.error());
    return 0;
  }
  // An accepted zone can be written, and the result reads back.
  std::vector<Diagnostic> lost;
  const auto written = rtm->circuit_factory().written(rtm->zone(), lost);
  COSIVA_EXPECT(written && lost.empty());
  return 0;
}
