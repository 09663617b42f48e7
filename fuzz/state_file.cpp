#include "cosiva/adapters/state_file.h"

#include "target.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  const std::string_view file = cosiva::fuzz::as_text(data, size);
  if (const auto found = cosiva::adapters::newest_in(file)) {
    COSIVA_EXPECT(found->data() >= file.data() && found->data() + found->size() <= file.data() + file.size());
    COSIVA_EXPECT(found->size() == file.size() || file.find("cosiva-memory 1 ") != std::string_view::npos);
  }
  return 0;
}
