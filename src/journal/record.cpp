#include "cosiva/journal/record.h"

#include "cosiva/base/expect.h"
#include "cosiva/journal/crc32c.h"
#include "cosiva/journal/format.h"
#include "cosiva/journal/little_endian.h"

namespace cosiva::journal {
namespace {

void append(std::string& out, std::uint8_t kind, bool flag, SimTime at, std::string_view source,
            std::string_view payload) {
  const std::size_t length = format::fixed_bytes + source.size() + payload.size();
  COSIVA_EXPECT(source.size() <= 0xFFFF && length <= format::record_bytes_max);
  const std::size_t start = out.size();
  append_integer(out, static_cast<std::uint32_t>(length));
  append_integer(out, kind);
  append_integer(out, static_cast<std::uint8_t>(flag ? 1 : 0));
  append_integer(out, static_cast<std::int64_t>(at.time_since_epoch().count()));
  append_integer(out, static_cast<std::uint16_t>(source.size()));
  out += source;
  out += payload;
  append_integer(out, crc32c(std::string_view{out}.substr(start)));
}

bool known(std::uint8_t kind) {
  return kind == format::end_kind || (kind >= static_cast<std::uint8_t>(wire::InputKind::configure) &&
                                      kind <= static_cast<std::uint8_t>(wire::InputKind::snapshot));
}

}  // namespace

wire::Input RecordView::input() const {
  COSIVA_EXPECT(kind != format::end_kind);
  return {at, static_cast<wire::InputKind>(kind), std::string(source), std::string(payload), flag};
}

void append_record(std::string& out, const wire::Input& input) {
  append(out, static_cast<std::uint8_t>(input.kind), input.flag, input.at, input.source, input.payload);
}

void append_end_record(std::string& out, SimTime at, std::string_view digest) {
  append(out, format::end_kind, false, at, {}, digest);
}

Result<std::optional<RecordView>> front_record(std::string_view bytes) {
  if (bytes.size() < format::length_bytes) return std::nullopt;
  const std::size_t length = integer_at<std::uint32_t>(bytes, 0);
  if (length < format::fixed_bytes || length > format::record_bytes_max)
    return fail("journal.length", "a record cannot be " + std::to_string(length) + " bytes long");
  const std::size_t whole = format::length_bytes + length + format::crc_bytes;
  if (bytes.size() < whole) return std::nullopt;
  const std::string_view checked = bytes.substr(0, format::length_bytes + length);
  if (crc32c(checked) != integer_at<std::uint32_t>(bytes, checked.size()))
    return fail("journal.crc", "the record's checksum does not match its bytes");

  const std::string_view body = checked.substr(format::length_bytes);
  const auto kind = integer_at<std::uint8_t>(body, 0);
  const auto flag = integer_at<std::uint8_t>(body, 1);
  const std::size_t source_bytes = integer_at<std::uint16_t>(body, 10);
  if (source_bytes > length - format::fixed_bytes)
    return fail("journal.length", "the record's source is longer than the record");
  if (flag > 1) return fail("journal.flag", "a flag is 0 or 1, found " + std::to_string(flag));
  if (!known(kind)) return fail("journal.kind", "unknown record kind " + std::to_string(kind));
  return RecordView{kind,
                    flag == 1,
                    SimTime{SimDuration{integer_at<std::int64_t>(body, 2)}},
                    body.substr(format::fixed_bytes, source_bytes),
                    body.substr(format::fixed_bytes + source_bytes),
                    whole};
}

}  // namespace cosiva::journal
