#pragma once

#include <cstdint>
#include <string>
#include <string_view>

#include "cosiva/base/archive_fwd.h"
#include "cosiva/base/pose.h"
#include "cosiva/base/time.h"
#include "cosiva/virtual/server/exchange/traces.h"
#include "cosiva/wire/runtime/core.h"

namespace cosiva::virtual_side {

/// What the traces show of a message.
struct MessageText {
  std::string_view kind;
  std::string_view summary;    ///< readable, in one line
  std::string_view topic{};    ///< empty: not a message of the wire
  std::string_view payload{};  ///< byte for byte; empty: none
};

/// The local end of one remote agent (A26). The machine that hosts an agent also hosts the proxy of each remote agent
/// with which it communicates: a local agent hands a message to the proxy of the receiver, which sends it, and a
/// message of a remote agent is delivered to a local agent by the proxy of its sender (§3.6). The proxy emits the
/// traces of both, with the hop through itself. An agent that the same machine hosts is reached without a hop.
///
/// Invariant: a message is counted once, when it has been sent or delivered; a refused one is not counted.
class AgentProxy {
 public:
  /// The name of the local agent with which remote agents communicate.
  static constexpr std::string_view server = "AIV_Server";

  /// @param agent  name of the remote agent, not empty (checked)
  explicit AgentProxy(std::string agent);

  [[nodiscard]] const std::string& agent() const { return agent_; }
  [[nodiscard]] std::uint64_t messages_sent() const { return sent_; }            ///< messages to the agent
  [[nodiscard]] std::uint64_t messages_delivered() const { return delivered_; }  ///< messages of the agent

  /// Sends a message of the local agent: it becomes an effect of the input that is being handled.
  /// @param kind, summary  for the traces, which take topic and payload from the message
  void send(Traces& traces, SimTime now, std::string_view kind, std::string_view summary, wire::Publish&& message,
            wire::Effects& effects);
  /// Counts and traces a message that the caller passes on without the broker.
  void pass_on(Traces& traces, SimTime now, const MessageText& text);

  /// Delivers a message of the agent.
  /// @param to  the local agent
  void deliver(Traces& traces, SimTime now, const MessageText& text, std::string_view to = server);
  /// @param text  without a summary: the position is formatted when a trace is read
  void deliver_position(Traces& traces, SimTime now, const MessageText& text, const Pose2& pose, double speed_mps);
  /// Delivers a message without news, whose trace would only obscure the others.
  void deliver_untraced() { ++delivered_; }
  /// Traces that a message of the agent has been refused, and delivers nothing.
  void refuse(Traces& traces, SimTime now, const MessageText& text) const;

  void archive(Archive& archive);  ///< the state, for a snapshot

 private:
  std::string agent_;
  std::uint64_t sent_{0};
  std::uint64_t delivered_{0};
};

}  // namespace cosiva::virtual_side
