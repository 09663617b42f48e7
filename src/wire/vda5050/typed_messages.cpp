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

}  // namespace

Result<std::shared_ptr<const State>> state_from(const Input& input) {
  if (const auto* state = value_as<State>(input.typed)) return std::shared_ptr<const State>{input.typed, state};
  auto state = decode_state(input.payload);
  if (!state) return tl::unexpected(std::move(state.error()));
  return std::make_shared<const State>(std::move(*state));
}

Result<Visualization> visualization_from(const Input& input) {
  if (const auto* visualization = value_as<Visualization>(input.typed)) return *visualization;
  return decode_visualization(input.payload);
}

Result<Order> order_from(const Input& input) {
  if (const auto* order = value_as<Order>(input.typed)) return *order;
  return decode_order(input.payload);
}

std::string text_of(const InProcessMessage& message) {
  return std::visit(Writer{}, dynamic_cast<const TypedMessage&>(message).message);
}

}  // namespace cosiva::wire::vda5050
