#include "cosiva/wire/runtime/snapshot.h"

#include <utility>

#include "cosiva/base/archive.h"
#include "cosiva/base/expect.h"

namespace cosiva::wire {
namespace {

constexpr std::string_view beginning = "CoSiVA snapshot\n";

std::uint64_t digest_of(std::string_view bytes) {
  Digest digest;
  digest.add(bytes);
  return digest.value();
}

}  // namespace

std::string Snapshot::text() const {
  std::string bytes{beginning};
  Head head = head_;
  std::string content = content_;
  Archive archive{bytes};
  archive(head, content);
  std::uint64_t digest = digest_of(bytes);
  archive(digest);
  COSIVA_EXPECT(!archive.failed());
  return bytes;
}

Result<Snapshot> Snapshot::read(std::string_view bytes) {
  const auto damaged = [](std::string why) {
    return fail("snapshot.damaged", "not a whole snapshot: " + std::move(why));
  };
  if (!bytes.starts_with(beginning)) return damaged("it begins otherwise");
  Snapshot snapshot{{}, {}};
  Archive archive{bytes.substr(beginning.size())};
  std::uint64_t digest = 0;
  archive(snapshot.head_, snapshot.content_, digest);
  if (const auto whole = archive.finish(); !whole) return damaged(whole.error().message);
  if (digest != digest_of(bytes.substr(0, bytes.size() - sizeof digest))) return damaged("its bytes have been changed");
  return snapshot;
}

Result<void> Snapshot::check(std::string_view core, std::uint32_t format, std::uint64_t options) const {
  if (head_.core != core || head_.format != format)
    return fail("snapshot.format", "the snapshot is of '" + head_.core + "' in format " + std::to_string(head_.format) +
                                       ", and this is '" + std::string(core) + "' in format " + std::to_string(format));
  if (head_.options != options)
    return fail("snapshot.options", "the snapshot is of a '" + head_.core + "' with other options");
  return {};
}

}  // namespace cosiva::wire
