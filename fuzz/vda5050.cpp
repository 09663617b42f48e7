#include "cosiva/wire/vda5050/codec.h"
#include "target.h"

namespace {

using cosiva::Result;
namespace vda = cosiva::wire::vda5050;

/// A refusal states reason and location. An accepted message can be written, and is read back as the same message.
template <typename Message>
void check(Result<Message> (*decode)(std::string_view), std::string_view json) {
  const Result<Message> message = decode(json);
  if (!message) {
    COSIVA_EXPECT(message.error().code.starts_with("vda.") && !message.error().message.empty());
    COSIVA_EXPECT(!message.error().location.empty());
    return;
  }
  const std::string written = vda::encode(*message);
  if (written.size() > vda::payload_bytes_max) return;
  const Result<Message> again = decode(written);
  COSIVA_EXPECT(again.has_value());
  COSIVA_EXPECT(vda::encode(*again) == written);
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  const std::string_view json = cosiva::fuzz::as_text(data, size);
  check(vda::decode_order, json);
  check(vda::decode_instant_actions, json);
  check(vda::decode_state, json);
  check(vda::decode_visualization, json);
  check(vda::decode_connection, json);
  check(vda::decode_factsheet, json);
  return 0;
}
