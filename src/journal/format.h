#pragma once

#include <cstddef>
#include <cstdint>
#include <string_view>

/// Constants of docs/protocols/journal.md used by writer and reader.
namespace cosiva::journal::format {

inline constexpr std::string_view magic = "COSIVAJ1";
inline constexpr std::uint8_t end_kind = 255;
/// kind, flag, time, source length: the part of a record's length ahead of source and payload.
inline constexpr std::size_t fixed_bytes = 1 + 1 + 8 + 2;
inline constexpr std::size_t length_bytes = 4;
inline constexpr std::size_t crc_bytes = 4;
/// Upper bound of a record: the largest MQTT payload, 256 MiB, and its topic.
inline constexpr std::size_t record_bytes_max = (std::size_t{1} << 28U) + (std::size_t{1} << 17U);

}  // namespace cosiva::journal::format
