#include "target.h"
#include "zone/rtm/rtm.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  const auto rtm = cosiva::zone::Rtm::initialise({"toml", "fuzz.toml", std::string(cosiva::fuzz::as_text(data, size))});
  if (!rtm) COSIVA_EXPECT(!rtm.error().code.empty() && !rtm.error().message.empty());
  return 0;
}
