#include "cosiva/wire/in_process/received_intents.h"

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <utility>

#include "cosiva/base/digest.h"
#include "cosiva/wire/in_process/typed_message.h"

namespace cosiva::wire {
namespace {

template <typename Message>
struct KnownMessage {
  std::string json;
  std::shared_ptr<const Message> message;
};

/// Large enough for a fleet of a hundred vehicles until every receiver has read each message. A message whose slot has
/// been overwritten is parsed again.
constexpr std::size_t slots = 64;
/// The message's first bytes hold number, time and name, which distinguish messages; the whole text is compared before
/// a slot is used.
constexpr std::size_t marked_bytes = 128;

struct KnownTopic {
  std::string text;
  std::optional<V2xTopic> topic;
};

std::size_t slot_of(std::string_view text) {
  Digest fiducial;
  fiducial.add(text.substr(0, marked_bytes));
  // The digest's last step is a product: its high bits are the mixed ones.
  return static_cast<std::size_t>(fiducial.value() >> 32U) % slots;
}

template <typename Message, typename Read>
Result<std::shared_ptr<const Message>> received_message(std::string_view json,
                                                        std::array<KnownMessage<Message>, slots>& received, Read read) {
  KnownMessage<Message>& slot = received[slot_of(json)];
  if (slot.message && slot.json == json) return slot.message;
  auto message = read(json);
  if (!message) return tl::unexpected(message.error());
  slot.json.assign(json);
  slot.message = std::make_shared<const Message>(std::move(*message));
  return slot.message;
}

}  // namespace

Result<std::shared_ptr<const Intent>> received_intent(std::string_view json) {
  static thread_local std::array<KnownMessage<Intent>, slots> received;
  return received_message(json, received, intent_from_json);
}

Result<std::shared_ptr<const CrossingClaims>> received_claims(std::string_view json) {
  static thread_local std::array<KnownMessage<CrossingClaims>, slots> received;
  return received_message(json, received, crossing_claims_from_json);
}

Result<std::shared_ptr<const CrossingStatus>> received_status(std::string_view json) {
  static thread_local std::array<KnownMessage<CrossingStatus>, slots> received;
  return received_message(json, received, crossing_status_from_json);
}

Result<std::shared_ptr<const Intent>> received_intent(const Input& input) {
  if (const auto* intent = value_as<Intent>(input.typed)) return std::shared_ptr<const Intent>{input.typed, intent};
  return received_intent(input.payload);
}

const V2xTopic* received_v2x_topic(std::string_view topic) {
  static thread_local std::array<KnownTopic, slots> received;
  // A topic ends with its sender's name.
  constexpr std::size_t last_bytes = 16;
  KnownTopic& slot = received[slot_of(topic.substr(topic.size() - std::min(topic.size(), last_bytes)))];
  if (!slot.topic || slot.text != topic) {
    slot.text.assign(topic);
    slot.topic = parse_v2x_topic(topic);
  }
  return slot.topic ? &*slot.topic : nullptr;
}

}  // namespace cosiva::wire
