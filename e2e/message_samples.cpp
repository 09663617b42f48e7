// Messages that a plain run in virtual time does not contain: qualification of algorithms, move by move too, battery
// test, a server that restarts, a server among several, camera over the zone.
//
//   message_samples ZONE.toml OUT.jsonl
//
// Each part is one short run of the whole platform in virtual time with its counterpart on the bus. Writes every
// message on the topics of that part as `cosiva up --trace-messages` does; the same bytes every time. Exit 1 when a
// part fails, 2 on bad usage. golden.test.mjs compares one message of each topic with its golden.

#include <chrono>
#include <cstdio>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "cosiva/app/gvs/actual_positions.h"
#include "cosiva/app/gvs/camera_pipeline.h"
#include "cosiva/app/gvs/gvs_scene.h"
#include "cosiva/app/platform/trace_writer.h"
#include "cosiva/battery/type.h"
#include "cosiva/experiments/battery/live_rig.h"
#include "cosiva/experiments/positioning/metrology/live_runs.h"
#include "cosiva/experiments/positioning/moves/predict_then_move.h"
#include "cosiva/experiments/runs/world/world.h"
#include "cosiva/wire/messages/topics.h"
#include "cosiva/wire/own/actual_position.h"
#include "cosiva/wire/own/control_areas.h"
#include "cosiva/wire/own/gvs.h"
#include "cosiva/wire/own/link_check.h"
#include "cosiva/wire/runtime/network.h"
#include "cosiva/zone/rtm/rtm.h"
#include "e2e/soak.h"

namespace {

using namespace cosiva;
using namespace std::chrono_literals;
using experiments::World;

constexpr SimDuration step = 10ms;

std::vector<wire::VehicleId> vehicles(int count) {
  std::vector<wire::VehicleId> ids;
  for (int number = 1; number <= count; ++number)
    ids.push_back({std::string(wire::our_manufacturer), "AIV" + std::to_string(number)});
  return ids;
}

/// One run of the platform, of which the messages below some topics are written to the output.
class Run {
 public:
  using Listener = std::function<void(SimTime, const wire::Publish&)>;

  Run(app::TraceWriter& trace, experiments::WorldOptions options, std::vector<std::string_view> wanted)
      : trace_{trace}, wanted_{std::move(wanted)} {
    auto made = World::make(std::move(options));
    if (!made) {
      std::fprintf(stderr, "message_samples: %s\n", to_string(made.error()).c_str());
      return;
    }
    world_ = std::move(*made);
    world_->tap([this](SimTime at, const std::string& from, const wire::Publish& message) {
      write(at, from, message);
      if (listener) listener(at, message);
    });
  }
  [[nodiscard]] bool made() const { return world_ != nullptr; }
  [[nodiscard]] World& world() { return *world_; }

  /// A message of the part's counterpart, which the tap does not receive.
  void publish(std::string_view from, const wire::Publish& message) {
    write(world_->now(), from, message);
    world_->faults().publish_from_outside(message);
  }
  template <typename Reaction>
  void obey(std::string_view from, const Reaction& reaction) {
    for (const wire::Publish& message : reaction.messages) publish(from, message);
    for (const std::string& command : reaction.commands) world_->command_server(command);
  }

  /// Prints warnings and errors of the cores: the reason why a part fails.
  void print_log() const {
    for (const std::string& line : world_->log()) std::fprintf(stderr, "  %s\n", line.c_str());
  }

  Listener listener;

 private:
  void write(SimTime at, std::string_view from, const wire::Publish& message) {
    for (const std::string_view prefix : wanted_)
      if (message.topic.starts_with(prefix))
        return trace_.write(at, from, message.topic, message.payload, message.retained);
  }

  app::TraceWriter& trace_;
  std::vector<std::string_view> wanted_;
  std::unique_ptr<World> world_;
};

experiments::WorldOptions world_of(const zone::ZoneConfiguration& zone, std::uint32_t aivs) {
  experiments::WorldOptions options;
  options.zone = zone;
  options.aivs = aivs;
  return options;
}

bool any_matches(const std::vector<std::string>& filters, std::string_view topic) {
  for (const std::string& filter : filters)
    if (wire::topic_matches(filter, topic)) return true;
  return false;
}

/// One vehicle sends its next estimated positions over three metres.
bool qualification(app::TraceWriter& trace, const zone::ZoneConfiguration& zone) {
  experiments::LiveRunsOptions options;
  options.vehicles = vehicles(1);
  options.distance_m = 3.0;
  options.algorithms = {"arc_kalman", "dead_reckoning"};
  options.name = "golden";
  experiments::LiveRuns runs{options};
  Run run{trace, world_of(zone, 1), {wire::estimate_request_topic_prefix, wire::estimate_response_topic_prefix}};
  const auto rtm = zone::Rtm::initialise(zone);
  if (!run.made() || !rtm) return false;
  runs.on_zone(rtm->shared_zone());
  const auto filters = runs.subscriptions();
  run.listener = [&](SimTime at, const wire::Publish& message) {
    if (any_matches(filters, message.topic)) runs.on_message(at, message.topic, message.payload);
  };
  run.world().run_for(3s);
  const SimTime end = run.world().now() + 60s;
  while (!runs.done() && run.world().now() < end) {
    run.obey("qualification", runs.tick(run.world().now()));
    run.world().run_for(step);
  }
  return runs.done() && runs.losses().empty();
}

/// One vehicle makes three moves, each between its estimate and the actual position from the plant.
bool moves(app::TraceWriter& trace, const zone::ZoneConfiguration& zone) {
  experiments::PredictThenMoveOptions options;
  options.vehicles = vehicles(1);
  options.distance_m = 0.3;
  options.algorithms = {"arc_kalman"};
  options.name = "moves";
  experiments::PredictThenMove test{options};
  Run run{trace,
          world_of(zone, 1),
          {wire::plant_position_request_topic_prefix, wire::plant_position_response_topic_prefix}};
  const auto rtm = zone::Rtm::initialise(zone);
  if (!run.made() || !rtm) return false;
  test.on_zone(rtm->shared_zone());
  const auto filters = test.subscriptions();
  std::vector<wire::Publish> received;
  run.listener = [&](SimTime, const wire::Publish& message) {
    if (any_matches(filters, message.topic)) received.push_back(message);
  };
  run.world().run_for(3s);
  const SimTime end = run.world().now() + 30s;
  while (!test.done() && run.world().now() < end) {
    run.obey("qualification", test.tick(run.world().now()));
    run.world().run_for(step);
    for (const wire::Publish& message : std::exchange(received, {}))
      test.on_message(run.world().now(), message.topic, message.payload);
  }
  return test.done() && test.losses().empty();
}

/// Two vehicles get emulated batteries and run for a few seconds.
bool battery_test(app::TraceWriter& trace, const zone::ZoneConfiguration& zone) {
  const auto type = battery::shipped_type("leaf33");
  if (!type) return false;
  experiments::LiveRigOptions options;
  options.procedure.vehicles = 2;
  options.vehicles = vehicles(2);
  options.batteries = {"red", "blue"};
  options.emulated.emplace();
  options.emulated->type = *type;
  options.emulated->design.series = 2;
  experiments::LiveRig rig{options};
  Run run{trace,
          world_of(zone, 2),
          {wire::battery_change_topic_prefix, wire::battery_fitted_topic_prefix, wire::battery_ready_topic_prefix,
           wire::battery_test_topic}};
  if (!run.made()) return false;
  const auto filters = experiments::LiveRig::subscriptions();
  std::vector<wire::Publish> received;  // handled after the step: a tap does not act on the world that it observes
  run.listener = [&](SimTime, const wire::Publish& message) {
    if (any_matches(filters, message.topic)) received.push_back(message);
  };
  bool started = false;
  const SimTime end = run.world().now() + 20s;
  while (run.world().now() < end) {
    run.world().run_for(step);
    const SimTime now = run.world().now();
    for (const wire::Publish& message : std::exchange(received, {}))
      run.obey("battery test", rig.on_message(now, message.topic, message.payload));
    if (!started && rig.complete()) {
      started = true;
      run.obey("battery test", rig.start(now));
      const wire::BatteryReady fitted{"blue", "leaf33", 12.0, 3600.0, 23.5, 100.0};
      run.publish("operator",
                  {wire::own_topic(wire::battery_fitted_topic_prefix, vehicles(2)[1]), to_json(fitted), 1, false});
    }
    if (started) run.obey("battery test", rig.tick(now));
  }
  if (!started) return false;
  run.publish("battery test", {std::string(wire::battery_test_topic), to_json(rig.test(end)), 1, true});
  const bool running = rig.procedure().running(0) && rig.procedure().running(1);
  if (!running) run.print_log();
  return running;
}

/// The server and a vehicle are killed and started again: both publish their retained messages anew. While there is no
/// heartbeat, the vehicles check their link to the broker.
void come_and_go(Run& run) {
  run.world().run_for(3s);
  run.world().kill_server();
  run.world().kill_aiv(1);
  run.world().run_for(1s);
  run.world().start_aiv(1);
  run.world().start_server();
  run.world().run_for(6s);
}

bool connections(app::TraceWriter& trace, const zone::ZoneConfiguration& zone) {
  const std::string vehicle = wire::vda_topic(vehicles(1)[0], "connection");
  experiments::WorldOptions options = world_of(zone, 2);
  options.v2x = options.server.v2x = false;  // a vehicle's own V2X messages, received back, prove the link too
  Run run{trace, std::move(options), {wire::server_connection_topic, vehicle, wire::link_check_topic_prefix}};
  if (!run.made()) return false;
  come_and_go(run);
  return true;
}

/// The unit of one crossing receives the messages of four vehicles by the broker; it is switched off and on.
bool crossing_unit(app::TraceWriter& trace, const zone::ZoneConfiguration& zone) {
  experiments::WorldOptions options = world_of(zone, 4);
  options.units.push_back({"X1"});
  Run run{trace, std::move(options), {wire::unit_topic_prefix, wire::plant_unit_topic}};
  if (!run.made()) return false;
  run.world().run_for(10s);
  for (const char* on : {"false", "true"}) {
    run.world().command_server(R"({"command":"plant","plant":{"setUnit":{"crossing":"X1","on":)" + std::string{on} +
                               "}}}");
    run.world().run_for(2s);
  }
  return true;
}

/// The server is one of several, and claims the vehicles on its floor.
bool several_servers(app::TraceWriter& trace, const zone::ZoneConfiguration& zone) {
  experiments::WorldOptions options = world_of(zone, 2);
  options.server.area = "north";
  options.server.zone = zone;
  Run run{trace, std::move(options), {wire::area_topic_prefix, wire::owner_topic_prefix}};
  if (!run.made()) return false;
  come_and_go(run);
  return true;
}

/// The emulated camera observes two vehicles, four times a second.
bool camera(app::TraceWriter& trace, const zone::ZoneConfiguration& zone) {
  const auto rtm = zone::Rtm::initialise(zone);
  if (!rtm) return false;
  auto emulated = app::EmulatedCamera::over(rtm->zone());
  if (!emulated) return false;
  app::GvsSource source;
  source.tag_side_m = emulated->tag_side_m();
  source.exposure_ms = 1e3 * emulated->exposure_s();
  app::GvsCamera tracker{emulated->calibration(), app::tracker_options(source), {}};
  Run run{trace, world_of(zone, 2), {"cosiva/v1/gvs/"}};
  if (!run.made()) return false;
  std::optional<app::GroundTruth> now;
  std::optional<app::GroundTruth> before;
  run.listener = [&](SimTime, const wire::Publish& message) {
    if (message.topic != wire::ground_truth_topic) return;
    before = std::exchange(now, app::read_plant_ground_truth(message.payload));
  };
  const wire::GvsConnection online{wire::ConnectionState::online, run.world().now(), "the emulated world's camera", {}};
  run.publish("gvs", {std::string(wire::gvs_connection_topic), to_json(online), 1, true});
  run.publish("page", {std::string(wire::gvs_preview_request_topic), "{}", 0, false});
  bool found = false;
  app::ActualPositions positions;
  const wire::VehicleId vehicle = vehicles(1)[0];
  const std::string request = to_json(wire::ActualPositionRequest{"golden/1", 1});
  run.publish("qualification", {wire::own_topic(wire::gvs_position_request_topic_prefix, vehicle), request, 0, false});
  positions.on_request(run.world().now(), vehicle, request);
  for (int i = 0; i < 3; ++i) {
    run.world().run_for(250ms);
    if (!now) return false;
    const auto image = emulated->take(*now, before);
    const auto poses = tracker.see(image, now->at, 0.25);
    if (!poses) return false;
    found = found || poses->detections.size() == 2;
    run.publish("gvs", {std::string(wire::gvs_detections_topic), to_json(*poses), 0, false});
    for (const wire::Publish& response : positions.on_detections(*poses)) run.publish("gvs", response);
    run.publish("gvs",
                {std::string(wire::gvs_preview_topic), tracker.shown(image, *poses, rtm->zone().vehicle), 0, false});
  }
  return found;
}

}  // namespace

int main(int argc, char** argv) {
  if (argc != 3) {
    std::fprintf(stderr, "usage: message_samples ZONE.toml OUT.jsonl\n");
    return 2;
  }
  const auto zone = soak::toml_zone(argv[1]);
  auto trace = app::TraceWriter::create(argv[2]);
  if (!trace) {
    std::fprintf(stderr, "message_samples: %s\n", to_string(trace.error()).c_str());
    return 2;
  }
  constexpr std::pair<const char*, bool (*)(app::TraceWriter&, const zone::ZoneConfiguration&)> parts[] = {
      {"qualification", qualification},
      {"moves", moves},
      {"battery test", battery_test},
      {"connections", connections},
      {"crossing unit", crossing_unit},
      {"several servers", several_servers},
      {"camera", camera}};
  int status = 0;
  for (const auto& [name, part] : parts) {
    if (part(**trace, zone)) continue;
    std::fprintf(stderr, "message_samples: the part '%s' failed\n", name);
    status = 1;
  }
  return status;
}
