#pragma once

#include <cstddef>
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
/// No record is longer: the largest MQTT payload, 256 MiB, and its topic.
inline constexpr std::size_t record_bytes_max = (std::size_t{1} << 28U) + (std::size_t{1} << 17U);

}  // namespace cosiva::journal::format
