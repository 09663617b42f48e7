#include "cosiva/virtual/server/exchange/agent_proxy.h"

#include <utility>

#include "cosiva/base/archive.h"
#include "cosiva/base/expect.h"

namespace cosiva::virtual_side {

AgentProxy::AgentProxy(std::string agent) : agent_{std::move(agent)} { COSIVA_EXPECT(!agent_.empty()); }

void AgentProxy::send(Traces& traces, SimTime now, std::string_view kind, std::string_view summary,
                      wire::Publish&& message, wire::Effects& effects) {
  pass_on(traces, now, {kind, summary, message.topic, message.payload});
  effects.emplace_back(std::move(message));
}

void AgentProxy::pass_on(Traces& traces, SimTime now, const MessageText& text) {
  ++sent_;
  traces.add(now, server, agent_, text.kind, text.summary, text.topic, text.payload, Traces::Hop::proxy_of_receiver);
}

void AgentProxy::deliver(Traces& traces, SimTime now, const MessageText& text, std::string_view to) {
  ++delivered_;
  traces.add(now, agent_, to, text.kind, text.summary, text.topic, text.payload, Traces::Hop::proxy_of_sender);
}

void AgentProxy::deliver_position(Traces& traces, SimTime now, const MessageText& text, const Pose2& pose,
                                  double speed_mps) {
  ++delivered_;
  traces.add_position(now, agent_, server, text.kind, pose, speed_mps, text.topic, text.payload,
                      Traces::Hop::proxy_of_sender);
}

void AgentProxy::refuse(Traces& traces, SimTime now, const MessageText& text) const {
  traces.add(now, agent_, server, text.kind, text.summary, text.topic, text.payload, Traces::Hop::proxy_of_sender);
}

void AgentProxy::archive(Archive& archive) { archive(sent_, delivered_); }

}  // namespace cosiva::virtual_side
