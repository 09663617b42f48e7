#pragma once

#include <cstdint>
#include <string_view>

namespace cosiva::journal {

/// CRC-32C (Castagnoli, RFC 3720 B.4): reflected 0x1EDC6F41, start and final 0xFFFFFFFF; "123456789" gives 0xE3069283.
/// @param seed  the CRC of the preceding bytes, to continue from there
[[nodiscard]] std::uint32_t crc32c(std::string_view bytes, std::uint32_t seed = 0);
/// The same on every processor, without an instruction for it.
[[nodiscard]] std::uint32_t crc32c_by_tables(std::string_view bytes, std::uint32_t seed = 0);

}  // namespace cosiva::journal
