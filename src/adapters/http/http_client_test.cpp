#include "cosiva/adapters/http/http_client.h"

#include <gmock/gmock.h>

#include <atomic>
#include <boost/asio/buffer.hpp>
#include <boost/asio/io_context.hpp>
#include <boost/asio/ip/tcp.hpp>
#include <boost/asio/write.hpp>
#include <chrono>
#include <cstdlib>
#include <memory>
#include <string>
#include <thread>
#include <utility>

#include "cosiva/adapters/http/http_server.h"
#include "cosiva/adapters/test_fixture.h"

namespace cosiva::adapters {
namespace {

TEST(HttpClient, takes_addresses_that_have_host_and_port) {
  for (const char* good : {"http://127.0.0.1:8080", "http://localhost:8080/", "http://[::1]:8080", "http://localhost"})
    EXPECT_TRUE(HttpClient::make(good)) << good;
  for (const char* bad :
       {"", "127.0.0.1:8080", "https://localhost", "http://", "http://:80", "http://h:0", "http://h:70000",
        "http://h:8x", "http://h/path", "http://me@h", "http://[::1", "http://h\r\nX: y"}) {
    const auto client = HttpClient::make(bad);
    ASSERT_FALSE(client) << bad;
    EXPECT_EQ(client.error().code, "http.url");
  }
}

/// Accepts one connection, sends these bytes whatever is requested, and keeps the connection open.
class RawServer {
 public:
  explicit RawServer(std::string bytes) {
    thread_ = std::thread{[this, bytes = std::move(bytes)] {
      acceptor_.accept(connection_);
      boost::asio::write(connection_, boost::asio::buffer(bytes));
    }};
  }
  ~RawServer() { thread_.join(); }
  RawServer(const RawServer&) = delete;
  RawServer& operator=(const RawServer&) = delete;
  [[nodiscard]] HttpClient client() const {
    return *HttpClient::make("http://127.0.0.1:" + std::to_string(acceptor_.local_endpoint().port()));
  }

 private:
  using Tcp = boost::asio::ip::tcp;
  boost::asio::io_context io_;
  Tcp::acceptor acceptor_{io_, {boost::asio::ip::address_v4::loopback(), 0}};
  Tcp::socket connection_{io_};
  std::thread thread_;
};

/// A server on a thread of its own, since the client waits for its responses.
class Serving {
 public:
  Serving() {
    HttpOptions options;
    options.port = 0;
    auto listening = HttpServer::listen(loop_, options, [](const HttpRequest& request) {
      return HttpResponse{
          request.body.empty() ? 200U : 202U, "application/json", request.method + " " + request.body, {}};
    });
    server_ = std::move(*listening);
    port = server_->port();
    thread_ = std::thread{[this] { loop_.run_until([this] { return over_.load(); }, testing::timeout); }};
  }
  ~Serving() {
    over_ = true;
    thread_.join();
  }
  Serving(const Serving&) = delete;
  Serving& operator=(const Serving&) = delete;
  std::uint16_t port{};

 private:
  EventLoop loop_;
  std::unique_ptr<HttpServer> server_;
  std::atomic<bool> over_{false};
  std::thread thread_;
};

TEST(HttpClient, sends_a_request_and_receives_the_response) {
  const Serving serving;
  const auto client = HttpClient::make("http://127.0.0.1:" + std::to_string(serving.port));
  ASSERT_TRUE(client);
  const auto got = client->send_request("GET", "/api/v1/x");
  ASSERT_TRUE(got) << to_string(got.error());
  EXPECT_EQ(got->status, 200U);
  EXPECT_EQ(got->body, "GET ");
  const auto posted = client->send_request("POST", "/api/v1/x", "{}");
  ASSERT_TRUE(posted) << to_string(posted.error());
  EXPECT_EQ(posted->status, 202U);
  EXPECT_EQ(posted->body, "POST {}");
}

TEST(HttpClient, receives_the_reason_why_a_body_is_too_long) {
  const Serving serving;
  const auto client = HttpClient::make("http://127.0.0.1:" + std::to_string(serving.port));
  const auto refused = client->send_request("POST", "/api/v1/x", std::string(1U << 20U, 'x'));
  ASSERT_TRUE(refused) << to_string(refused.error());
  EXPECT_EQ(refused->status, 413U);
}

TEST(HttpClient, uses_no_proxy_of_the_environment) {
  const Serving serving;
  ::setenv("http_proxy", "http://127.0.0.1:1", 1);
  const auto got =
      HttpClient::make("http://127.0.0.1:" + std::to_string(serving.port))->send_request("GET", "/api/v1/x");
  ::unsetenv("http_proxy");
  ASSERT_TRUE(got) << to_string(got.error());
  EXPECT_EQ(got->status, 200U);
}

TEST(HttpClient, reports_a_response_that_is_not_complete_in_time) {
  using namespace std::chrono_literals;
  for (const char* begun : {"", "HTTP/1.1 200 OK\r\n", "HTTP/1.1 200 OK\r\nContent-Length: 9\r\n\r\nhalf"}) {
    const RawServer server{begun};
    const auto start = std::chrono::steady_clock::now();
    const auto response = server.client().send_request("GET", "/", {}, 200ms);
    ASSERT_FALSE(response) << begun;
    EXPECT_EQ(response.error().code, "http.response") << begun;
    EXPECT_GE(std::chrono::steady_clock::now() - start, 150ms) << begun;
  }
}

TEST(HttpClient, refuses_a_response_above_the_size_limit) {
  const RawServer server{"HTTP/1.1 200 OK\r\nContent-Length: 268435457\r\n\r\n"};
  const auto response = server.client().send_request("GET", "/");
  ASSERT_FALSE(response);
  EXPECT_EQ(response.error().code, "http.response");
  EXPECT_EQ(response.error().message, "no complete response: body limit exceeded");
}

TEST(HttpClient, reports_when_no_service_responds) {
  std::uint16_t port = 0;
  {
    const Serving server;
    port = server.port;
  }
  const auto response = HttpClient::make("http://127.0.0.1:" + std::to_string(port))->send_request("GET", "/");
  ASSERT_FALSE(response);
  EXPECT_EQ(response.error().code, "http.connect");
  EXPECT_EQ(response.error().message,
            "no server responds there (Connection refused); is the platform running (cosiva up)?");
}

}  // namespace
}  // namespace cosiva::adapters
