#include "cosiva/adapters/http/http_server.h"

#include <algorithm>
#include <array>
#include <boost/asio/dispatch.hpp>
#include <boost/asio/io_context.hpp>
#include <boost/asio/ip/tcp.hpp>
#include <boost/asio/steady_timer.hpp>
#include <boost/beast/core.hpp>
#include <boost/beast/http.hpp>
#include <boost/beast/websocket/rfc6455.hpp>
#include <cmath>
#include <optional>
#include <set>
#include <utility>

#include "cosiva/adapters/http/frame_mailbox.h"
#include "cosiva/adapters/http/http_rules.h"
#include "cosiva/adapters/http/live_stream.h"
#include "cosiva/base/expect.h"
#include "cosiva/base/json_writer.h"

namespace cosiva::adapters {
namespace {

namespace asio = boost::asio;
namespace beast = boost::beast;
namespace http = beast::http;
namespace websocket = beast::websocket;
using tcp = asio::ip::tcp;
using ErrorCode = beast::error_code;
using Steady = std::chrono::steady_clock;
using Request = http::request<http::string_body>;
using Response = http::response<http::string_body>;

constexpr std::string_view live_path = "/api/v1/live";
constexpr std::string_view api_prefix = "/api/";
constexpr std::uint32_t header_bytes_max = 16 * 1024;
constexpr std::chrono::seconds linger_max{2};
constexpr std::chrono::milliseconds accept_again{100};
constexpr std::size_t drained_bytes_max = 16 * 1024 * 1024;
/// Whole files that are received at the same time: each may fill the memory allowed for one.
constexpr std::size_t large_bodies_max = 2;

std::string_view view(beast::string_view text) { return {text.data(), text.size()}; }

}  // namespace

std::string HttpRequest::parameter(std::string_view name) const {
  for (std::string_view rest = query; !rest.empty();) {
    const std::size_t end = std::min(rest.find('&'), rest.size());
    const std::string_view pair = rest.substr(0, end);
    const std::size_t equals = std::min(pair.find('='), pair.size());
    if (pair.substr(0, equals) == name) return std::string(pair.substr(std::min(equals + 1, pair.size())));
    rest.remove_prefix(std::min(end + 1, rest.size()));
  }
  return {};
}

HttpResponse http_error(unsigned status, std::string_view code, std::string_view message) {
  JsonWriter json;
  json.begin_object().key("error").begin_object().field("code", code).field("message", message);
  json.end_object().end_object();
  return {status, "application/json", json.take(), {}};
}

// --- common to the sessions -----------------------------------------------------------------------------------------

class HttpSession;

/// Invariant: at most clients_max sessions are open, and none is accepted after close().
struct HttpServer::Impl : std::enable_shared_from_this<HttpServer::Impl> {
  Impl(EventLoop& loop, HttpOptions options_, Handler api_)
      : acceptor{loop.context()},
        retry{loop.context()},
        options{std::move(options_)},
        api{std::move(api_)},
        live{std::make_shared<LiveStream>(options.request_timeout, options.live_timeout)} {}

  Result<void> listen();
  void accept();
  /// Accepts the next connection: at once, or after a pause where the last attempt failed.
  void accept_soon(const ErrorCode& error);
  /// Closes the connection that has waited for its next request the longest, where there are too many; false: all of
  /// them are in use.
  bool make_room();
  /// @param request  its body is moved to the API
  HttpResponse response(Request& request) const;
  HttpResponse too_many() const;
  HttpResponse respond_to_api(Request& request, std::string_view target) const;
  /// Offers the frames of the mailbox to the clients.
  void send_frames();
  void close();

  tcp::acceptor acceptor;
  asio::steady_timer retry;
  HttpOptions options;
  Handler api;
  std::uint16_t port{0};
  bool closed{false};
  std::set<HttpSession*> sessions;
  std::shared_ptr<LiveStream> live;
  FrameMailbox mailbox;
  std::size_t large_bodies{0};  ///< being received now
};

using Shared = std::shared_ptr<HttpServer::Impl>;

namespace {

/// Header fields of every response.
Response finish(const Request& request, HttpResponse plain) {
  Response response{static_cast<http::status>(plain.status), request.version()};
  response.set(http::field::content_type, plain.content_type);
  response.set(http::field::cache_control, "no-cache");
  response.set("X-Content-Type-Options", "nosniff");
  response.set("Referrer-Policy", "no-referrer");
  response.set("Content-Security-Policy",
               "default-src 'self'; connect-src 'self' ws:; style-src 'self' 'unsafe-inline'; img-src 'self' data:; "
               "frame-ancestors 'none'; base-uri 'none'; form-action 'none'");
  for (const auto& [name, value] : plain.headers) response.set(name, value);
  response.keep_alive(request.keep_alive());
  response.body() = std::move(plain.body);
  response.prepare_payload();
  if (request.method() == http::verb::head) response.body().clear();  // the length stays announced
  return response;
}

}  // namespace

// --- one HTTP connection --------------------------------------------------------------------------------------------

/// Reads one request after the other from a connection and writes their responses.
///
/// Invariant: the session is counted among the server's large bodies exactly while `large_` is set.
class HttpSession : public std::enable_shared_from_this<HttpSession> {
 public:
  HttpSession(Shared server, tcp::socket socket)
      : server_{std::move(server)},
        stream_{std::move(socket)},
        rate_{server_->options.requests_per_second, server_->options.requests_burst, std::chrono::steady_clock::now()} {
    server_->sessions.insert(this);
  }
  ~HttpSession() {
    end_large();
    server_->sessions.erase(this);
  }

  void start() { read(server_->options.request_timeout); }

  void close() {
    server_->sessions.erase(this);
    ErrorCode ignored;
    stream_.socket().shutdown(tcp::socket::shutdown_both, ignored);
    stream_.close();
  }

  /// Since when it waits for a request; nothing while it handles one.
  [[nodiscard]] std::optional<Steady::time_point> waits_since() const { return waits_since_; }

 private:
  void read(std::chrono::milliseconds limit) {
    waits_since_ = Steady::now();
    parser_.emplace();
    parser_->header_limit(header_bytes_max);
    // The limit of a body depends on its path, which is in the header.
    body_bytes_max_ = server_->options.body_bytes_max;
    parser_->body_limit(std::max(body_bytes_max_, server_->options.large_body_bytes_max));
    stream_.expires_after(limit);
    http::async_read_header(
        stream_, buffer_, *parser_,
        [self = shared_from_this()](const ErrorCode& error, std::size_t) { self->on_header(error); });
  }

  void on_header(const ErrorCode& error) {
    if (error) return on_read(error);
    waits_since_.reset();
    const HttpOptions& options = server_->options;
    const auto announced = parser_->content_length();
    const bool large = view(parser_->get().target()) == options.large_body_path && options.large_body_bytes_max > 0;
    // A body without an announced length may become large too.
    if (large && (parser_->chunked() || announced.value_or(0) > body_bytes_max_)) {
      if (server_->large_bodies >= large_bodies_max)
        return refuse(http_error(503, "http.busy", "other clients are sending whole files; try again in a moment"));
      large_ = true;
      ++server_->large_bodies;
      body_bytes_max_ = options.large_body_bytes_max;
    }
    if (announced.value_or(0) > body_bytes_max_) return on_read(http::error::body_limit);
    parser_->body_limit(body_bytes_max_);
    stream_.expires_after(options.request_timeout);
    http::async_read(stream_, buffer_, *parser_,
                     [self = shared_from_this()](const ErrorCode& bad, std::size_t) { self->on_read(bad); });
  }

  void on_read(const ErrorCode& error) {
    end_large();
    if (error == http::error::end_of_stream || error == beast::error::timeout) return close();
    if (error == http::error::body_limit)
      return refuse(
          http_error(413, "http.body", "a request's body may have " + std::to_string(body_bytes_max_) + " bytes here"));
    if (error == http::error::header_limit)
      return refuse(http_error(431, "http.header", "the request's header is too long"));
    if (error.category() == make_error_code(http::error::bad_method).category() && error)
      return refuse(http_error(400, "http.malformed", "not an HTTP request: " + error.message()));
    if (error) return close();

    Request& request = parser_->get();
    if (websocket::is_upgrade(request) && view(request.target()).substr(0, live_path.size()) == live_path) {
      if (auto refusal = refuse_upgrade(request)) return refuse(std::move(*refusal));
      stream_.expires_never();
      server_->live->accept(stream_.release_socket(), request);
      return;
    }
    respond(rate_.take(std::chrono::steady_clock::now()) ? server_->response(request) : server_->too_many());
  }

  void respond(HttpResponse plain) {
    if (!plain.later) return write(finish(parser_->get(), std::move(plain)));
    stream_.expires_never();
    plain.later([self = shared_from_this()](HttpResponse response) { self->respond(std::move(response)); });
  }

  void end_large() {
    if (!std::exchange(large_, false)) return;
    COSIVA_EXPECT(server_->large_bodies > 0);
    --server_->large_bodies;
  }

  [[nodiscard]] std::optional<HttpResponse> refuse_upgrade(const Request& request) const {
    if (!http_rules::is_loopback_authority(view(request[http::field::host])))
      return http_error(403, "http.host", "this server accepts this machine's own names only");
    const auto origin = request.find(http::field::origin);
    if (origin != request.end() &&
        !http_rules::is_own_origin(view(origin->value()), view(request[http::field::host]), server_->port))
      return http_error(403, "http.origin", "a page of another origin may not use the live stream");
    if (server_->live->clients() >= server_->options.clients_max)
      return http_error(503, "http.busy", "too many pages are open");
    return std::nullopt;
  }

  /// Responds to a request that could not be read properly, and closes: the rest of this stream cannot be trusted.
  void refuse(HttpResponse refusal) {
    Response response{static_cast<http::status>(refusal.status), 11};
    response.set(http::field::content_type, refusal.content_type);
    response.body() = std::move(refusal.body);
    response.keep_alive(false);
    response.prepare_payload();
    write(std::move(response));
  }

  void write(Response response) {
    response_.emplace(std::move(response));
    stream_.expires_after(server_->options.request_timeout);
    http::async_write(stream_, *response_, [self = shared_from_this()](const ErrorCode& error, std::size_t) {
      if (error) return self->close();
      if (self->response_->need_eof()) return self->linger();
      self->read(self->server_->options.idle_timeout);
    });
  }

  /// Closing with unread bytes would reset the connection and could drop our response with it: bytes that still arrive
  /// are read and discarded for a moment first.
  void linger() {
    ErrorCode ignored;
    stream_.socket().shutdown(tcp::socket::shutdown_send, ignored);
    stream_.expires_after(linger_max);
    drain();
  }

  void drain() {
    stream_.async_read_some(asio::buffer(drained_), [self = shared_from_this()](const ErrorCode& error, std::size_t n) {
      self->drained_bytes_ += n;
      if (error || self->drained_bytes_ > drained_bytes_max) return self->close();
      self->drain();
    });
  }

  Shared server_;
  beast::tcp_stream stream_;
  http_rules::RateLimit rate_;
  std::optional<Steady::time_point> waits_since_;
  beast::flat_buffer buffer_;
  std::optional<http::request_parser<http::string_body>> parser_;
  std::size_t body_bytes_max_{0};
  bool large_{false};  ///< counted among the server's large bodies
  std::optional<Response> response_;
  std::array<char, 4096> drained_;
  std::size_t drained_bytes_{0};
};

// --- the server -----------------------------------------------------------------------------------------------------

Result<void> HttpServer::Impl::listen() {
  ErrorCode error;
  for (int i = 0; i < std::max(options.ports_tried, 1) && options.port + i <= 65535; ++i) {
    const tcp::endpoint endpoint{asio::ip::address_v4::loopback(), static_cast<std::uint16_t>(options.port + i)};
    error.clear();
    acceptor.open(endpoint.protocol(), error);
    if (!error) acceptor.set_option(asio::socket_base::reuse_address(true), error);
    if (!error) acceptor.bind(endpoint, error);
    if (!error) acceptor.listen(asio::socket_base::max_listen_connections, error);
    if (!error) {
      port = acceptor.local_endpoint(error).port();
      accept();
      return {};
    }
    ErrorCode ignored;
    acceptor.close(ignored);
  }
  return fail("http.port", "no port from " + std::to_string(options.port) + " on is available: " + error.message(),
              "127.0.0.1:" + std::to_string(options.port));
}

bool HttpServer::Impl::make_room() {
  if (sessions.size() < options.clients_max) return true;
  HttpSession* longest = nullptr;
  for (HttpSession* session : sessions) {
    if (session->waits_since() && (longest == nullptr || *session->waits_since() < *longest->waits_since()))
      longest = session;
  }
  if (longest != nullptr) longest->close();
  return longest != nullptr;
}

void HttpServer::Impl::accept_soon(const ErrorCode& error) {
  if (!error) return accept();
  // Out of descriptors: the connection stays in the queue, and another attempt at once would fail again.
  retry.expires_after(accept_again);
  retry.async_wait([weak = weak_from_this()](const ErrorCode& cancelled) {
    const auto self = weak.lock();
    if (self && !self->closed && !cancelled) self->accept();
  });
}

void HttpServer::Impl::accept() {
  acceptor.async_accept([weak = weak_from_this()](const ErrorCode& error, tcp::socket socket) {
    const auto self = weak.lock();
    if (!self || self->closed) return;
    ErrorCode ignored;
    if (!error) socket.set_option(tcp::no_delay(true), ignored);
    if (!error && self->make_room()) std::make_shared<HttpSession>(self, std::move(socket))->start();
    COSIVA_EXPECT(self->sessions.size() <= self->options.clients_max);
    self->accept_soon(error);
  });
}

HttpResponse HttpServer::Impl::response(Request& request) const {
  if (!http_rules::is_loopback_authority(view(request[http::field::host])))
    return http_error(403, "http.host", "this server accepts this machine's own names only");
  const std::string_view target = view(request.target());
  const auto path = http_rules::clean_path(target.substr(0, target.find('?')));
  if (!path) return http_error(400, "http.path", "this is not a path of this server");
  if (*path == "/api" || path->starts_with(api_prefix)) return respond_to_api(request, target);

  if (request.method() != http::verb::get && request.method() != http::verb::head) {
    HttpResponse refusal = http_error(405, "http.method", "pages can only be read");
    refusal.headers.emplace_back("Allow", "GET, HEAD");
    return refusal;
  }
  auto file = options.web_root.empty() ? fail("http.not_found", "no page is built")
                                       : http_rules::load_static(options.web_root, *path);
  if (!file) {
    if (*path == "/" && !options.page_without_web_root.empty())
      return {200, "text/html; charset=utf-8", options.page_without_web_root, {}};
    return http_error(404, file.error().code, file.error().message);
  }
  HttpResponse found{200, std::string(file->mime), std::move(file->bytes), {{"ETag", file->etag}}};
  if (http_rules::etag_matches(view(request[http::field::if_none_match]), file->etag)) {
    found.status = 304;
    found.body.clear();
  }
  return found;
}

HttpResponse HttpServer::Impl::too_many() const {
  HttpResponse refusal = http_error(429, "http.rate",
                                    "more than " + std::to_string(std::lround(options.requests_per_second)) +
                                        " requests a second came over this connection; send fewer requests, or use " +
                                        std::string(live_path));
  refusal.headers.emplace_back("Retry-After", "1");
  return refusal;
}

HttpResponse HttpServer::Impl::respond_to_api(Request& request, std::string_view target) const {
  const auto origin = request.find(http::field::origin);
  if (origin != request.end() &&
      !http_rules::is_own_origin(view(origin->value()), view(request[http::field::host]), port))
    return http_error(403, "http.origin", "a page of another origin may not send requests here");

  const std::size_t question = std::min(target.find('?'), target.size());
  const std::string_view path = target.substr(0, question);
  HttpRequest plain{std::string(view(request.method_string())), *http_rules::clean_path(path),
                    std::string(target.substr(std::min(question + 1, target.size()))), std::move(request.body()),
                    *http_rules::path_segments(path)};
  if (plain.path == live_path) return http_error(426, "http.upgrade", "this address expects WebSocket");
  // A form of a page of another origin can post anything but JSON without a preflight request of its browser.
  if (http_rules::changes_state(plain.method) && !plain.body.empty() &&
      !http_rules::is_json(view(request[http::field::content_type])))
    return http_error(415, "http.content_type",
                      "send the body as JSON, with the header 'content-type: application/json'");
  if (plain.method == "HEAD") plain.method = "GET";
  return api(std::move(plain));
}

void HttpServer::Impl::send_frames() {
  FrameMailbox::Items items = mailbox.take();
  for (std::size_t kind = 0; kind < items.size(); ++kind) {
    if (items[kind].kept.bytes) live->keep(kind, items[kind].kept);
    if (items[kind].newest.bytes) live->send(kind, items[kind].newest);
  }
}

void HttpServer::Impl::close() {
  closed = true;
  ErrorCode ignored;
  acceptor.close(ignored);
  retry.cancel();
  for (HttpSession* session : std::exchange(sessions, {})) session->close();
  live->close();
}

HttpServer::HttpServer() = default;
HttpServer::~HttpServer() {
  if (impl_) impl_->close();
}

Result<std::unique_ptr<HttpServer>> HttpServer::listen(EventLoop& loop, HttpOptions options, Handler api) {
  std::unique_ptr<HttpServer> made{new HttpServer};
  made->impl_ = std::make_shared<Impl>(loop, std::move(options), std::move(api));
  if (auto listening = made->impl_->listen(); !listening) return tl::unexpected(listening.error());
  return made;
}

std::uint16_t HttpServer::port() const { return impl_->port; }
std::size_t HttpServer::live_clients() const { return impl_->live->clients(); }

void HttpServer::send_live(std::size_t kind, LiveFrame bytes, bool binary, bool keep_for_new_clients) {
  if (impl_->mailbox.put(kind, {std::move(bytes), binary}, keep_for_new_clients))
    asio::dispatch(impl_->acceptor.get_executor(), [impl = impl_] { impl->send_frames(); });
}

void HttpServer::on_join(std::function<void(std::function<void()> ready)> action) {
  impl_->live->on_join(std::move(action));
}

}  // namespace cosiva::adapters
