#include "cosiva/base/json_value.h"
#include "target.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  const auto value = cosiva::JsonValue::parse(cosiva::fuzz::as_text(data, size), std::size_t{1} << 18U);
  if (!value) {
    COSIVA_EXPECT(value.error().code == "json.syntax" && !value.error().message.empty());
  } else if (value->object() != nullptr && !value->object()->empty()) {
    COSIVA_EXPECT(value->find(value->object()->front().first) != nullptr);
  }
  return 0;
}
