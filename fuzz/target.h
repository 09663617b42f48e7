#pragma once

#include <cstddef>
#include <cstdint>
#include <string_view>

#include "cosiva/base/expect.h"

/// One fuzz target is one function; libFuzzer or replayer.cpp calls it. Its conditions are stated with COSIVA_EXPECT.
extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size);

namespace cosiva::fuzz {

inline std::string_view as_text(const std::uint8_t* data, std::size_t size) {
  return size == 0 ? std::string_view{} : std::string_view{reinterpret_cast<const char*>(data), size};
}

}  // namespace cosiva::fuzz
