#include "cosiva/wire/vda5050/said.h"

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

Result<State> heard_state(const Input& input) {
  if (const auto* state = said<State>(input.said)) return *state;
  return decode_state(input.payload);
}

Result<Visualization> heard_visualization(const Input& input) {
  if (const auto* visualization = said<Visualization>(input.said)) return *visualization;
  return decode_visualization(input.payload);
}

Result<Order> heard_order(const Input& input) {
  if (const auto* order = said<Order>(input.said)) return *order;
  return decode_order(input.payload);
}

std::string text_of(const InProcessMessage& message) {
  return std::visit(Writer{}, dynamic_cast<const Said&>(message).message);
}

}  // namespace cosiva::wire::vda5050
