#include "cosiva/adapters/http_client.h"

#include <boost/asio/io_context.hpp>
#include <boost/asio/ip/tcp.hpp>
#include <boost/beast/core.hpp>
#include <boost/beast/http.hpp>
#include <charconv>
#include <cstdint>
#include <utility>

namespace cosiva::adapters {
namespace {

namespace asio = boost::asio;
namespace beast = boost::beast;
namespace http = beast::http;
using tcp = asio::ip::tcp;
using ErrorCode = beast::error_code;

constexpr std::size_t response_bytes_max = std::size_t{256} << 20U;
constexpr std::chrono::seconds connect_max{5};

/// One request and its response on a connection of its own: resolve, connect, write, read, each followed by the next.
class Exchange {
 public:
  Exchange(http::request<http::string_body> request, std::chrono::milliseconds timeout)
      : resolver_{io_}, stream_{io_}, request_{std::move(request)}, timeout_{timeout} {
    parser_.body_limit(response_bytes_max);
  }

  void run(const std::string& host, const std::string& port) {
    resolver_.async_resolve(host, port, [this](ErrorCode error, const tcp::resolver::results_type& found) {
      if (failed(error)) return;
      stream_.expires_after(connect_max);
      stream_.async_connect(found, [this](ErrorCode refused, const tcp::endpoint&) {
        if (failed(refused)) return;
        connected_ = true;
        write();
      });
    });
    io_.run();
  }

  [[nodiscard]] ErrorCode error() const { return error_; }
  [[nodiscard]] bool connected() const { return connected_; }
  [[nodiscard]] HttpReply take() { return {parser_.get().result_int(), std::move(parser_.get().body())}; }

 private:
  bool failed(ErrorCode error) {
    error_ = error;
    return static_cast<bool>(error);
  }

  void write() {
    stream_.expires_after(timeout_);
    http::async_write(stream_, request_, [this](ErrorCode error, std::size_t) {
      // A server that refuses a long body may respond before it has received all of it.
      (void)error;
      read();
    });
  }

  void read() {
    http::async_read(stream_, buffer_, parser_, [this](ErrorCode error, std::size_t) { failed(error); });
  }

  asio::io_context io_;
  tcp::resolver resolver_;
  beast::tcp_stream stream_;
  http::request<http::string_body> request_;
  beast::flat_buffer buffer_;
  http::response_parser<http::string_body> parser_;
  std::chrono::milliseconds timeout_;
  ErrorCode error_;
  bool connected_{false};
};

}  // namespace

Result<HttpClient> HttpClient::make(std::string_view url) {
  constexpr std::string_view scheme = "http://";
  const auto bad = [&] {
    return fail("http.url", "expected an address such as http://127.0.0.1:8080", std::string(url.substr(0, 200)));
  };
  if (!url.starts_with(scheme)) return bad();
  std::string_view authority = url.substr(scheme.size());
  if (authority.ends_with('/')) authority.remove_suffix(1);
  if (authority.empty() || authority.find_first_of("/?#@ \t\r\n") != std::string_view::npos) return bad();

  HttpClient client;
  client.authority_ = authority;
  const std::size_t bracket = authority.starts_with('[') ? authority.find(']') : 0;
  if (bracket == std::string_view::npos) return bad();
  const std::size_t colon = authority.find(':', bracket);
  client.host_ = authority.substr(0, colon);
  if (bracket > 0) client.host_ = client.host_.substr(1, bracket - 1);
  client.port_ = colon == std::string_view::npos ? "80" : std::string(authority.substr(colon + 1));
  std::uint16_t port = 0;
  const char* end = client.port_.data() + client.port_.size();
  const auto [stop, error] = std::from_chars(client.port_.data(), end, port);
  if (client.host_.empty() || error != std::errc{} || stop != end || port == 0) return bad();
  return client;
}

Result<HttpReply> HttpClient::send_request(std::string_view method, std::string_view path, std::string body,
                                           std::chrono::milliseconds timeout) const {
  http::request<http::string_body> request;
  request.version(11);
  request.method_string({method.data(), method.size()});
  request.target({path.data(), path.size()});
  request.set(http::field::host, authority_);
  if (!body.empty()) request.set(http::field::content_type, "application/json");
  request.body() = std::move(body);
  request.keep_alive(false);
  request.prepare_payload();
  Exchange exchange{std::move(request), timeout};
  exchange.run(host_, port_);
  if (!exchange.error()) return exchange.take();
  const std::string why = exchange.error().message();
  if (!exchange.connected())
    return fail("http.connect", "no server responds there (" + why + "); is the platform running (cosiva up)?", url());
  return fail("http.response", "no complete response: " + why, url());
}

}  // namespace cosiva::adapters
