#include "cosiva/wire/vda5050/typed_messages.h"

#include <utility>

#include "cosiva/wire/vda5050/codec.h"

namespace cosiva::wire::vda5050 {
namespace {

struct Writer {
  std::string operator()(const State& message) const { return encode(message); }
  std::string operator()(const Visualization& message) const { return encode(message); }
  std::string operator()(const Order& message) const { return encode(message); }
  std::string operator()(const Intent& message) const { return to_json(message); }
  std::string operator()(const DetectedObstacleReport& message) const { return to_json(message); }
  std::string operator()(const BoardsReport& message) const { return to_json(message); }
};

template <typename Message>
Result<std::shared_ptr<const Message>> passed_or(const Input& input, Result<Message> (*decode)(std::string_view)) {
  if (const auto* message = value_as<Message>(input.typed)) return std::shared_ptr<const Message>{input.typed, message};
  auto message = decode(input.payload);
  if (!message) return tl::unexpected(std::move(message.error()));
  return std::make_shared<const Message>(std::move(*message));
}

}  // namespace

Result<std::shared_ptr<const State>> state_from(const Input& input) { return passed_or(input, decode_state); }
Result<std::shared_ptr<const Visualization>> visualization_from(const Input& input) {
  return passed_or(input, decode_visualization);
}
Result<std::shared_ptr<const Order>> order_from(const Input& input) { return passed_or(input, decode_order); }

std::string text_of(const InProcessMessage& message) {
  return std::visit(Writer{}, dynamic_cast<const TypedMessage&>(message).message);
}

}  // namespace cosiva::wire::vda5050
