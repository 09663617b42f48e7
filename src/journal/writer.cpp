#include "cosiva/journal/writer.h"

#include <utility>

#include "cosiva/base/expect.h"
#include "cosiva/journal/format.h"
#include "cosiva/journal/record.h"

namespace cosiva::journal {

Writer::Writer(Sink sink) : sink_{std::move(sink)} {
  COSIVA_EXPECT(sink_ != nullptr);
  sink_(format::magic);
}

void Writer::append(const wire::Input& input) {
  buffer_.clear();
  append_record(buffer_, input);
  sink_(buffer_);
}

void Writer::end(SimTime at, const std::string& digest) {
  buffer_.clear();
  append_end_record(buffer_, at, digest);
  sink_(buffer_);
}

}  // namespace cosiva::journal
