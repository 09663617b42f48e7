#pragma once

#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include "cosiva/adapters/http/http_rules.h"
#include "cosiva/app/resources/file_zone_library.h"
#include "cosiva/hmi/page_calls.h"
#include "cosiva/virtual/server/testing/server_fixture.h"

/// For tests: the page's calls over a real server core with two vehicles on lacet4, in virtual time.
namespace cosiva::app::fixture {

namespace server_fixture = virtual_side::fixture;

struct PageFixture {
  PageFixture() {
    const auto position = [&](const char* section, double s_m) {
      return zone::TrackPosition{*server.zone->circuit.find(section), s_m};
    };
    server.add("AIV1", position("east", 0.5));
    server.add("AIV2", position("west", 0.5));
    server.run_for(std::chrono::seconds{3});
  }

  PageHost host() {
    PageHost host;
    host.core = server.server.get();
    host.command = [this](const std::string& source, std::string json,
                          std::shared_ptr<const virtual_side::DecodedCommand> decoded,
                          const PageHost::Decided& decided) {
      commands.push_back(json);
      server.feed(wire::InputKind::command, source, std::move(json), false, std::move(decoded));
      decided({});
    };
    host.now = [this] { return server.now; };
    host.zones = std::make_shared<const FileZoneLibrary>();
    host.run_name = "bench";
    host.zone_file = zone_file;
    host.clock = [this] { return clock; };
    host.set_clock = [this](bool running, double speed) {
      clock.running = running;
      clock.speed = speed;
    };
    host.step = [this](SimDuration by) { server.run_for(by); };
    return host;
  }

  adapters::HttpResponse send_request(const std::string& method, const std::string& target,
                                      const std::string& body = {}) {
    if (!calls) calls.emplace(host());
    const std::size_t question = std::min(target.find('?'), target.size());
    const std::string path = target.substr(0, question);
    adapters::HttpRequest request{method, *adapters::http_rules::clean_path(path),
                                  target.substr(std::min(question + 1, target.size())), body,
                                  *adapters::http_rules::path_segments(path)};
    return calls->response(request);
  }
  /// The text of the response's field `name`; empty when there is none.
  static std::string field_of(const adapters::HttpResponse& response, const char* name) {
    const auto json = JsonValue::parse(response.body);
    return json ? json->text(name).value_or("") : "";
  }
  /// The message of a refusal.
  static std::string sentence(const adapters::HttpResponse& response) {
    const auto json = JsonValue::parse(response.body);
    const JsonValue* error = json ? json->find("error") : nullptr;
    return error == nullptr ? "" : error->text("message").value_or("");
  }

  server_fixture::ServerFixture server{server_fixture::zone_file("lacet4.toml")};
  PageHost::Clock clock{true, true, 1.0};
  std::string zone_file;
  std::vector<std::string> commands;  ///< as the core received them
  std::optional<PageCalls> calls;     ///< from the first request on
};

}  // namespace cosiva::app::fixture
