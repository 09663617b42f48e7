#include "cosiva/aiv/localisation/persisted_position.h"

#include "target.h"

/// What a vehicle takes over from its state file is what it would write.
extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace cosiva;
  const auto persisted = aiv::persisted_position_from_json(fuzz::as_text(data, size));
  if (!persisted) {
    COSIVA_EXPECT(!persisted.error().code.empty() && !persisted.error().message.empty());
    return 0;
  }
  const auto again = aiv::persisted_position_from_json(aiv::to_json(*persisted));
  COSIVA_EXPECT(again && *again == *persisted);
  return 0;
}
