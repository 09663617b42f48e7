#pragma once

#include <memory>
#include <utility>
#include <variant>

#include "base/digest.h"
#include "base/result.h"
#include "wire/core.h"
#include "wire/messages.h"
#include "wire/own_messages.h"
#include "wire/v2x.h"

namespace cosiva::wire {

/// What a message says, as the values that its text is written from and read into. Where everybody is in one process
/// (experiments/world) messages may be passed on so, and nobody writes or reads their texts: most of what such a run
/// costs. What is heard is the same to the last bit, because only what survives the wire is said (as_heard). On a real
/// wire, and in journals, there are texts alone.
struct Said {
  std::variant<State, Visualization, Intent, Seen, BoardsReport, Order> message;
};

/// The message as it would come out of its text: times to the millisecond, and without what the text leaves out.
[[nodiscard]] State as_heard(State&& message);
[[nodiscard]] Visualization as_heard(Visualization&& message);
[[nodiscard]] Intent as_heard(Intent&& message);
[[nodiscard]] Seen as_heard(Seen&& message);
[[nodiscard]] BoardsReport as_heard(BoardsReport&& message);
/// @param message  its header says a version, and its angles and tolerances are the standard's
[[nodiscard]] Order as_heard(Order&& message);

template <typename Message>
[[nodiscard]] std::shared_ptr<const Said> say(Message&& message) {
  return std::make_shared<const Said>(Said{as_heard(std::forward<Message>(message))});
}

/// What it says, if it was passed on as values and is such a message.
template <typename Message>
[[nodiscard]] const Message* said(const std::shared_ptr<const Said>& by) {
  return by ? std::get_if<Message>(&by->message) : nullptr;
}

// Our own messages, either way; those of VDA 5050 stand with their codec (vda5050/said.h).
[[nodiscard]] Result<Seen> heard_seen(const Input& input);
[[nodiscard]] Result<BoardsReport> heard_boards_report(const Input& input);

/// Which message it is, and its number: what it says shows in the digests of those who act upon it.
void fold(const Said& said, Digest& digest);

}  // namespace cosiva::wire
