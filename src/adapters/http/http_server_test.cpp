#include "cosiva/adapters/http/http_server.h"

#include <gmock/gmock.h>

#include <boost/asio/connect.hpp>
#include <boost/asio/io_context.hpp>
#include <boost/asio/ip/tcp.hpp>
#include <boost/asio/read.hpp>
#include <boost/asio/write.hpp>
#include <boost/beast/core.hpp>
#include <boost/beast/http.hpp>
#include <optional>

#include "cosiva/adapters/test_fixture.h"

namespace cosiva::adapters {
namespace {

namespace asio = boost::asio;
namespace beast = boost::beast;
namespace http = beast::http;
using namespace std::chrono_literals;
using tcp = asio::ip::tcp;
using ::testing::HasSubstr;
using testing::Scratch;
using ::testing::StartsWith;
using testing::timeout;

/// A server with a page and a small API, and clients on the same loop.
class Http : public ::testing::Test {
 protected:
  Http() {
    scratch.write("web/index.html", "<title>CoSiVA</title>");
    scratch.write("web/assets/app.js", "let x = 1;");
    scratch.write("secret.txt", "secret");
  }

  void serve(HttpOptions options = {}) {
    options.port = 0;
    if (options.web_root.empty()) options.web_root = scratch / "web";
    auto listening = HttpServer::listen(loop, options, [this](const HttpRequest& request) {
      requested.push_back(request.method + " " + request.path + "?" + request.query + " " + request.body);
      segments = request.segments;
      if (request.path == "/api/v1/echo") return HttpResponse{202, "application/json", request.body, {{"X-Echo", "1"}}};
      return http_error(404, "http.not_found", "no such call");
    });
    ASSERT_TRUE(listening) << to_string(listening.error());
    server = std::move(*listening);
  }

  /// Sends raw bytes, returns all bytes received until the server closes (or `limit`).
  std::string raw(const std::string& bytes, std::chrono::milliseconds limit = timeout) {
    tcp::socket socket{loop.context()};
    socket.connect({asio::ip::address_v4::loopback(), server->port()});
    bool closed = false;
    std::string response;
    std::array<char, 4096> buffer;
    std::function<void()> read = [&] {
      socket.async_read_some(asio::buffer(buffer), [&](beast::error_code error, std::size_t n) {
        response.append(buffer.data(), n);
        if (error)
          closed = true;
        else
          read();
      });
    };
    asio::async_write(socket, asio::buffer(bytes), [](beast::error_code, std::size_t) {});
    read();
    loop.run_until([&] { return closed; }, limit);
    beast::error_code ignored;
    socket.close(ignored);
    loop.run_until([&] { return closed; }, timeout);
    return response;
  }

  std::string get(const std::string& target, const std::string& more = {}) {
    return raw("GET " + target + " HTTP/1.1\r\nHost: localhost\r\nConnection: close\r\n" + more + "\r\n");
  }

  Scratch scratch;
  EventLoop loop;
  std::vector<std::string> requested;
  std::vector<std::string> segments;  ///< of the last call
  std::unique_ptr<HttpServer> server;
};

TEST_F(Http, serves_the_page_with_type_tag_and_guards) {
  serve();
  const std::string page = get("/");
  EXPECT_THAT(page, StartsWith("HTTP/1.1 200"));
  EXPECT_THAT(page, HasSubstr("Content-Type: text/html"));
  EXPECT_THAT(page, HasSubstr("Cache-Control: no-cache"));
  EXPECT_THAT(page, HasSubstr("X-Content-Type-Options: nosniff"));
  EXPECT_THAT(page, HasSubstr("Content-Security-Policy: default-src 'self'"));
  EXPECT_THAT(page, HasSubstr("<title>CoSiVA</title>"));
  EXPECT_THAT(get("/assets/app.js?v=1"), HasSubstr("text/javascript"));

  const std::size_t at = page.find("ETag: ") + 6;
  const std::string tag = page.substr(at, page.find('\r', at) - at);
  const std::string unchanged = get("/", "If-None-Match: " + tag + "\r\n");
  EXPECT_THAT(unchanged, StartsWith("HTTP/1.1 304"));
  EXPECT_EQ(unchanged.find("<title>"), std::string::npos);
}

TEST_F(Http, head_has_the_length_but_no_body) {
  serve();
  const std::string response = raw("HEAD / HTTP/1.1\r\nHost: localhost\r\nConnection: close\r\n\r\n");
  EXPECT_THAT(response, HasSubstr("Content-Length: 21"));
  EXPECT_EQ(response.find("<title>"), std::string::npos);
}

TEST_F(Http, reuses_a_connection_for_the_next_request) {
  serve();
  const std::string one = "GET /assets/app.js HTTP/1.1\r\nHost: localhost\r\n\r\n";
  const std::string last = "GET / HTTP/1.1\r\nHost: localhost\r\nConnection: close\r\n\r\n";
  const std::string responses = raw(one + one + last);  // also pipelined
  EXPECT_THAT(responses, HasSubstr("let x = 1;"));
  EXPECT_THAT(responses, HasSubstr("<title>CoSiVA</title>"));
}

TEST_F(Http, passes_method_path_query_and_body_to_the_api) {
  serve();
  const std::string response =
      raw("POST /api/v1/echo?after=3&limit=10 HTTP/1.1\r\nHost: localhost\r\nConnection: close\r\n"
          "Content-Type: application/json\r\nContent-Length: 2\r\n\r\n{}");
  EXPECT_THAT(response, StartsWith("HTTP/1.1 202"));
  EXPECT_THAT(response, HasSubstr("X-Echo: 1"));
  EXPECT_THAT(requested, ::testing::ElementsAre("POST /api/v1/echo?after=3&limit=10 {}"));
  const HttpRequest request{"GET", "/", "after=3&limit=10&x", {}, {}};
  EXPECT_EQ(request.parameter("after"), "3");
  EXPECT_EQ(request.parameter("limit"), "10");
  EXPECT_EQ(request.parameter("x"), "");
  EXPECT_EQ(request.parameter("none"), "");
}

TEST_F(Http, passes_every_method_and_names_with_slashes_to_the_api) {
  serve();
  for (const std::string method : {"GET", "POST", "PUT", "PATCH", "DELETE"}) {
    requested.clear();
    raw(method +
        " /api/v1/virtual-objects/CoSiVA.virtual%2FV1 HTTP/1.1\r\nHost: localhost\r\nConnection: close\r\n\r\n");
    EXPECT_THAT(requested, ::testing::ElementsAre(method + " /api/v1/virtual-objects/CoSiVA.virtual/V1? "));
    EXPECT_THAT(segments, ::testing::ElementsAre("api", "v1", "virtual-objects", "CoSiVA.virtual/V1"));
  }
  EXPECT_THAT(get("/api/v1/virtual-objects/..%2Fx"), StartsWith("HTTP/1.1 400"));
  requested.clear();
  get("/api");
  EXPECT_THAT(requested, ::testing::ElementsAre("GET /api? "));
}

TEST_F(Http, accepts_bodies_as_json_only) {
  serve();
  const std::string head = " /api/v1/echo HTTP/1.1\r\nHost: localhost\r\nConnection: close\r\n";
  const std::string body = "Content-Length: 2\r\n\r\n{}";
  for (const std::string method : {"POST", "PUT", "PATCH", "DELETE"}) {
    EXPECT_THAT(raw(method + head + "Content-Type: text/plain\r\n" + body), StartsWith("HTTP/1.1 415"));
    EXPECT_THAT(raw(method + head + body), StartsWith("HTTP/1.1 415"));
  }
  EXPECT_TRUE(requested.empty());
  EXPECT_THAT(raw("PUT" + head + "Content-Type: application/json; charset=utf-8\r\n" + body),
              StartsWith("HTTP/1.1 202"));
}

TEST_F(Http, changes_nothing_for_a_page_of_another_origin) {
  serve();
  for (const std::string method : {"POST", "PUT", "PATCH", "DELETE"}) {
    const std::string response = raw(method +
                                     " /api/v1/echo HTTP/1.1\r\nHost: localhost\r\nConnection: close\r\n"
                                     "Origin: http://evil.example\r\nContent-Length: 0\r\n\r\n");
    EXPECT_THAT(response, StartsWith("HTTP/1.1 403")) << method;
  }
  EXPECT_TRUE(requested.empty());
}

TEST_F(Http, limits_a_connection_with_too_many_requests_and_no_other) {
  HttpOptions options;
  options.requests_per_second = 1.0;
  options.requests_burst = 3.0;
  serve(options);
  const std::string one = "GET /api/v1/echo HTTP/1.1\r\nHost: localhost\r\n\r\n";
  const std::string last = "GET /api/v1/echo HTTP/1.1\r\nHost: localhost\r\nConnection: close\r\n\r\n";
  const std::string responses = raw(one + one + one + last);
  EXPECT_EQ(requested.size(), 3U);
  EXPECT_THAT(responses, HasSubstr("HTTP/1.1 429"));
  EXPECT_THAT(responses, HasSubstr("Retry-After: 1"));
  EXPECT_THAT(responses, HasSubstr("send fewer requests"));
  EXPECT_THAT(get("/api/v1/echo"), StartsWith("HTTP/1.1 202"));
}

TEST_F(Http, reports_missing_paths_as_json) {
  serve();
  EXPECT_THAT(get("/api/v1/nothing"), HasSubstr(R"({"error":{"code":"http.not_found","message":"no such call"}})"));
  EXPECT_THAT(get("/nothing"), StartsWith("HTTP/1.1 404"));
  EXPECT_THAT(get("/api/v1/live"), StartsWith("HTTP/1.1 426"));
  EXPECT_THAT(raw("DELETE / HTTP/1.1\r\nHost: localhost\r\nConnection: close\r\n\r\n"), StartsWith("HTTP/1.1 405"));
}

TEST_F(Http, without_a_built_page_explains_how_to_build_it) {
  HttpOptions options;
  options.web_root = scratch / "nowhere";
  options.page_without_web_root = "build me";
  serve(options);
  EXPECT_THAT(get("/"), HasSubstr("build me"));
  EXPECT_THAT(get("/x"), StartsWith("HTTP/1.1 404"));
}

TEST_F(Http, refuses_names_and_origins_that_are_not_this_machine) {
  serve();
  EXPECT_THAT(raw("GET / HTTP/1.1\r\nHost: evil.example\r\nConnection: close\r\n\r\n"), StartsWith("HTTP/1.1 403"));
  EXPECT_THAT(raw("GET / HTTP/1.1\r\nConnection: close\r\n\r\n"), StartsWith("HTTP/1.1 403"));
  EXPECT_THAT(get("/api/v1/echo", "Origin: http://evil.example\r\n"), StartsWith("HTTP/1.1 403"));
  EXPECT_THAT(get("/api/v1/echo", "Origin: null\r\n"), StartsWith("HTTP/1.1 403"));
  EXPECT_THAT(get("/api/v1/echo", "Origin: http://localhost:1\r\n"), StartsWith("HTTP/1.1 403"));
  EXPECT_TRUE(requested.empty());
  const std::string own = "Origin: http://127.0.0.1:" + std::to_string(server->port()) + "\r\n";
  EXPECT_THAT(get("/api/v1/echo", own), StartsWith("HTTP/1.1 202"));
}

TEST_F(Http, refuses_paths_that_lead_out_of_the_root) {
  serve();
  for (const char* path : {"/../secret.txt", "/%2e%2e/secret.txt", "/assets/../../secret.txt", "/..%2fsecret.txt"}) {
    const std::string response = get(path);
    EXPECT_THAT(response, StartsWith("HTTP/1.1 400")) << path;
    EXPECT_EQ(response.find("secret\n"), std::string::npos);
  }
}

TEST_F(Http, accepts_a_larger_body_on_the_one_path_for_files) {
  HttpOptions options;
  options.large_body_path = "/api/v1/echo";
  options.large_body_bytes_max = 100'000;
  serve(options);
  const auto post = [&](const std::string& path, std::size_t bytes) {
    return raw("POST " + path +
               " HTTP/1.1\r\nHost: localhost\r\nConnection: close\r\nContent-Type: application/json\r\n" +
               "Content-Length: " + std::to_string(bytes) + "\r\n\r\n" + std::string(bytes, 'x'));
  };
  EXPECT_THAT(post("/api/v1/echo", 70'000), StartsWith("HTTP/1.1 202"));
  EXPECT_THAT(post("/api/v1/echo", 100'001), StartsWith("HTTP/1.1 413"));
  EXPECT_THAT(post("/api/v1/other", 70'000), StartsWith("HTTP/1.1 413"));
  EXPECT_THAT(post("/api/v1/echo", 70'000), StartsWith("HTTP/1.1 202")) << "a refused body no longer counts";
}

TEST_F(Http, receives_few_large_bodies_at_the_same_time) {
  HttpOptions options;
  options.large_body_path = "/api/v1/echo";
  options.large_body_bytes_max = 100'000;
  serve(options);
  const std::string head =
      "POST /api/v1/echo HTTP/1.1\r\nHost: localhost\r\nContent-Type: application/json\r\nContent-Length: "
      "70000\r\n\r\n";
  std::vector<tcp::socket> slow;
  for (int i = 0; i < 2; ++i) {
    slow.emplace_back(loop.context()).connect({asio::ip::address_v4::loopback(), server->port()});
    asio::write(slow.back(), asio::buffer(head));
  }
  loop.run_until([] { return false; }, 50ms);
  EXPECT_THAT(raw(head), StartsWith("HTTP/1.1 503"));
  slow.clear();
  loop.run_until([] { return false; }, 50ms);
  EXPECT_THAT(
      raw("POST /api/v1/echo HTTP/1.1\r\nHost: localhost\r\nConnection: close\r\nContent-Type: application/json\r\n"
          "Content-Length: 70000\r\n\r\n" +
          std::string(70'000, 'x')),
      StartsWith("HTTP/1.1 202"));
}

TEST_F(Http, responds_to_oversized_and_malformed_requests_with_their_reason_and_stays_up) {
  serve();
  const std::string head = "POST /api/v1/echo HTTP/1.1\r\nHost: localhost\r\n";
  EXPECT_THAT(raw(head + "Content-Length: 70000\r\n\r\n" + std::string(70'000, 'x')), StartsWith("HTTP/1.1 413"));
  EXPECT_THAT(get("/", "X: " + std::string(20'000, 'x') + "\r\n"), StartsWith("HTTP/1.1 431"));
  EXPECT_THAT(raw("NONSENSE\r\n\r\n"), StartsWith("HTTP/1.1 400"));
  EXPECT_THAT(raw(head + "Content-Length: -5\r\n\r\n"), StartsWith("HTTP/1.1 400"));
  EXPECT_THAT(raw(std::string("\x16\x03\x01\x02\x00\x01\x00\x01\xfc", 9) + "\r\n\r\n"), StartsWith("HTTP/1.1 400"));
  EXPECT_TRUE(requested.empty());
  EXPECT_THAT(get("/"), StartsWith("HTTP/1.1 200"));
}

TEST_F(Http, drops_a_client_that_never_finishes_its_request) {
  HttpOptions options;
  options.request_timeout = 100ms;
  serve(options);
  EXPECT_EQ(raw("GET / HT"), "");  // returns only because the server closed
}

TEST_F(Http, takes_the_next_port_when_one_is_busy_and_reports_it) {
  serve();
  HttpOptions options;
  options.port = server->port();
  const auto next = HttpServer::listen(loop, options, {});
  ASSERT_TRUE(next);
  EXPECT_GT((*next)->port(), server->port());
  EXPECT_LE((*next)->port(), server->port() + 20);
  options.ports_tried = 1;
  const auto none = HttpServer::listen(loop, options, {});
  ASSERT_FALSE(none);
  EXPECT_EQ(none.error().code, "http.port");
}

TEST_F(Http, closes_the_connection_that_was_idle_longest_for_a_new_one_beyond_its_limit) {
  HttpOptions options;
  options.clients_max = 2;
  serve(options);
  std::vector<tcp::socket> idle;
  for (int i = 0; i < 2; ++i) {
    idle.emplace_back(loop.context()).connect({asio::ip::address_v4::loopback(), server->port()});
    loop.run_for(20ms);
  }
  EXPECT_THAT(get("/"), StartsWith("HTTP/1.1 200"));
  const auto is_closed = [](tcp::socket& socket) {
    socket.non_blocking(true);
    std::array<char, 1> byte{};
    boost::system::error_code error;
    socket.read_some(asio::buffer(byte), error);
    return error != asio::error::would_block;
  };
  EXPECT_TRUE(is_closed(idle[0]));
  EXPECT_FALSE(is_closed(idle[1]));
}

TEST_F(Http, drops_new_connections_while_all_up_to_its_limit_are_in_use) {
  HttpOptions options;
  options.clients_max = 2;
  serve(options);
  std::vector<tcp::socket> slow;
  for (int i = 0; i < 2; ++i) {
    slow.emplace_back(loop.context()).connect({asio::ip::address_v4::loopback(), server->port()});
    asio::write(slow.back(), asio::buffer(std::string("POST /api/v1/echo HTTP/1.1\r\nHost: localhost\r\n"
                                                      "Content-Type: application/json\r\nContent-Length: 9\r\n\r\n")));
  }
  loop.run_for(50ms);
  EXPECT_EQ(get("/"), "");
  slow.clear();
  loop.run_for(50ms);
  EXPECT_THAT(get("/"), StartsWith("HTTP/1.1 200"));
}

}  // namespace
}  // namespace cosiva::adapters
