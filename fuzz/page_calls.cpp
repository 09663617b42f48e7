// The page's HTTP calls: "METHOD /path?query", a line's end, and the body. For every request the response is one of the
// contract's, JSON with a message where it is a refusal, and the server goes on.
#include "cosiva/hmi/page_calls.h"

#include <algorithm>
#include <array>
#include <memory>
#include <string>

#include "cosiva/adapters/http/http_rules.h"
#include "cosiva/virtual/server/core/server_core.h"
#include "target.h"

namespace {

using namespace cosiva;

constexpr const char* oval = R"(
name = "ring"
format_version = 1
[vehicle]
length_m = 0.20
width_m = 0.12
[circuit]
start = { x = 0.0, y = 0.0, heading_deg = 0 }
closed = true
[[section]]
name = "south"
kind = "straight"
length_m = 2.0
[[section]]
name = "east"
kind = "arc"
radius_m = 0.5
angle_deg = 180
[[section]]
name = "north"
kind = "straight"
length_m = 2.0
[[section]]
name = "west"
kind = "arc"
radius_m = 0.5
angle_deg = 180
)";

constexpr const char* online =
    R"({"headerId":0,"timestamp":"2023-07-11T00:00:00.000Z","version":"2.1.0","manufacturer":"CoSiVA",)"
    R"("serialNumber":"AIV1","connectionState":"ONLINE"})";

/// One zone by its name, and no folder for edits: the fuzzer uses no file.
class OneZone : public app::ZoneLibrary {
 public:
  [[nodiscard]] std::vector<Entry> zones() const override { return {{"oval", "an oval"}}; }
  [[nodiscard]] Result<zone::ZoneConfiguration> load(const std::string& name) const override {
    COSIVA_EXPECT(name.find('/') == std::string::npos);
    if (name == "oval") return zone::ZoneConfiguration{"toml", "oval", oval, {}};
    return fail("zone.missing", "there is no zone of this name", name);
  }
  [[nodiscard]] Result<zone::ZoneConfiguration> read(const std::string& file) const override {
    return fail("zone.missing", "there is no such zone file", file);
  }
  [[nodiscard]] Result<std::string> edits_folder() const override { return fail("zone.folder", "there is no folder"); }
  [[nodiscard]] Result<void> write(const std::string& file, const zone::ZoneConfiguration&) const override {
    return fail("file.write", "there is no such folder", file);
  }
  [[nodiscard]] std::string file_ending(std::string_view format) const override { return "." + std::string(format); }
  [[nodiscard]] std::string_view sidecar_ending() const override { return ".zone.toml"; }
};

struct Server {
  Server() : core{options()}, calls{host()} {
    core.handle({now, wire::InputKind::link, "", "up", false}, effects);
    core.handle({now, wire::InputKind::message, "uagv/v2/CoSiVA/AIV1/connection", online, false}, effects);
    calls.know_plant({"box1"});
  }
  static virtual_side::ServerOptions options() {
    virtual_side::ServerOptions options;
    options.zone = zone::ZoneConfiguration{"toml", "ring", oval};
    return options;
  }
  app::PageHost host() {
    app::PageHost host;
    host.core = &core;
    host.command = [this](const std::string& source, std::string json,
                          std::shared_ptr<const virtual_side::DecodedCommand> decoded,
                          const app::PageHost::Decided& decided) {
      effects.clear();
      core.handle({now, wire::InputKind::command, source, std::move(json), false, std::move(decoded)}, effects);
      decided({});
    };
    host.now = [this] { return now; };
    host.zones = std::make_shared<const OneZone>();
    host.clock = [] { return app::PageHost::Clock{true, false, 1.0}; };
    host.set_clock = [](bool, double speed) { COSIVA_EXPECT(speed >= 0.1 && speed <= 100.0); };
    host.step = [this](SimDuration by) {
      COSIVA_EXPECT(by > SimDuration::zero() && by <= std::chrono::seconds{10});
      now += by;
    };
    host.zone_file = "/nowhere/ring.toml";  // cannot be saved
    return host;
  }

  SimTime now{virtual_epoch};
  wire::Effects effects;
  virtual_side::ServerCore core;
  app::PageCalls calls;
};

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  static Server server;
  const std::string_view text = fuzz::as_text(data, size);
  const std::string_view line = text.substr(0, text.find('\n'));
  const std::size_t space = std::min(line.find(' '), line.size());
  const std::string_view target = line.substr(std::min(space + 1, line.size()));
  const std::string_view path = target.substr(0, target.find('?'));
  const auto clean = adapters::http_rules::clean_path(path);
  const auto segments = adapters::http_rules::path_segments(path);
  COSIVA_EXPECT(clean.has_value() == segments.has_value());
  if (!clean) return 0;

  const std::string query{target.substr(std::min(path.size() + 1, target.size()))};
  const std::string body{text.substr(std::min(line.size() + 1, text.size()))};
  const auto response = server.calls.response({std::string(line.substr(0, space)), *clean, query, body, *segments});
  constexpr std::array known{200U, 201U, 202U, 400U, 404U, 405U, 409U, 429U, 500U};
  COSIVA_EXPECT(std::ranges::find(known, response.status) != known.end());
  if (response.content_type == "application/json") {
    const auto json = JsonValue::parse(response.body);
    COSIVA_EXPECT(json.has_value());
    if (response.status >= 400)
      COSIVA_EXPECT(json->find("error") != nullptr && !json->find("error")->text("message").value_or("").empty());
  }
  server.now += std::chrono::milliseconds{20};
  server.effects.clear();
  server.core.handle({server.now, wire::InputKind::tick, "", "", false}, server.effects);
  return 0;
}
