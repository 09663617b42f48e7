#include "cosiva/journal/writer.h"

#include <utility>

#include "cosiva/base/expect.h"
#include "cosiva/journal/crc32c.h"
#include "cosiva/journal/format.h"

namespace cosiva::journal {
namespace {

/// Little endian on every machine.
template <typename T>
void put(std::string& out, T value) {
  const auto bits = static_cast<std::uint64_t>(value);
  for (unsigned i = 0; i < sizeof(T); ++i) out += static_cast<char>((bits >> (8U * i)) & 0xFFU);
}

void put_record(std::string& out, std::uint8_t kind, bool flag, SimTime at, std::string_view source,
                std::string_view payload) {
  const std::size_t length = format::fixed_bytes + source.size() + payload.size();
  COSIVA_EXPECT(source.size() <= 0xFFFF && length <= format::record_bytes_max);
  const std::size_t start = out.size();
  put(out, static_cast<std::uint32_t>(length));
  put(out, kind);
  put(out, static_cast<std::uint8_t>(flag ? 1 : 0));
  put(out, static_cast<std::int64_t>(at.time_since_epoch().count()));
  put(out, static_cast<std::uint16_t>(source.size()));
  out += source;
  out += payload;
  put(out, crc32c(std::string_view{out}.substr(start)));
}

}  // namespace

Writer::Writer(Sink sink) : sink_{std::move(sink)} {
  COSIVA_EXPECT(sink_ != nullptr);
  sink_(format::magic);
}

void Writer::append(const wire::Input& input) {
  buffer_.clear();
  put_record(buffer_, static_cast<std::uint8_t>(input.kind), input.flag, input.at, input.source, input.payload);
  sink_(buffer_);
}

void Writer::end(SimTime at, const std::string& digest) {
  buffer_.clear();
  put_record(buffer_, format::end_kind, false, at, {}, digest);
  sink_(buffer_);
}

}  // namespace cosiva::journal
