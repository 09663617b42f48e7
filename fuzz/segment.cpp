#include "cosiva/journal/store/segment.h"

#include "target.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  namespace journal = cosiva::journal;
  const std::string_view bytes = cosiva::fuzz::as_text(data, size);
  journal::RecordNumber records = 0;
  const auto content = journal::read_segment(bytes, journal::no_record,
                                             [&](journal::RecordNumber, const journal::RecordView&) { ++records; });
  COSIVA_EXPECT(content.intact_bytes <= size && content.next - content.start.first == records);
  COSIVA_EXPECT(!content.damage || content.damage->code.starts_with("store."));
  if (content.intact_bytes == 0) return 0;
  // What counts, read alone, is intact and the same.
  const auto again = journal::read_segment(bytes.substr(0, content.intact_bytes));
  COSIVA_EXPECT(!again.damage && !again.torn && again.intact_bytes == content.intact_bytes);
  COSIVA_EXPECT(again.next == content.next && again.chain == content.chain);
  return 0;
}
