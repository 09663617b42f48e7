#include "cosiva/journal/reader.h"

#include "cosiva/base/expect.h"
#include "cosiva/journal/crc32c.h"
#include "cosiva/journal/format.h"

namespace cosiva::journal {
namespace {

template <typename T>
T get(std::string_view bytes, std::size_t at) {
  std::uint64_t bits = 0;
  for (unsigned i = 0; i < sizeof(T); ++i)
    bits |= static_cast<std::uint64_t>(static_cast<unsigned char>(bytes[at + i])) << (8U * i);
  return static_cast<T>(bits);
}

bool known_input(std::uint8_t kind) {
  return kind >= static_cast<std::uint8_t>(wire::InputKind::configure) &&
         kind <= static_cast<std::uint8_t>(wire::InputKind::restore);
}

}  // namespace

Result<Reader> Reader::open(std::string_view bytes) {
  if (!bytes.starts_with(format::magic))
    return fail("journal.magic", "this is no journal: it does not start with COSIVAJ1", "offset 0");
  return Reader{bytes};
}

Result<std::optional<wire::Input>> Reader::next() {
  const auto damaged = [&](const char* code, std::string message) {
    return fail(code, std::move(message), "offset " + std::to_string(at_));
  };
  COSIVA_EXPECT(at_ >= format::magic.size() && at_ <= bytes_.size());
  const std::string_view rest = bytes_.substr(at_);
  if (truncated_ || rest.empty()) return std::nullopt;
  if (digest_) return damaged("journal.after_end", std::to_string(rest.size()) + " bytes follow the end record");
  if (rest.size() < format::length_bytes) {
    truncated_ = true;
    return std::nullopt;
  }
  const std::size_t length = get<std::uint32_t>(rest, 0);
  if (length < format::fixed_bytes || length > format::record_bytes_max)
    return damaged("journal.length", "a record cannot be " + std::to_string(length) + " bytes long");
  const std::size_t whole = format::length_bytes + length + format::crc_bytes;
  if (rest.size() < whole) {
    truncated_ = true;
    return std::nullopt;
  }
  const std::string_view checked = rest.substr(0, format::length_bytes + length);
  if (crc32c(checked) != get<std::uint32_t>(rest, checked.size()))
    return damaged("journal.crc", "the record's checksum does not match its bytes");

  const std::string_view body = checked.substr(format::length_bytes);
  const auto kind = get<std::uint8_t>(body, 0);
  const auto flag = get<std::uint8_t>(body, 1);
  const std::size_t source_bytes = get<std::uint16_t>(body, 10);
  if (source_bytes > length - format::fixed_bytes)
    return damaged("journal.length", "the record's source is longer than the record");
  if (flag > 1) return damaged("journal.flag", "a flag is 0 or 1, found " + std::to_string(flag));
  const std::string_view payload = body.substr(format::fixed_bytes + source_bytes);
  if (kind == format::end_kind) {
    digest_ = std::string(payload);
    at_ += whole;
    return next();
  }
  if (!known_input(kind)) return damaged("journal.kind", "unknown record kind " + std::to_string(kind));
  at_ += whole;
  return wire::Input{SimTime{SimDuration{get<std::int64_t>(body, 2)}}, static_cast<wire::InputKind>(kind),
                     std::string(body.substr(format::fixed_bytes, source_bytes)), std::string(payload), flag == 1};
}

}  // namespace cosiva::journal
