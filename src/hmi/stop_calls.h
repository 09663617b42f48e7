#pragma once

#include <memory>
#include <string>
#include <vector>

#include "cosiva/adapters/http/http_server.h"
#include "cosiva/base/result.h"
#include "cosiva/hmi/call_context.h"

/// Stop, which waits for nothing (docs/protocols/hmi-api.md, "Stop").
namespace cosiva::app {

/// A Stop, read from a request.
struct StopRequest {
  std::string id;    ///< of the command and of its action
  std::string json;  ///< the core's command
  std::shared_ptr<const virtual_side::DecodedCommand> decoded;
  std::vector<std::string> vehicles;  ///< names; "*": all
};

/// Whether the body of a command is a Stop.
[[nodiscard]] bool is_stop(const JsonValue& body);
/// Fails as DecodedCommand does. Any thread.
[[nodiscard]] Result<StopRequest> read_stop(const JsonValue& body, const std::string& id);
/// Gives the core a Stop at once. The response is 202 with the id and whether its record is durable, or the core's
/// refusal.
[[nodiscard]] adapters::HttpResponse give_stop(CallContext& context, const StopRequest& stop);
/// 202 {"id","durable":false,"reason":"not yet durable"}.
[[nodiscard]] adapters::HttpResponse stop_response(const StopBook::Entry& stop);

/// The Stop of this id; 404 ("command.not_found"). Any thread.
[[nodiscard]] adapters::HttpResponse stop_progress(const StopBook& stops, const StopLine& line, const std::string& id);
/// GET /api/v1/commands/{id}: whether a Stop is durable, and which vehicles have not confirmed it.
[[nodiscard]] adapters::HttpResponse get_command(CallContext& context, const Call& call);

}  // namespace cosiva::app
