#pragma once

// A run that uses every part of the server: for the test of its snapshots.

#include <gtest/gtest.h>

#include <functional>
#include <map>
#include <memory>
#include <string>
#include <utility>

#include "cosiva/base/json_writer.h"
#include "cosiva/experiments/runs/world/world.h"
#include "cosiva/zone/testing/test_zones.h"

namespace cosiva::experiments::testing {

inline zone::ZoneConfiguration zone_named(const std::string& name) {
  return zone::testing::configuration_file(name + ".toml");
}

inline std::string switch_to(const zone::ZoneConfiguration& configuration) {
  JsonWriter json;
  json.begin_object().field("command", "switch").key("zone");
  zone::write_json(json, configuration);
  return json.end_object().take();
}

/// Four physical and three virtual AIVs on lacet4, with message loss; every kind of command in 150 s.
class DisturbedRun {
 public:
  DisturbedRun(std::uint64_t seed, bool as_values) {
    WorldOptions options;
    options.zone = zone_named("lacet4");
    options.aivs = 4;
    options.seed = seed;
    options.network.loss = 0.02;
    options.as_values = as_values;
    server_options = options.server;
    server_options.as_values = as_values;
    auto made = World::make(std::move(options));
    EXPECT_TRUE(made.has_value());
    world = std::move(*made);
    schedule();
  }

  /// Runs one second, before which the commands that are due are given.
  void second() {
    for (auto [at, end] = steps_.equal_range(elapsed_s); at != end; ++at) at->second();
    world->run_for(std::chrono::seconds{1});
    ++elapsed_s;
  }

  static constexpr int length_s = 150;
  virtual_side::ServerOptions server_options;
  std::unique_ptr<World> world;
  int elapsed_s{0};

 private:
  void at(int s, std::string command) {
    steps_.emplace(s, [this, command = std::move(command)] { world->command_server(command); });
  }
  void schedule() {
    at(4, R"({"command":"add","virtualObject":{"kind":"aiv","id":"V1"}})");
    at(5, R"({"command":"add","virtualObject":{"kind":"aiv","id":"V2"}})");
    at(6, R"({"command":"add","virtualObject":{"kind":"aiv","id":"V3"}})");
    at(8, R"({"command":"add","virtualObject":{"id":"P1","kind":"person","x":0.0,"y":0.9,)"
          R"("path":[[0.0,0.9],[0.6,0.2],[-0.6,-0.2]],"speed":0.3,"repeat":"back and forth"}})");
    at(10, R"({"id":"c1","command":"stop","vehicle":"CoSiVA/AIV2"})");
    at(12, R"({"command":"slow","vehicle":"CoSiVA.virtual/V1"})");
    at(14, R"({"command":"limit","speed":0.25,"vehicle":"CoSiVA/AIV3"})");
    at(16, R"({"command":"close","section":"east"})");
    at(18, R"({"id":"c2","command":"restart","vehicle":"CoSiVA/AIV2"})");
    at(20, R"({"command":"plant","plant":{"addObstacle":{"id":"O1","x":0.3,"y":0.3,"radius":0.06}}})");
    at(24, R"({"command":"edit","edit":{"priorities":{"CoSiVA/AIV1":5,"CoSiVA.virtual/V2":3}}})");
    at(26, R"({"command":"edit","edit":{"moveTags":[{"number":1,"section":"east","s":1.2}]}})");
    at(28, R"({"command":"undo"})");
    at(30, R"({"command":"radio","vehicle":"CoSiVA/AIV4","loss":0.4})");
    at(32, R"({"command":"open","section":"east"})");
    at(34, R"({"command":"plant","plant":{"removeObstacle":"O1"}})");
    at(36, R"({"command":"cancel","vehicle":"CoSiVA/AIV1"})");
    at(38, R"({"command":"redo"})");
    steps_.emplace(40, [this] { world->kill_aiv(3); });
    at(42, R"({"command":"circulate","vehicle":"*"})");
    steps_.emplace(46, [this] { world->start_aiv(3); });
    at(50, R"({"command":"stop","vehicle":"*"})");
    at(53, R"({"command":"restart","vehicle":"*"})");
    at(60, switch_to(zone_named("indus8")));
    at(66, R"({"command":"fast","vehicle":"CoSiVA/AIV1"})");
    at(70, R"({"command":"go","vehicle":"CoSiVA/AIV2","to":"dock"})");
    at(74, R"({"command":"remove","id":"V3"})");
    at(78, R"({"command":"move","virtualObject":{"id":"P1","x":0.5,"y":0.5}})");
    at(82, R"({"command":"add","virtualObject":{"kind":"obstacle","id":"B1","x":1.0,"y":0.2,"radius":0.05}})");
    at(90, switch_to(zone_named("lacet4")));
    at(92, R"({"command":"add","virtualObject":{"kind":"aiv","id":"V3"}})");
    at(96, R"({"command":"nonsense","vehicle":"*"})");
    at(100, R"({"command":"remove","id":"*"})");
    at(104, R"({"command":"stop","vehicle":"CoSiVA/AIV1"})");
    at(108, R"({"command":"add","virtualObject":{"kind":"aiv","id":"V1"}})");
    at(112, R"({"command":"restart","vehicle":"CoSiVA/AIV1"})");
  }

  std::multimap<int, std::function<void()>> steps_;
};

}  // namespace cosiva::experiments::testing
