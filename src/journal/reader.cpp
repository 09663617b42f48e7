#include "cosiva/journal/reader.h"

#include <utility>

#include "cosiva/base/expect.h"
#include "cosiva/journal/format.h"
#include "cosiva/journal/record.h"

namespace cosiva::journal {

Result<Reader> Reader::open(std::string_view bytes) {
  if (!bytes.starts_with(format::magic))
    return fail("journal.magic", "this is no journal: it does not start with COSIVAJ1", "offset 0");
  return Reader{bytes};
}

Result<std::optional<wire::Input>> Reader::next() {
  const auto damaged = [&](Error error) {
    error.location = "offset " + std::to_string(at_);
    return tl::unexpected<Error>(std::move(error));
  };
  COSIVA_EXPECT(at_ >= format::magic.size() && at_ <= bytes_.size());
  const std::string_view rest = bytes_.substr(at_);
  if (truncated_ || rest.empty()) return std::nullopt;
  if (digest_) return damaged({"journal.after_end", std::to_string(rest.size()) + " bytes follow the end record", {}});
  const auto record = front_record(rest);
  if (!record) return damaged(record.error());
  if (!*record) {
    truncated_ = true;
    return std::nullopt;
  }
  at_ += (*record)->bytes;
  if ((*record)->kind != format::end_kind) return (*record)->input();
  digest_ = std::string((*record)->payload);
  return next();
}

}  // namespace cosiva::journal
