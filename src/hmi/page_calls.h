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
#include <vector>

#include "cosiva/adapters/http/http_server.h"
#include "cosiva/hmi/call_context.h"
#include "cosiva/hmi/stop_calls.h"

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

  struct Route;
  /// A request that has been read: its call and its body.
  struct ReadCall {
    const Route* route;
    Call call;
  };
  using Respond = std::function<void(adapters::HttpResponse)>;
  /// Whether a request is the call whose body may be long, with a zone that read() builds: that may take seconds.
  [[nodiscard]] static bool takes_zone(const adapters::HttpRequest& request);
  /// Reads a request, without the core: any thread may. The error is the response to a request that is no call.
  [[nodiscard]] static tl::expected<ReadCall, adapters::HttpResponse> read(adapters::HttpRequest request,
                                                                           const ZoneLibrary& zones);
  /// Handles a call. A call that changes something is responded to once its commands are durable. Changes are handled
  /// one after the other, so that each is checked against what the one before has made of the platform, and after the
  /// commands that an earlier process accepted. A Stop waits for nothing.
  void handle(ReadCall read, Respond respond);
  /// The core has handled an input: changes that waited for the commands of an earlier process are handled.
  void continue_changes() {
    if (!changes_.empty()) handle_changes();
  }
  /// Gives the core a Stop at once. A Restart of the same vehicles that was sent earlier and still waits does not lift
  /// it: one that waits for its turn is refused, and after the one that waits for the disk the Stop is given again.
  [[nodiscard]] adapters::HttpResponse stop(const StopRequest& stop);
  /// Reads and handles a request now; the commands that it gave may not be decided yet.
  [[nodiscard]] adapters::HttpResponse response(const adapters::HttpRequest& request);

  /// The obstacles that the emulated world reports: the only ones that can be removed.
  void know_plant(std::set<std::string> obstacles) { context_.know_plant(std::move(obstacles)); }

  struct Route {
    std::string_view method;
    std::string_view pattern;                                    ///< "/api/v1/virtual-objects/{id}"
    enum class Body : std::uint8_t { none, object, zone } body;  ///< `zone`: an object, from which read() makes a zone
    adapters::HttpResponse (*handler)(CallContext&, const Call&);
  };
  [[nodiscard]] static std::span<const Route> routes();

  [[nodiscard]] const PageHost& host() const { return context_.host(); }
  /// The context common to its calls.
  [[nodiscard]] const CallContext& context() const { return context_; }

 private:
  [[nodiscard]] adapters::HttpResponse response(const ReadCall& read);
  /// A change that waits for its turn, or, the first one, for its commands to be decided.
  struct Change {
    ReadCall read;
    Respond respond;
    std::optional<adapters::HttpResponse> response;  ///< that counts when its commands are stored
  };
  void handle_changes();
  /// Whether the next change, which has not been handled, waits for the commands of an earlier process.
  [[nodiscard]] bool waits_for_earlier_commands() const;
  /// Refuses the waiting Restarts of these vehicles; whether one of them has been given already.
  bool refuse_restarts(const std::vector<std::string>& vehicles);

  CallContext context_;
  std::vector<StopRequest> stops_to_repeat_;  ///< once the first of the changes is decided
  std::deque<Change> changes_;
  bool handling_{false};
};

}  // namespace cosiva::app
