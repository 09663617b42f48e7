#include "app/server_page.h"

#include <gmock/gmock.h>
#include <netinet/in.h>
#include <sys/socket.h>
#include <unistd.h>

#include <array>
#include <thread>

#include "adapters/test_bench.h"
#include "base/json_value.h"

namespace cosiva::app {
namespace {

using adapters::testing::patience;
using ::testing::HasSubstr;
using ::testing::StartsWith;

/// The real server core behind the real HTTP server, without a broker or a vehicle.
class Page : public ::testing::Test {
 protected:
  Page() {
    EXPECT_TRUE(shell.start());
    auto opened = ServerPage::open(loop, shell, core, 0, {}, false);
    EXPECT_TRUE(opened);
    page = std::move(*opened);
  }
  static adapters::LiveOptions options() {
    adapters::LiveOptions live;
    live.kind = "server";
    live.name = "server";
    live.options = virtual_side::to_json({});
    return live;
  }

  /// One request; the answer until the server closes.
  std::string ask(const std::string& first_line, const std::string& body = {}) {
    const int fd = ::socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC, 0);
    sockaddr_in address{};
    address.sin_family = AF_INET;
    address.sin_port = htons(page->port());
    address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
    // NOLINTNEXTLINE(cppcoreguidelines-pro-type-reinterpret-cast)
    EXPECT_EQ(::connect(fd, reinterpret_cast<const sockaddr*>(&address), sizeof address), 0);
    const std::string request = first_line + " HTTP/1.1\r\nHost: localhost\r\nConnection: close\r\nContent-Length: " +
                                std::to_string(body.size()) + "\r\n\r\n" + body;
    EXPECT_EQ(::write(fd, request.data(), request.size()), static_cast<ssize_t>(request.size()));
    std::string answer;
    const auto closed = [&] {
      std::array<char, 4096> buffer;
      const ssize_t got = ::recv(fd, buffer.data(), buffer.size(), MSG_DONTWAIT);
      if (got > 0) answer.append(buffer.data(), static_cast<std::size_t>(got));
      return got == 0;
    };
    EXPECT_TRUE(loop.run_until(closed, patience));
    ::close(fd);
    return answer;
  }
  static std::string body_of(const std::string& answer) { return answer.substr(answer.find("\r\n\r\n") + 4); }

  adapters::EventLoop loop;
  virtual_side::ServerCore core{{}};
  adapters::LiveShell shell{loop, core, options()};
  std::unique_ptr<ServerPage> page;
};

TEST_F(Page, answers_the_four_questions_with_json) {
  EXPECT_EQ(body_of(ask("GET /api/v1/zone")), "null");
  for (const char* what : {"snapshot", "bijection", "traces", "traces?after=0&limit=5"}) {
    const std::string answer = ask(std::string("GET /api/v1/") + what);
    EXPECT_THAT(answer, StartsWith("HTTP/1.1 200")) << what;
    EXPECT_TRUE(JsonValue::parse(body_of(answer))) << what;
  }
}

TEST_F(Page, refuses_commands_that_make_no_sense_with_the_reason) {
  for (const char* bad : {"", "nonsense", "[]", R"({"command":"fly","vehicle":"*"})",
                          R"({"command":"stop","vehicle":"CoSiVA/AIV99"})", R"({"command":"stop"})"}) {
    const std::string answer = ask("POST /api/v1/commands", bad);
    EXPECT_THAT(answer, StartsWith("HTTP/1.1 400")) << bad;
    const auto body = JsonValue::parse(body_of(answer));
    ASSERT_TRUE(body && body->find("error") != nullptr) << answer;
    EXPECT_NE(body->find("error")->text("message"), "");
  }
}

TEST_F(Page, refuses_wrong_methods_calls_and_numbers) {
  EXPECT_THAT(ask("POST /api/v1/snapshot"), StartsWith("HTTP/1.1 405"));
  EXPECT_THAT(ask("GET /api/v1/commands"), StartsWith("HTTP/1.1 405"));
  EXPECT_THAT(ask("GET /api/v1/nothing"), StartsWith("HTTP/1.1 404"));
  EXPECT_THAT(ask("GET /api/v1/traces?after=-1"), StartsWith("HTTP/1.1 400"));
  EXPECT_THAT(ask("GET /api/v1/traces?limit=many"), StartsWith("HTTP/1.1 400"));
}

TEST_F(Page, that_is_not_built_says_how_to_build_it) { EXPECT_THAT(ask("GET /"), HasSubstr("npm run build")); }

}  // namespace
}  // namespace cosiva::app
