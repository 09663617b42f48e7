#include "cosiva/journal/reader.h"
#include "cosiva/journal/writer.h"

#include "target.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  namespace journal = cosiva::journal;
  const std::string_view bytes = cosiva::fuzz::as_text(data, size);
  auto reader = journal::Reader::open(bytes);
  if (!reader) {
    COSIVA_EXPECT(reader.error().code == "journal.magic");
    return 0;
  }
  // The records read, written again, equal the input.
  std::string written;
  journal::Writer writer{[&](std::string_view piece) { written += piece; }};
  for (;;) {
    const auto next = reader->next();
    if (!next) {
      COSIVA_EXPECT(next.error().code.starts_with("journal.") && next.error().location.starts_with("offset "));
      break;
    }
    if (!*next) break;
    writer.append(**next);
  }
  COSIVA_EXPECT(bytes.starts_with(written));
  return 0;
}
