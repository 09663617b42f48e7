#include "cosiva/adapters/http/live_stream.h"

#include <algorithm>
#include <boost/asio/buffer.hpp>
#include <boost/asio/dispatch.hpp>
#include <boost/beast/core/flat_buffer.hpp>
#include <boost/beast/core/tcp_stream.hpp>
#include <boost/beast/websocket.hpp>
#include <utility>

#include "cosiva/base/expect.h"

namespace cosiva::adapters {
namespace {

namespace asio = boost::asio;
namespace beast = boost::beast;
namespace http = beast::http;
namespace websocket = beast::websocket;
using tcp = asio::ip::tcp;
using ErrorCode = beast::error_code;

/// Data that waits in the kernel is stale by the time it is read: the buffer holds a few frames only.
constexpr int send_buffer_bytes = 64 * 1024;
constexpr std::size_t live_message_bytes_max = 4 * 1024;

}  // namespace

/// The live stream to one page.
///
/// Invariant: at most one write is in progress, and `writing_` holds its bytes.
class LiveSession : public std::enable_shared_from_this<LiveSession> {
 public:
  LiveSession(std::shared_ptr<LiveStream> stream, tcp::socket socket)
      : stream_{std::move(stream)}, socket_{std::move(socket)} {
    stream_->sessions_.insert(this);
    stream_->clients_ = stream_->sessions_.size();
  }
  ~LiveSession() {
    stream_->sessions_.erase(this);
    stream_->clients_ = stream_->sessions_.size();
  }

  void start(const http::request<http::string_body>& request) {
    ErrorCode ignored;
    beast::get_lowest_layer(socket_).socket().set_option(asio::socket_base::send_buffer_size(send_buffer_bytes),
                                                         ignored);
    beast::get_lowest_layer(socket_).expires_never();  // the WebSocket layer has its own
    websocket::stream_base::timeout limits{};
    limits.handshake_timeout = stream_->handshake_limit_;
    limits.idle_timeout = stream_->idle_limit_;
    limits.keep_alive_pings = true;
    socket_.set_option(limits);
    socket_.read_message_max(live_message_bytes_max);
    socket_.auto_fragment(false);  // a frame is sent in one write, whatever its size
    socket_.async_accept(request, [self = shared_from_this()](const ErrorCode& error) {
      if (error) return;
      self->read();
      if (self->stream_->on_join_)
        self->stream_->on_join_(self->when_ready());
      else
        self->open();
    });
  }

  void offer(std::size_t kind, LiveStreamFrame frame) {
    next_[kind] = std::move(frame);
    write();
  }

  void close() {
    ErrorCode ignored;
    beast::get_lowest_layer(socket_).socket().close(ignored);
  }

 private:
  /// Opens the session from its own loop, whichever thread calls this.
  std::function<void()> when_ready() {
    return [weak = weak_from_this(), executor = socket_.get_executor()] {
      asio::dispatch(executor, [weak] {
        if (const auto self = weak.lock()) self->open();
      });
    };
  }

  void open() {
    if (std::exchange(open_, true)) return;
    for (std::size_t kind = 0; kind < LiveStream::kinds; ++kind) {
      const LiveStreamFrame& kept = stream_->kept_[kind];
      if (kept.bytes && !next_[kind].bytes) next_[kind] = kept;
    }
    write();
  }

  void read() {
    // The page sends no messages here; pings, the close and the peer's end are noticed by reading.
    socket_.async_read(incoming_, [self = shared_from_this()](const ErrorCode& error, std::size_t) {
      if (error) return self->close();
      self->incoming_.clear();
      self->read();
    });
  }

  void write() {
    if (!open_ || writing_) return;
    const auto due = std::ranges::find_if(next_, [](const LiveStreamFrame& frame) { return frame.bytes != nullptr; });
    if (due == next_.end()) return;
    socket_.binary(due->binary);
    writing_ = std::exchange(due->bytes, nullptr);
    socket_.async_write(asio::buffer(*writing_), [self = shared_from_this()](const ErrorCode& error, std::size_t) {
      COSIVA_EXPECT(self->writing_ != nullptr);
      self->writing_ = nullptr;
      if (error) return self->close();
      self->write();
    });
  }

  std::shared_ptr<LiveStream> stream_;
  websocket::stream<beast::tcp_stream> socket_;
  beast::flat_buffer incoming_;
  std::array<LiveStreamFrame, LiveStream::kinds> next_;
  HttpServer::LiveFrame writing_;
  bool open_{false};
};

void LiveStream::accept(tcp::socket socket, const http::request<http::string_body>& request) {
  if (closed_) return;
  const auto session = std::make_shared<LiveSession>(shared_from_this(), std::move(socket));
  COSIVA_EXPECT(sessions_.contains(session.get()));
  session->start(request);
}

void LiveStream::send(std::size_t kind, const LiveStreamFrame& frame) {
  for (LiveSession* session : sessions_) session->offer(kind, frame);
}

void LiveStream::close() {
  closed_ = true;
  for (LiveSession* session : sessions_) session->close();
}

}  // namespace cosiva::adapters
