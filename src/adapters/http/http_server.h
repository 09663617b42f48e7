#pragma once

#include <chrono>
#include <cstdint>
#include <functional>
#include <memory>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "cosiva/adapters/event_loop.h"
#include "cosiva/base/result.h"

namespace cosiva::adapters {

struct HttpRequest {
  std::string method;  ///< "GET", "POST", "PUT", "PATCH", "DELETE"
  std::string path;    ///< "/api/v1/zone": percent-decoded, without query
  std::string query;   ///< "after=3&limit=10": undecoded, without '?'
  std::string body;
  /// The path's parts, each decoded by itself: "virtual-objects/a%2Fb" is {"virtual-objects", "a/b"}.
  std::vector<std::string> segments;
  /// The value of a query parameter, or nothing.
  [[nodiscard]] std::string parameter(std::string_view name) const;
};

struct HttpResponse {
  unsigned status{200};
  std::string content_type{"application/json"};
  std::string body;
  std::vector<std::pair<std::string, std::string>> headers;  ///< further ones, such as Allow
  /// Where set, this is no response yet: the server calls it at once with a function that takes the response, from the
  /// server's loop, once.
  std::function<void(std::function<void(HttpResponse)> respond)> later{};
};
/// {"error":{"code","message"}} with this status.
[[nodiscard]] HttpResponse http_error(unsigned status, std::string_view code, std::string_view message);

struct HttpOptions {
  std::uint16_t port{8080};  ///< 0: any free one
  int ports_tried{21};       ///< a busy port's successors, up to this many in all
  std::string web_root;      ///< static files; empty or missing: the response to `/` is `page_without_web_root`
  std::string page_without_web_root;
  std::size_t body_bytes_max{64 * 1024};
  /// Bodies for this path may be larger, such as a whole file; few of them are received at the same time, further ones
  /// get status 503.
  std::string large_body_path;
  std::size_t large_body_bytes_max{0};
  std::size_t clients_max{512};
  double requests_per_second{200.0};  ///< of one connection, for longer than its burst; further ones get status 429
  double requests_burst{400.0};
  std::chrono::milliseconds request_timeout{10'000};
  std::chrono::milliseconds idle_timeout{60'000};  ///< between requests of one connection
  std::chrono::milliseconds live_timeout{20'000};  ///< after this long without a pong, a WebSocket peer is dropped
};

/// HTTP and WebSocket on 127.0.0.1 for the page. The server serves only this machine: requests whose Host or Origin is
/// not a loopback name are refused, so that a web page of another origin cannot reach it through the user's browser,
/// not even by DNS rebinding. Boost.Beast stays in the .cpp.
/// The server lives on the thread of its loop; only send_live() and live_clients() may be called from others.
class HttpServer {
 public:
  struct Impl;  ///< shared with its sessions, in the .cpp only
  using Handler = std::function<HttpResponse(HttpRequest)>;

  /// Listens. `api` handles every path under /api/. Fails ("http.port") when no port is available.
  [[nodiscard]] static Result<std::unique_ptr<HttpServer>> listen(EventLoop& loop, HttpOptions options, Handler api);
  ~HttpServer();

  [[nodiscard]] std::uint16_t port() const;
  /// From any thread.
  [[nodiscard]] std::size_t live_clients() const;

  /// One frame of /api/v1/live, one buffer for all its receivers.
  using LiveFrame = std::shared_ptr<const std::string>;
  /// Each frame has a kind. A client that reads slowly gets only the newest frame of each kind, lower kinds first: for
  /// one client the server holds one frame in transit and one waiting of each kind, however long the client does not
  /// read. A frame stored for new clients is also the first that a new client gets.
  /// Any thread may send; the frames of one thread are sent in its order.
  static constexpr std::size_t live_kinds = 6;
  void send_live(std::size_t kind, LiveFrame frame, bool binary = false, bool keep_for_new_clients = false);
  /// Calls `action` from the server's loop when a client has joined. The client gets its first frames once `ready` is
  /// called, from any thread, so that the stored frames can be renewed before. Set before the loop runs.
  void on_join(std::function<void(std::function<void()> ready)> action);

 private:
  HttpServer();
  std::shared_ptr<Impl> impl_;
};

}  // namespace cosiva::adapters
