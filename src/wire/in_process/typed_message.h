#pragma once

#include <memory>
#include <utility>
#include <variant>

#include "cosiva/base/digest.h"
#include "cosiva/base/result.h"
#include "cosiva/wire/messages/messages.h"
#include "cosiva/wire/own/own_messages.h"
#include "cosiva/wire/own/v2x.h"
#include "cosiva/wire/runtime/core.h"

namespace cosiva::wire {

/// What a message says, as the values that its text is written from and read into. Where everybody is in one process
/// (experiments/runs/world) messages may be passed on so, and nobody writes or reads their texts: most of what such a
/// run costs. What is heard is the same to the last bit, because only what survives the wire is said (as_received). On
/// a real wire, and in journals, there are texts alone.
class TypedMessage final : public InProcessMessage {
 public:
  using Message = std::variant<State, Visualization, Intent, DetectedObstacleReport, BoardsReport, Order>;
  explicit TypedMessage(Message what) : message{std::move(what)} {}
  void fold(Digest& digest) const override;

  Message message;
};

/// The message as it would come out of its text: times to the millisecond, and without what the text leaves out.
[[nodiscard]] State as_received(State&& message);
[[nodiscard]] Visualization as_received(Visualization&& message);
[[nodiscard]] Intent as_received(Intent&& message);
[[nodiscard]] DetectedObstacleReport as_received(DetectedObstacleReport&& message);
[[nodiscard]] BoardsReport as_received(BoardsReport&& message);
/// @param message  its header says a version, and its angles and tolerances are the standard's
[[nodiscard]] Order as_received(Order&& message);

template <typename Message>
[[nodiscard]] std::shared_ptr<const TypedMessage> typed(Message&& message) {
  return std::make_shared<const TypedMessage>(as_received(std::forward<Message>(message)));
}

/// What it says, if it was passed on as values and is such a message.
template <typename Message>
[[nodiscard]] const Message* value_as(const std::shared_ptr<const InProcessMessage>& by) {
  const auto* values = dynamic_cast<const TypedMessage*>(by.get());
  return values != nullptr ? std::get_if<Message>(&values->message) : nullptr;
}

// Our own messages, either way; those of VDA 5050 stand with their codec (vda5050/said.h).
[[nodiscard]] Result<DetectedObstacleReport> detected_obstacle_from(const Input& input);
[[nodiscard]] Result<BoardsReport> boards_report_from(const Input& input);

}  // namespace cosiva::wire
