#include "cosiva/hmi/server_page.h"

#include <gmock/gmock.h>
#include <netinet/in.h>
#include <sys/socket.h>
#include <unistd.h>

#include <array>
#include <cstring>
#include <future>
#include <map>
#include <thread>

#include "cosiva/adapters/test_fixture.h"
#include "cosiva/base/json_value.h"
#include "cosiva/hmi/page_fixture.h"

namespace cosiva::app {
namespace {

using adapters::testing::timeout;
using namespace std::chrono_literals;
using ::testing::HasSubstr;
using ::testing::StartsWith;

int connect_to(std::uint16_t port) {
  const int fd = ::socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC, 0);
  sockaddr_in address{};
  address.sin_family = AF_INET;
  address.sin_port = htons(port);
  address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
  // NOLINTNEXTLINE(cppcoreguidelines-pro-type-reinterpret-cast)
  EXPECT_EQ(::connect(fd, reinterpret_cast<const sockaddr*>(&address), sizeof address), 0);
  return fd;
}

/// Reads the bytes received, without waiting; false when the other side has closed.
bool receive(int fd, std::string& into) {
  std::array<char, 65536> buffer;
  const ssize_t got = ::recv(fd, buffer.data(), buffer.size(), MSG_DONTWAIT);
  if (got > 0) into.append(buffer.data(), static_cast<std::size_t>(got));
  return got != 0;
}

/// A browser's end of the live stream, with the part of WebSocket that a server's frames need.
class LiveClient {
 public:
  struct Frame {
    bool binary;
    std::string bytes;
    [[nodiscard]] std::string type() const {
      if (binary) return (bytes[2] & 1) != 0 ? "key" : "delta";
      const auto json = JsonValue::parse(bytes);
      return json ? json->text("type").value_or("?") : "?";
    }
  };

  explicit LiveClient(std::uint16_t port) : fd_{connect_to(port)} {
    const std::string request =
        "GET /api/v1/live HTTP/1.1\r\nHost: localhost\r\nUpgrade: websocket\r\nConnection: Upgrade\r\n"
        "Sec-WebSocket-Key: dGhlIHNhbXBsZSBub25jZQ==\r\nSec-WebSocket-Version: 13\r\n\r\n";
    EXPECT_EQ(::write(fd_, request.data(), request.size()), static_cast<ssize_t>(request.size()));
  }
  ~LiveClient() { ::close(fd_); }
  LiveClient(const LiveClient&) = delete;
  LiveClient& operator=(const LiveClient&) = delete;

  /// Reads the frames received.
  const std::vector<Frame>& frames() {
    receive(fd_, bytes_);
    if (!open_) {
      const std::size_t end = bytes_.find("\r\n\r\n");
      if (end == std::string::npos) return frames_;
      EXPECT_THAT(bytes_, StartsWith("HTTP/1.1 101"));
      bytes_.erase(0, end + 4);
      open_ = true;
    }
    while (take_frame()) {
    }
    return frames_;
  }
  std::size_t count(const std::string& type) {
    return static_cast<std::size_t>(std::ranges::count_if(frames(), [&](const Frame& f) { return f.type() == type; }));
  }
  const Frame* last(const std::string& type) {
    const Frame* found = nullptr;
    for (const Frame& frame : frames())
      if (frame.type() == type) found = &frame;
    return found;
  }

 private:
  bool take_frame() {
    const auto byte = [&](std::size_t i) { return static_cast<std::uint64_t>(static_cast<unsigned char>(bytes_[i])); };
    if (bytes_.size() < 2) return false;
    std::size_t at = 2;
    std::uint64_t length = byte(1) & 0x7FU;
    if (length >= 126) {
      const std::size_t wide = length == 126 ? 2 : 8;
      if (bytes_.size() < 2 + wide) return false;
      length = 0;
      for (std::size_t i = 0; i < wide; ++i) length = (length << 8U) | byte(at + i);
      at += wide;
    }
    if (bytes_.size() < at + length) return false;
    EXPECT_NE(byte(0) & 0x80U, 0U) << "a frame goes out whole";
    const auto opcode = byte(0) & 0xFU;
    if (opcode == 1 || opcode == 2) frames_.push_back({opcode == 2, bytes_.substr(at, length)});
    bytes_.erase(0, at + length);
    return true;
  }

  int fd_;
  std::string bytes_;
  bool open_{false};
  std::vector<Frame> frames_;
};

/// The real server core with two vehicles behind the real HTTP server, without a broker. The core's time stops unless a
/// test advances it.
class Page : public ::testing::Test {
 protected:
  Page() {
    auto opened = ServerPage::open(loop, fixture.host(), 0, {}, false);
    EXPECT_TRUE(opened);
    page = std::move(*opened);
    fixture.server.each_step = [this] { page->changed(); };
  }

  /// One request; the response until the server closes.
  std::string send_request(const std::string& first_line, const std::string& body = {}) {
    const int fd = connect_to(page->port());
    std::string request = first_line + " HTTP/1.1\r\nHost: localhost\r\nConnection: close\r\n";
    if (!body.empty()) request += "Content-Type: application/json\r\n";
    request += "Content-Length: " + std::to_string(body.size()) + "\r\n\r\n" + body;
    EXPECT_EQ(::write(fd, request.data(), request.size()), static_cast<ssize_t>(request.size()));
    std::string response;
    EXPECT_TRUE(loop.run_until([&] { return !receive(fd, response); }, timeout));
    ::close(fd);
    return response;
  }
  static std::string body_of(const std::string& response) { return response.substr(response.find("\r\n\r\n") + 4); }

  adapters::EventLoop loop;
  fixture::PageFixture fixture;
  std::unique_ptr<ServerPage> page;
  std::vector<std::unique_ptr<LiveClient>> clients;
};

TEST_F(Page, responds_over_http_and_refuses_with_the_reason) {
  EXPECT_THAT(send_request("GET /api/v1/zone"), StartsWith("HTTP/1.1 200"));
  EXPECT_THAT(send_request("POST /api/v1/commands", R"({"command":"slow","vehicle":"CoSiVA/AIV1"})"),
              StartsWith("HTTP/1.1 202"));
  for (const char* bad : {"nonsense", "[]", R"({"command":"fly","vehicle":"*"})",
                          R"({"command":"stop","vehicle":"CoSiVA/AIV99"})", R"({"command":"stop"})"}) {
    const std::string response = send_request("POST /api/v1/commands", bad);
    EXPECT_THAT(response, StartsWith("HTTP/1.1 400")) << bad;
    const auto body = JsonValue::parse(body_of(response));
    ASSERT_TRUE(body && body->find("error") != nullptr) << response;
    EXPECT_NE(body->find("error")->text("message"), "");
  }
  const std::string wrong = send_request("POST /api/v1/snapshot");
  EXPECT_THAT(wrong, StartsWith("HTTP/1.1 405"));
  EXPECT_THAT(wrong, HasSubstr("Allow: GET"));
  EXPECT_THAT(send_request("GET /api/v1/zone/file"), HasSubstr("attachment; filename=\"lacet4.toml\""));
}

TEST_F(Page, that_is_not_built_explains_how_to_build_it) {
  EXPECT_THAT(send_request("GET /"), HasSubstr("npm run build"));
}

TEST_F(Page, new_client_gets_zone_run_snapshot_and_key_at_once_and_in_this_order) {
  for (int i = 0; i < 2; ++i) {  // without and with an earlier client
    auto& client = clients.emplace_back(std::make_unique<LiveClient>(page->port()));
    ASSERT_TRUE(loop.run_until([&] { return client->count("delta") > 0; }, timeout));
    std::vector<std::string> types;  // in the order of their first arrival
    for (const LiveClient::Frame& frame : client->frames())
      if (std::ranges::find(types, frame.type()) == types.end()) types.push_back(frame.type());
    EXPECT_THAT(types, ::testing::ElementsAre("zone", "run", "snapshot", "key", "delta"));
  }
}

TEST_F(Page, sends_positions_based_on_the_key_and_periodic_snapshots) {
  LiveClient client{page->port()};
  ASSERT_TRUE(loop.run_until([&] { return client.count("delta") >= 10 && client.count("snapshot") >= 3; }, timeout));
  const LiveClient::Frame* key = client.last("key");
  EXPECT_EQ(key->bytes.size(), 24U + 2 * 20U);  // two vehicles
  EXPECT_EQ(client.count("zone"), 1U);
  EXPECT_EQ(client.count("run"), 1U);
  // The core's time and the vehicles are stopped: deltas are empty.
  EXPECT_EQ(client.last("delta")->bytes.size(), 24U);
}

TEST_F(Page, sends_a_snapshot_when_a_command_has_an_effect) {
  LiveClient client{page->port()};
  ASSERT_TRUE(loop.run_until([&] { return client.count("snapshot") == 1; }, timeout));
  EXPECT_THAT(send_request("POST /api/v1/commands", R"({"command":"slow","vehicle":"CoSiVA/AIV1","id":"mine"})"),
              StartsWith("HTTP/1.1 202"));
  page->changed();
  const auto shows = [&](const std::string& state) {
    return loop.run_until(
        [&] {
          const LiveClient::Frame* last = client.last("snapshot");
          return last->bytes.find("\"id\":\"mine\",\"vehicle\":\"CoSiVA/AIV1\",\"command\":\"slow\",\"state\":\"" +
                                  state) != std::string::npos;
        },
        timeout);
  };
  EXPECT_TRUE(shows("issued"));
  fixture.server.run_for(2s);
  EXPECT_TRUE(shows("materialised"));
}

TEST_F(Page, sends_the_clock_when_it_changed) {
  LiveClient client{page->port()};
  ASSERT_TRUE(loop.run_until([&] { return client.count("run") == 1; }, timeout));
  EXPECT_THAT(send_request("PUT /api/v1/clock", R"({"running":false,"speed":4})"), StartsWith("HTTP/1.1 200"));
  ASSERT_TRUE(loop.run_until([&] { return client.count("run") == 2; }, timeout));
  const auto run = JsonValue::parse(client.last("run")->bytes);
  EXPECT_EQ(run->find("run")->find("clock")->flag("running"), false);
  EXPECT_EQ(run->find("run")->find("clock")->number("speed"), 4.0);
}

TEST_F(Page, sends_vehicles_and_obstacles_of_the_ground_truth_and_nothing_else) {
  LiveClient client{page->port()};
  ASSERT_TRUE(loop.run_until([&] { return client.count("key") == 1; }, timeout));
  for (const char* bad : {"", "nonsense", "[]", "5"}) page->ground_truth(bad);
  page->ground_truth(R"({"type":"zone","zone":null,"vehicles":[{"number":1,"x":0.5,"y":0.25,"heading":0}],)"
                     R"("obstacles":[{"id":"box1","x":1,"y":2,"radius":0.05}]})");
  ASSERT_TRUE(loop.run_until([&] { return client.count("ground_truth") == 1; }, timeout));
  EXPECT_EQ(client.last("ground_truth")->bytes,
            R"({"type":"ground_truth","vehicles":[{"number":1,"x":0.5,"y":0.25,"heading":0}],)"
            R"("obstacles":[{"id":"box1","x":1,"y":2,"radius":0.05}]})");
  EXPECT_EQ(client.count("zone"), 1U);
  EXPECT_THAT(send_request("DELETE /api/v1/plant/obstacles/box1"), StartsWith("HTTP/1.1 200"));
}

TEST_F(Page, publishes_a_stop_and_responds_while_the_loop_of_the_core_is_blocked) {
  PageHost host = fixture.host();
  std::promise<std::string> published;
  host.stop_line.send = [&](const std::string& id, const std::vector<std::string>&) {
    published.set_value(id);
    return true;
  };
  const auto other = ServerPage::open(loop, std::move(host), 0, {}, true);
  ASSERT_TRUE(other);
  // The loop does not run: this thread waits for the response itself.
  const int fd = connect_to((*other)->port());
  const std::string body = R"({"command":"stop","vehicle":"*"})";
  const std::string request =
      "POST /api/v1/commands HTTP/1.1\r\nHost: localhost\r\nConnection: close\r\nContent-Type: application/json\r\n"
      "Content-Length: " +
      std::to_string(body.size()) + "\r\n\r\n" + body;
  ASSERT_EQ(::write(fd, request.data(), request.size()), static_cast<ssize_t>(request.size()));
  std::string response;
  while (receive(fd, response)) std::this_thread::sleep_for(1ms);
  ::close(fd);
  EXPECT_THAT(response, StartsWith("HTTP/1.1 202"));
  EXPECT_THAT(response, HasSubstr("not yet durable"));
  EXPECT_THAT(response, HasSubstr(published.get_future().get()));
  EXPECT_THAT(fixture.commands, ::testing::IsEmpty());
  EXPECT_TRUE(loop.run_until([&] { return fixture.commands.size() == 1; }, timeout)) << "the core gets it later";
}

TEST_F(Page, responds_to_new_requests_while_a_long_body_is_read) {
  // The body is half there: the page's thread goes on with other requests, and so does the core.
  const int fd = connect_to(page->port());
  const std::string half = R"({"format":"toml","origin":"a","text":")" + std::string(std::size_t{1} << 20U, 'x');
  const std::string request =
      "POST /api/v1/zone/switch HTTP/1.1\r\nHost: localhost\r\nContent-Type: application/json\r\nContent-Length: " +
      std::to_string(2 * half.size()) + "\r\n\r\n" + half;
  ASSERT_EQ(::write(fd, request.data(), request.size()), static_cast<ssize_t>(request.size()));
  EXPECT_THAT(send_request("GET /api/v1/zone"), StartsWith("HTTP/1.1 200"));
  ::close(fd);
}

TEST_F(Page, new_client_after_a_pause_gets_the_present_state) {
  {
    LiveClient leaving{page->port()};
    ASSERT_TRUE(loop.run_until([&] { return leaving.count("key") == 1; }, timeout));
  }
  loop.run_for(100ms);  // the server detects that the client is gone
  fixture.server.run_for(5s);
  const auto now = JsonValue::parse(fixture.server.server->snapshot_json())->number("time_ms");
  LiveClient client{page->port()};
  ASSERT_TRUE(loop.run_until([&] { return client.count("snapshot") >= 1; }, timeout));
  const auto shown = JsonValue::parse(client.frames()[2].bytes);
  EXPECT_EQ(shown->find("snapshot")->number("time_ms"), now);
}

}  // namespace
}  // namespace cosiva::app
