#include "cosiva/wire/in_process/typed_message.h"

#include "cosiva/base/archive.h"

namespace cosiva::wire {
namespace {

SimTime on_the_wire(SimTime time) { return SimTime{floor<std::chrono::milliseconds>(time.time_since_epoch())}; }

std::uint32_t number_of(const State& message) { return message.header.header_id; }
std::uint32_t number_of(const Visualization& message) { return message.header.header_id; }
std::uint32_t number_of(const Intent& message) { return message.header_id; }
std::uint32_t number_of(const DetectedObstacleReport& message) { return message.header_id; }
std::uint32_t number_of(const BoardsReport& message) { return message.header_id; }
std::uint32_t number_of(const Order& message) { return message.header.header_id; }

template <typename Message>
Message stamped(Message&& message) {
  message.timestamp = on_the_wire(message.timestamp);
  return std::forward<Message>(message);
}

template <typename Message>
Message stamped_in_header(Message&& message) {
  message.header.timestamp = on_the_wire(message.header.timestamp);
  return std::forward<Message>(message);
}

template <typename Message>
Result<Message> typed_or(const Input& input, Result<Message> (*read)(std::string_view)) {
  if (const auto* message = value_as<Message>(input.typed)) return *message;
  return read(input.payload);
}

}  // namespace

State as_received(State&& message) { return stamped_in_header(std::move(message)); }
Visualization as_received(Visualization&& message) { return stamped_in_header(std::move(message)); }
Intent as_received(Intent&& message) { return stamped(std::move(message)); }
DetectedObstacleReport as_received(DetectedObstacleReport&& message) { return stamped(std::move(message)); }
Order as_received(Order&& message) { return stamped_in_header(std::move(message)); }

BoardsReport as_received(BoardsReport&& message) {
  if (message.ranges) message.ranges->board_ms = 0;  // a board's own clock is of no use outside the vehicle
  if (message.pils) message.pils->board_ms = 0;
  return stamped(std::move(message));
}

Result<DetectedObstacleReport> detected_obstacle_from(const Input& input) {
  return typed_or(input, detected_obstacle_from_json);
}
Result<BoardsReport> boards_report_from(const Input& input) { return typed_or(input, boards_report_from_json); }

void TypedMessage::fold(Digest& digest) const {
  digest.add(std::uint64_t{message.index()});
  digest.add(std::uint64_t{std::visit([](const auto& typed) { return number_of(typed); }, message)});
}

void archive_value(Archive& archive, std::shared_ptr<const TypedMessage>& message) {
  std::optional<TypedMessage::Message> content;
  if (message) content = message->message;
  archive(content);
  if (!archive.reads() || archive.failed()) return;
  message = content ? std::make_shared<const TypedMessage>(std::move(*content)) : nullptr;
}

}  // namespace cosiva::wire
