#include "cosiva/wire/runtime/snapshot.h"

#include <map>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "cosiva/base/archive.h"
#include "cosiva/virtual/server/core/server_core.h"
#include "cosiva/wire/in_process/typed_message.h"
#include "target.h"

namespace {

using namespace cosiva;

/// Values of every kind that an archive stores: what is accepted is written back to bytes that are read to equal bytes.
struct Values {
  std::map<std::string, wire::Order> orders;
  std::optional<wire::State> state;
  std::vector<std::shared_ptr<const wire::TypedMessage>> messages;
  std::vector<std::shared_ptr<const wire::Intent>> intents;
  std::vector<bool> bits;
  std::vector<double> numbers;
  JsonValue json;
  zone::ZoneConfiguration zone;
};

std::string written(Values& values) {
  std::string bytes;
  Archive archive{bytes};
  archive(values);
  COSIVA_EXPECT(archive.finish());
  return bytes;
}

void read_values(std::string_view bytes) {
  Values values;
  Archive archive{bytes};
  archive(values);
  if (const auto read = archive.finish(); !read) {
    COSIVA_EXPECT(read.error().code == "archive" && !read.error().message.empty());
    return;
  }
  const std::string once = written(values);
  Values again;
  Archive second{std::string_view{once}};
  second(again);
  COSIVA_EXPECT(second.finish() && written(again) == once);
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  const std::string_view bytes = fuzz::as_text(data, size);
  read_values(bytes);
  const auto snapshot = wire::Snapshot::read(bytes);
  if (snapshot) COSIVA_EXPECT(snapshot->text() == bytes);
  if (!snapshot) COSIVA_EXPECT(snapshot.error().code == "snapshot.damaged");
  static virtual_side::ServerCore server{{}};
  COSIVA_EXPECT(!server.continue_from(bytes));
  return 0;
}
