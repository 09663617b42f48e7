#include "cosiva/virtual/server/context/server_context.h"

namespace cosiva::virtual_side {
namespace {

constexpr std::uint64_t unknown_senders_logged_max = 20;

}  // namespace

Simulator::Step step_recorder(ServerContext& context) {
  return [&context](std::string_view from, std::string_view to, std::string_view kind, std::string_view content) {
    context.traces.add(context.now, from, to, kind, content);
  };
}

void refuse_unknown_sender(ServerContext& context, const std::string& topic, const std::string& fault) {
  ++context.messages_refused;
  if (context.unknown_senders_logged++ < unknown_senders_logged_max)
    context.publisher.log('w', "ignored '" + topic.substr(0, 120) + "': " + fault);
}

}  // namespace cosiva::virtual_side
