#include "cosiva/adapters/http/live_stream.h"

#include <gmock/gmock.h>

#include <algorithm>
#include <boost/asio/io_context.hpp>
#include <boost/asio/ip/tcp.hpp>
#include <boost/beast/core.hpp>
#include <boost/beast/websocket.hpp>
#include <optional>
#include <thread>

#include "cosiva/adapters/test_fixture.h"

namespace cosiva::adapters {
namespace {

namespace asio = boost::asio;
namespace beast = boost::beast;
namespace http = beast::http;
namespace websocket = beast::websocket;
using namespace std::chrono_literals;
using testing::timeout;

/// A server without a page, and clients of its live stream on the same loop.
class LiveClients : public ::testing::Test {
 protected:
  void serve(HttpOptions options = {}) {
    options.port = 0;
    auto listening = HttpServer::listen(
        loop, options, [](const HttpRequest&) { return http_error(404, "http.not_found", "no such call"); });
    ASSERT_TRUE(listening) << to_string(listening.error());
    server = std::move(*listening);
  }

  EventLoop loop;
  std::unique_ptr<HttpServer> server;
};

HttpServer::LiveFrame frame(std::string bytes) { return std::make_shared<const std::string>(std::move(bytes)); }

/// A browser's end of /api/v1/live.
struct Live {
  websocket::stream<beast::tcp_stream> socket;
  beast::flat_buffer buffer;
  std::vector<std::string> frames;
  std::optional<beast::error_code> opened;
  bool closed{false};

  Live(EventLoop& loop, std::uint16_t port, const std::string& host, const std::string& origin)
      : socket{loop.context()} {
    socket.next_layer().connect({asio::ip::address_v4::loopback(), port});
    if (!origin.empty()) {
      socket.set_option(websocket::stream_base::decorator(
          [origin](websocket::request_type& request) { request.set(http::field::origin, origin); }));
    }
    socket.async_handshake(host, "/api/v1/live", [this](beast::error_code error) { opened = error; });
  }
  void listen() {
    socket.async_read(buffer, [this](beast::error_code error, std::size_t) {
      if (error) {
        closed = true;
        return;
      }
      frames.push_back((socket.got_binary() ? "binary:" : "") + beast::buffers_to_string(buffer.data()));
      buffer.clear();
      listen();
    });
  }
};

TEST_F(LiveClients, get_the_stored_frame_first_then_new_ones) {
  serve();
  server->send_live(0, frame("zone"), false, true);
  server->send_live(1, frame("old snapshot"));
  Live page{loop, server->port(), "localhost", {}};
  ASSERT_TRUE(loop.run_until([&] { return page.opened.has_value(); }, timeout));
  ASSERT_FALSE(*page.opened);
  EXPECT_EQ(server->live_clients(), 1U);
  page.listen();
  ASSERT_TRUE(loop.run_until([&] { return page.frames.size() == 1; }, timeout));
  server->send_live(1, frame("snapshot"));
  ASSERT_TRUE(loop.run_until([&] { return page.frames.size() == 2; }, timeout));
  EXPECT_THAT(page.frames, ::testing::ElementsAre("zone", "snapshot"));
}

TEST_F(LiveClients, get_stored_frames_in_the_order_of_their_kinds_renewed_as_they_join) {
  serve();
  server->send_live(4, frame("old key"), true, true);
  server->send_live(0, frame("zone"), false, true);
  server->on_join([&](const std::function<void()>& ready) {
    server->send_live(4, frame("key"), true, true);
    ready();
  });
  Live page{loop, server->port(), "localhost", {}};
  ASSERT_TRUE(loop.run_until([&] { return page.opened.has_value(); }, timeout));
  page.listen();
  ASSERT_TRUE(loop.run_until([&] { return page.frames.size() == 2; }, timeout));
  server->send_live(5, frame("delta"), true);
  server->send_live(3, frame("truth"));
  ASSERT_TRUE(loop.run_until([&] { return page.frames.size() == 4; }, timeout));
  EXPECT_THAT(page.frames, ::testing::ElementsAre("zone", "binary:key", "truth", "binary:delta"))
      << "of frames sent at the same time lower kinds go first";
}

TEST_F(LiveClients, that_join_get_no_frame_before_the_stored_ones_are_renewed_by_another_thread) {
  serve();
  server->send_live(0, frame("old zone"), false, true);
  std::function<void()> ready;
  server->on_join([&](std::function<void()> call) { ready = std::move(call); });
  Live page{loop, server->port(), "localhost", {}};
  ASSERT_TRUE(loop.run_until([&] { return page.opened.has_value() && ready; }, timeout));
  page.listen();
  loop.run_for(50ms);
  EXPECT_TRUE(page.frames.empty());
  std::thread{[&] {
    server->send_live(0, frame("zone"), false, true);
    ready();
  }}.join();
  ASSERT_TRUE(loop.run_until([&] { return !page.frames.empty(); }, timeout));
  EXPECT_THAT(page.frames, ::testing::ElementsAre("zone"));
}

TEST_F(LiveClients, that_never_read_hold_one_frame_in_transit_and_one_of_each_kind) {
  serve();
  Live stuck{loop, server->port(), "localhost", {}};
  ASSERT_TRUE(loop.run_until([&] { return stuck.opened.has_value(); }, timeout));
  std::vector<std::weak_ptr<const std::string>> sent;
  const std::string padding(100'000, '.');
  for (std::size_t i = 0; i < 600; ++i) {
    auto one = frame(std::to_string(i) + padding);
    sent.push_back(one);
    server->send_live(i % HttpServer::live_kinds, std::move(one), i % 2 == 0);
    if (i % 50 == 0) loop.run_for(std::chrono::milliseconds{1});
  }
  const auto held = std::ranges::count_if(sent, [](const auto& weak) { return !weak.expired(); });
  // One of each kind in transit to the server's loop, one of each kind for the client, one in transit.
  EXPECT_LE(held, 2 * static_cast<std::ptrdiff_t>(HttpServer::live_kinds) + 1);
  EXPECT_GE(held, 2);  // the client does not read, so a frame waits
  stuck.listen();      // once the client reads, it gets the newest of each kind
  const std::string newest = "599" + padding;
  EXPECT_TRUE(loop.run_until([&] { return !stuck.frames.empty() && stuck.frames.back() == newest; }, timeout));
}

TEST_F(LiveClients, of_another_origin_are_refused) {
  serve();
  Live wrong_host{loop, server->port(), "evil.example", {}};
  Live wrong_origin{loop, server->port(), "localhost", "http://evil.example"};
  ASSERT_TRUE(loop.run_until([&] { return wrong_host.opened && wrong_origin.opened; }, timeout));
  EXPECT_EQ(*wrong_host.opened, websocket::error::upgrade_declined);
  EXPECT_EQ(*wrong_origin.opened, websocket::error::upgrade_declined);
  EXPECT_EQ(server->live_clients(), 0U);
}

TEST_F(LiveClients, that_are_slow_miss_frames_but_get_the_newest) {
  serve();
  Live slow{loop, server->port(), "localhost", {}};
  Live quick{loop, server->port(), "localhost", {}};
  ASSERT_TRUE(loop.run_until([&] { return slow.opened && quick.opened; }, timeout));
  quick.listen();
  constexpr std::size_t count = 200;
  const std::string padding(100'000, '.');
  for (std::size_t i = 0; i < count; ++i) {
    server->send_live(1, frame(std::to_string(i) + padding));
    ASSERT_TRUE(loop.run_until([&] { return quick.frames.size() == i + 1; }, timeout));
  }
  slow.listen();  // 20 MB were offered; the kernel's buffers hold a few frames, the server holds one
  const std::string newest = std::to_string(count - 1) + padding;
  ASSERT_TRUE(loop.run_until([&] { return !slow.frames.empty() && slow.frames.back() == newest; }, timeout));
  EXPECT_LT(slow.frames.size(), count);
}

TEST_F(LiveClients, that_stop_responding_are_dropped) {
  HttpOptions options;
  options.live_timeout = 200ms;
  serve(options);
  Live dead{loop, server->port(), "localhost", {}};
  ASSERT_TRUE(loop.run_until([&] { return dead.opened.has_value(); }, timeout));
  EXPECT_EQ(server->live_clients(), 1U);  // the client never reads, so it responds to no ping
  EXPECT_TRUE(loop.run_until([&] { return server->live_clients() == 0; }, timeout));
}

TEST_F(LiveClients, that_send_too_much_are_closed) {
  serve();
  Live chatty{loop, server->port(), "localhost", {}};
  ASSERT_TRUE(loop.run_until([&] { return chatty.opened.has_value(); }, timeout));
  chatty.listen();
  const std::string much(100'000, 'x');
  chatty.socket.async_write(asio::buffer(much), [](beast::error_code, std::size_t) {});
  EXPECT_TRUE(loop.run_until([&] { return chatty.closed && server->live_clients() == 0; }, timeout));
}

TEST_F(LiveClients, fifty_of_them_all_receive_the_same) {
  serve();
  std::vector<std::unique_ptr<Live>> pages;
  for (int i = 0; i < 50; ++i) pages.push_back(std::make_unique<Live>(loop, server->port(), "127.0.0.1:8080", ""));
  ASSERT_TRUE(loop.run_until([&] { return server->live_clients() == 50; }, timeout));
  const auto all_open = [&] {
    return std::ranges::all_of(pages, [](const auto& page) { return page->opened.has_value(); });
  };
  ASSERT_TRUE(loop.run_until(all_open, timeout));
  for (auto& page : pages) page->listen();
  server->send_live(1, frame("snapshot"));
  const auto all_received = [&] {
    return std::ranges::all_of(pages, [](const auto& page) { return page->frames.size() == 1; });
  };
  EXPECT_TRUE(loop.run_until(all_received, timeout));
}

TEST_F(LiveClients, are_closed_when_the_server_is_destroyed) {
  serve();
  Live page{loop, server->port(), "localhost", {}};
  ASSERT_TRUE(loop.run_until([&] { return page.opened.has_value(); }, timeout));
  page.listen();
  server.reset();
  EXPECT_TRUE(loop.run_until([&] { return page.closed; }, timeout));
}

}  // namespace
}  // namespace cosiva::adapters
