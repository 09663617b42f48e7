#pragma once

#include <array>
#include <atomic>
#include <boost/asio/ip/tcp.hpp>
#include <boost/beast/http/message.hpp>
#include <boost/beast/http/string_body.hpp>
#include <chrono>
#include <cstddef>
#include <functional>
#include <memory>
#include <set>
#include <string>

#include "cosiva/adapters/http/http_server.h"

namespace cosiva::adapters {

class LiveSession;

/// One frame of the live stream, and its type.
struct LiveStreamFrame {
  HttpServer::LiveFrame bytes;
  bool binary{false};
};

/// The WebSocket clients of /api/v1/live, and the frame of each kind that a new client gets first.
///
/// Invariant: `sessions_` holds exactly the sessions that exist: a session enters it when its handshake begins and
/// leaves it in its destructor; none enters after close(). `clients_` is their number.
class LiveStream : public std::enable_shared_from_this<LiveStream> {
 public:
  static constexpr std::size_t kinds = HttpServer::live_kinds;

  /// A client has `handshake_limit` for the upgrade; after `idle_limit` without a pong the client is dropped.
  LiveStream(std::chrono::milliseconds handshake_limit, std::chrono::milliseconds idle_limit)
      : handshake_limit_{handshake_limit}, idle_limit_{idle_limit} {}

  /// Upgrades the connection on which `request` arrived, and sends it frames until its end.
  void accept(boost::asio::ip::tcp::socket socket,
              const boost::beast::http::request<boost::beast::http::string_body>& request);
  /// Offers a frame of the kind (below `kinds`) to all clients.
  void send(std::size_t kind, const LiveStreamFrame& frame);
  /// The frame of the kind that a new client gets first.
  void keep(std::size_t kind, const LiveStreamFrame& frame) { kept_[kind] = frame; }
  /// As HttpServer::on_join().
  void on_join(std::function<void(std::function<void()> ready)> action) { on_join_ = std::move(action); }
  /// Closes all connections.
  void close();

  /// From any thread.
  [[nodiscard]] std::size_t clients() const { return clients_; }

 private:
  friend class LiveSession;

  std::chrono::milliseconds handshake_limit_;
  std::chrono::milliseconds idle_limit_;
  bool closed_{false};
  std::set<LiveSession*> sessions_;
  std::atomic<std::size_t> clients_{0};
  std::array<LiveStreamFrame, kinds> kept_;
  std::function<void(std::function<void()> ready)> on_join_;
};

}  // namespace cosiva::adapters
