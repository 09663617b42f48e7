#pragma once

#include <cstdint>
#include <string_view>

/// The few numbers of docs/protocols/journal.md that writer and reader share.
namespace cosiva::journal::format {

inline constexpr std::string_view magic = "COSIVAJ1";
inline constexpr std::uint8_t end_kind = 255;
/// kind, flag, time, source length: what a record's length counts before source and payload.
inline constexpr std::size_t fixed_bytes = 1 + 1 + 8 + 2;
inline constexpr std::size_t length_bytes = 4;
inline constexpr std::size_t crc_bytes = 4;

}  // namespace cosiva::journal::format
