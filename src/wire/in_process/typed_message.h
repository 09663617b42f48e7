#pragma once

#include <memory>
#include <type_traits>
#include <typeinfo>
#include <utility>
#include <variant>

#include "cosiva/base/archive_fwd.h"
#include "cosiva/base/digest.h"
#include "cosiva/base/result.h"
#include "cosiva/wire/messages/messages.h"
#include "cosiva/wire/own/own_messages.h"
#include "cosiva/wire/own/v2x.h"
#include "cosiva/wire/runtime/core.h"

namespace cosiva::wire {

/// The content of a message, as the values that its text is written from and read into. Where all cores run in one
/// process (experiments/runs/world), messages are passed on as values and their texts are neither written nor parsed,
/// which would be most of such a run's cost. The received values are the same to the last bit, because only what
/// survives the wire is published (as_received). A real wire and a journal carry texts only.
class TypedMessage final : public InProcessMessage {
 public:
  using Message = std::variant<State, Visualization, Intent, DetectedObstacleReport, BoardsReport, Order>;
  explicit TypedMessage(Message what) : message{std::move(what)} {}
  template <typename Content>
  TypedMessage(std::in_place_type_t<Content> type, Content&& content) : message{type, std::forward<Content>(content)} {}
  void fold(Digest& digest) const override;

  Message message;
};

void archive_value(Archive& archive, std::shared_ptr<const TypedMessage>& message);

/// The message as its text would be read: times to the millisecond, and without the fields that the text omits.
[[nodiscard]] State as_received(State&& message);
[[nodiscard]] Visualization as_received(Visualization&& message);
[[nodiscard]] Intent as_received(Intent&& message);
[[nodiscard]] DetectedObstacleReport as_received(DetectedObstacleReport&& message);
[[nodiscard]] BoardsReport as_received(BoardsReport&& message);
/// @param message  its header states a version, and its angles and tolerances are within the standard's ranges
[[nodiscard]] Order as_received(Order&& message);

template <typename Message>
[[nodiscard]] std::shared_ptr<const TypedMessage> typed(Message&& message) {
  return std::make_shared<const TypedMessage>(std::in_place_type<std::remove_cvref_t<Message>>,
                                              as_received(std::forward<Message>(message)));
}

/// The message's values, if the message was passed on as values and is of this type.
template <typename Message>
[[nodiscard]] const Message* value_as(const std::shared_ptr<const InProcessMessage>& by) {
  // The class is final, so one comparison does.
  const InProcessMessage* message = by.get();
  if (message == nullptr || typeid(*message) != typeid(TypedMessage)) return nullptr;
  return std::get_if<Message>(&static_cast<const TypedMessage*>(message)->message);
}

// CoSiVA's own messages, as values or as text; those of VDA 5050 are read next to their codec (vda5050/said.h).
[[nodiscard]] Result<DetectedObstacleReport> detected_obstacle_from(const Input& input);
[[nodiscard]] Result<BoardsReport> boards_report_from(const Input& input);

}  // namespace cosiva::wire
