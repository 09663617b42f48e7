#pragma once

#include <cstdint>
#include <deque>
#include <functional>
#include <optional>
#include <set>
#include <span>
#include <string>
#include <string_view>
#include <utility>

#include "cosiva/adapters/http/http_server.h"
#include "cosiva/hmi/call_context.h"

namespace cosiva::app {

/// The path for a whole zone, the only long body: 16 MiB of a file, and some more where its bytes are escaped or a
/// sidecar file is included.
inline constexpr std::string_view switch_path = "/api/v1/zone/switch";
inline constexpr std::size_t switch_bytes_max = std::size_t{64} << 20U;

/// The HTTP half of the page's contract, as a table of calls, without sockets: requests in, responses out. Every change
/// is checked by the core first, and then given to the core as a command.
///
/// Invariant: only the first of the changes that wait has been handled.
class PageCalls {
 public:
  explicit PageCalls(PageHost host);

  /// The response to a request; to one that changes something only once its commands are durable (HttpResponse::later).
  /// Changes are handled one after the other, so that each is checked against what the one before has made of the
  /// platform. A Stop waits for nothing.
  [[nodiscard]] adapters::HttpResponse respond(const adapters::HttpRequest& request);
  /// Handles a request now; the commands that it gave may not be decided yet.
  [[nodiscard]] adapters::HttpResponse response(const adapters::HttpRequest& request);

  /// The obstacles that the emulated world reports: the only ones that can be removed.
  void know_plant(std::set<std::string> obstacles) { context_.know_plant(std::move(obstacles)); }

  struct Route {
    std::string_view method;
    std::string_view pattern;  ///< "/api/v1/virtual-objects/{id}"
    enum class Body : std::uint8_t { none, object } body;
    adapters::HttpResponse (*handler)(CallContext&, const Call&);
  };
  [[nodiscard]] static std::span<const Route> routes();

  [[nodiscard]] const PageHost& host() const { return context_.host(); }
  /// The context common to its calls.
  [[nodiscard]] const CallContext& context() const { return context_; }

 private:
  using Respond = std::function<void(adapters::HttpResponse)>;
  /// A change that waits for its turn, or, the first one, for its commands to be decided.
  struct Change {
    adapters::HttpRequest request;
    Respond respond;
    std::optional<adapters::HttpResponse> response;  ///< that counts when its commands are stored
  };
  void handle_changes();

  CallContext context_;
  std::deque<Change> changes_;
  bool handling_{false};
};

}  // namespace cosiva::app
