#pragma once

#include <cstdint>
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
/// is checked by the core first, so that the response is immediate, and then given to the core as a command.
class PageCalls {
 public:
  explicit PageCalls(PageHost host) : context_{std::move(host)} {}

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
  CallContext context_;
};

}  // namespace cosiva::app
