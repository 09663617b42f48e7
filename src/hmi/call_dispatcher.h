#pragma once

#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <string>

#include "cosiva/adapters/event_loop.h"
#include "cosiva/adapters/http/http_server.h"
#include "cosiva/hmi/page_calls.h"
#include "cosiva/hmi/stop_calls.h"

namespace cosiva::app {

/// Takes the requests of the page's thread to the threads that handle them. A Stop is published from here, before
/// anything else is done with it. Bodies are read here, and the one that may be long, with a whole zone, by the worker,
/// which also builds the zone. All calls are handled by the core's loop, which gets them read; their responses come
/// back to the page's thread.
///
/// Invariant: respond() and the responses run on the page's thread; a request is waiting until its response has come,
/// once.
class CallDispatcher {
 public:
  struct Loops {
    adapters::EventLoop& page;    ///< of the HTTP server
    adapters::EventLoop& core;    ///< of the core, on which `calls` lives
    adapters::EventLoop& worker;  ///< may be busy for seconds
  };
  /// @param calls  used and destroyed on the core's loop only
  CallDispatcher(Loops loops, const std::shared_ptr<PageCalls>& calls);

  [[nodiscard]] adapters::HttpResponse respond(adapters::HttpRequest request);
  [[nodiscard]] std::size_t waiting() const { return waiting_.size(); }

 private:
  using ResponseId = std::uint64_t;
  using Respond = std::function<void(adapters::HttpResponse)>;
  [[nodiscard]] adapters::HttpResponse respond_to_stop(const JsonValue& body);
  void lift_stops(const std::string& command) const;
  /// A response that comes later: `begin` gets the id for respond_with().
  [[nodiscard]] adapters::HttpResponse later(std::function<void(ResponseId)> begin);
  /// Has the core's loop do something with the calls; from any thread.
  void hand_over(std::function<void(PageCalls&)> action);
  void hand_over(ResponseId response_id, PageCalls::ReadCall read);
  /// Sends a response; from any thread.
  void respond_with(ResponseId response_id, adapters::HttpResponse response);

  Loops loops_;
  std::weak_ptr<PageCalls> calls_;
  std::shared_ptr<const ZoneLibrary> zones_;
  std::shared_ptr<StopBook> stops_;
  StopLine line_;
  ResponseId last_{0};
  std::map<ResponseId, Respond> waiting_;
};

}  // namespace cosiva::app
