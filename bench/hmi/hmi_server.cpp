// A page to measure: the real HTTP server, live stream and frames, with the requested number of synthetic AIVs that
// circulate on lacet4 (drawn larger, so that they have space). No core runs behind the stream. hmi.mjs measures this
// server.
#include <array>
#include <chrono>
#include <cmath>
#include <csignal>
#include <cstdint>
#include <cstdio>
#include <fstream>
#include <iterator>
#include <string>
#include <vector>

#include "cosiva/adapters/clock.h"
#include "cosiva/adapters/event_loop.h"
#include "cosiva/adapters/http/http_server.h"
#include "cosiva/app/cli/options.h"
#include "cosiva/base/json_text.h"
#include "cosiva/base/json_value.h"
#include "cosiva/base/json_writer.h"
#include "cosiva/base/random.h"
#include "cosiva/base/test_paths.h"
#include "cosiva/hmi/http_responses.h"
#include "cosiva/hmi/page_calls.h"
#include "cosiva/hmi/page_stream.h"
#include "cosiva/zone/drawing/draw.h"
#include "cosiva/zone/rtm/rtm.h"

namespace {

using namespace cosiva;
using virtual_side::PositionRecord;

struct Options {
  std::string zone{source_dir() + "/zones/lacet4.toml"};
  std::string web_root{source_dir() + "/web/dist"};
  std::uint32_t vehicles{100};
  double scale{0.0};
  std::uint16_t port{0};
  double seconds{0.0};
};

/// The scale at which the vehicles have as much area as 12 AIVs on lacet4.
double natural_scale(std::uint32_t vehicles) { return std::max(1.0, std::sqrt(vehicles / 12.0)); }

/// Copies a drawing, everything on it `scale` times as large.
void write_scaled(JsonWriter& json, const JsonValue& value, double scale) {
  if (const double* number = value.number()) {
    json.value(*number * scale);
  } else if (const JsonValue::Array* array = value.array()) {
    json.begin_array();
    for (const JsonValue& element : *array) write_scaled(json, element, scale);
    json.end_array();
  } else if (const JsonValue::Object* object = value.object()) {
    json.begin_object();
    for (const auto& [name, member] : *object) {
      const bool length = name == "bounds" || name == "primitives" || name == "points" || name == "size_m" ||
                          name == "sections" || name == "length_m" || name == "s" || name == "x" || name == "y" ||
                          name == "tags" || name == "pitch_m" || name == "origin" || name == "beacons";
      write_scaled(json.key(name), member, length ? scale : 1.0);
    }
    json.end_object();
  } else {
    write_json(json, value);
  }
}

/// AIVs that circulate for ever, each at its own speed and with its own lateral offset from the path.
class Fleet {
 public:
  Fleet(const zone::TrafficZone& zone, std::uint32_t count, double scale) : circuit_{zone.circuit}, scale_{scale} {
    Random random{1, "fleet"};
    const double length_m = circuit_.total_length_m();
    for (std::uint32_t i = 0; i < count; ++i) {
      vehicles_.push_back({circuit_.advance({0, 0.0}, length_m * i / count), random.uniform(0.1, 0.5),
                           random.uniform(-0.12, 0.12), random.uniform(0.0, 6.28)});
    }
  }

  void move_to(double time_s) {
    const double dt_s = time_s - time_s_;
    time_s_ = time_s;
    for (Vehicle& vehicle : vehicles_)
      vehicle.position = circuit_.advance(vehicle.position, vehicle.speed_mps * dt_s / scale_);
  }

  [[nodiscard]] PositionRecord record(std::size_t i) const {
    const Vehicle& vehicle = vehicles_[i];
    const double left_m = scale_ * (vehicle.left_m + 0.02 * std::sin(time_s_ + vehicle.phase_rad));
    const Pose2 X_MP = circuit_.pose_at(vehicle.position);
    PositionRecord record;
    record.handle = static_cast<std::uint16_t>(i);
    record.status = static_cast<std::uint8_t>(i % 6);
    record.x_m = static_cast<float>(scale_ * X_MP.x_m - std::sin(X_MP.heading_rad) * left_m);
    record.y_m = static_cast<float>(scale_ * X_MP.y_m + std::cos(X_MP.heading_rad) * left_m);
    record.heading_rad = static_cast<float>(X_MP.heading_rad);
    record.speed_mps = static_cast<float>(vehicle.speed_mps);
    record.reported_dx_m = -0.01F;
    return record;
  }
  void positions(std::vector<PositionRecord>& out) const {
    out.clear();
    for (std::size_t i = 0; i < vehicles_.size(); ++i) out.push_back(record(i));
  }
  [[nodiscard]] std::size_t size() const { return vehicles_.size(); }
  [[nodiscard]] std::string section(std::size_t i) const { return circuit_.part(vehicles_[i].position.section).name; }
  [[nodiscard]] double s_m(std::size_t i) const { return scale_ * vehicles_[i].position.s_m; }

 private:
  struct Vehicle {
    zone::TrackPosition position;
    double speed_mps;
    double left_m;
    double phase_rad;
  };
  const zone::Circuit& circuit_;
  double scale_;
  double time_s_{0.0};
  std::vector<Vehicle> vehicles_;
};

/// All fields that the contract has for one AIV, with synthetic values.
void write_vehicle(JsonWriter& json, const Fleet& fleet, std::size_t i) {
  static constexpr std::array status{"Normal", "stopped", "slow speed", "medium speed", "fast speed", "Normal"};
  const PositionRecord at = fleet.record(i);
  const double x = double{at.x_m};
  const double y = double{at.y_m};
  json.begin_object().field("id", "CoSiVA/AIV" + std::to_string(i + 1)).field("handle", i).field("number", i + 1);
  json.field("augmented", false).field("connection", "ONLINE").field("lost", at.status == 5);
  json.field("status", status[at.status]).field("x", x).field("y", y).field("heading", double{at.heading_rad});
  json.field("speed", double{at.speed_mps}).field("section", fleet.section(i)).field("s", fleet.s_m(i));
  json.field("priority", 0).key("reported").begin_object().field("x", x).field("y", y);
  json.field("heading", double{at.heading_rad}).end_object().field("age_ms", 42.0).field("divergence_m", 0.002);
  json.field("battery", 87.0).field("lastTag", 3).field("sinceTag_m", 0.21).field("lastNode", "east@300");
  json.field("orderId", "0b1c2d3e").field("orderUpdateId", 12).field("driving", true).field("paused", false);
  json.field("fieldViolation", false).key("waitsFor").null().key("brakingFor").null();
  json.key("errors").begin_array().end_array().key("reserved").begin_array();
  for (const double ahead_m : {0.0, 0.3}) json.begin_array().value(x + ahead_m).value(y).end_array();
  json.end_array().key("contract").begin_object().field("matched", true).field("divergence", true);
  json.field("age", true).end_object().end_object();
}

std::string snapshot_json(const Fleet& fleet, SimTime now) {
  JsonWriter json;
  json.begin_object().field("time", to_iso8601(now));
  json.field("time_ms", std::chrono::duration<double, std::milli>(now.time_since_epoch()).count());
  json.field("zoneRevision", 1).key("zoneEdits").begin_object().field("undo", 0).field("redo", 0);
  json.field("unsaved", false).end_object().key("aivs").begin_array();
  for (std::size_t i = 0; i < fleet.size(); ++i) write_vehicle(json, fleet, i);
  json.end_array();
  for (const char* none : {"virtualObjects", "obstacles", "crossings"}) json.key(none).begin_array().end_array();
  virtual_side::BijectionMonitor{{}}.write(json.key("bijection"));
  json.key("commands").begin_array().end_array().end_object();
  return json.take();
}

class Fixture {
 public:
  Fixture(const Options& options, zone::Rtm rtm)
      : rtm_{std::move(rtm)},
        scale_{options.scale > 0.0 ? options.scale : natural_scale(options.vehicles)},
        fleet_{rtm_.zone(), options.vehicles, scale_} {
    JsonWriter plain;
    zone::write_json(plain, rtm_.zone(), zone::draw(rtm_.zone()));
    JsonWriter scaled;
    write_scaled(scaled, *JsonValue::parse(plain.text()), scale_);
    zone_json_ = scaled.take();
  }

  int run(const Options& options) {
    adapters::HttpOptions http_options;
    http_options.port = options.port;
    http_options.web_root = options.web_root;
    auto http = adapters::HttpServer::listen(
        loop_, std::move(http_options), [this](const adapters::HttpRequest& request) { return response(request); });
    if (!http) {
      std::fprintf(stderr, "hmi_server: %s\n", to_string(http.error()).c_str());
      return 2;
    }
    const app::PageStream stream{loop_, **http, source()};
    std::printf("{\"port\":%u,\"vehicles\":%zu,\"scale\":%.3f,\"snapshot_bytes\":%zu}\n", (*http)->port(),
                fleet_.size(), scale_, snapshot_json(fleet_, clock_.now()).size());
    std::fflush(stdout);
    loop_.on_signals({SIGINT, SIGTERM}, [this](int) { loop_.stop(); });
    adapters::Timer end{loop_};
    if (options.seconds > 0.0) end.after(from_seconds(options.seconds), [this] { loop_.stop(); });
    loop_.run();
    return 0;
  }

 private:
  app::StreamSource source() {
    app::StreamSource source;
    source.now = [this] { return clock_.now(); };
    source.zone_revision = [] { return std::uint64_t{1}; };
    source.zone_json = [this] { return zone_json_; };
    source.run_json = [this] { return run_json(); };
    source.snapshot_json = [this] { return snapshot_json(fleet_, clock_.now()); };
    source.page_revision = [] { return virtual_side::ServerCore::PageRevision{}; };
    source.positions = [this](SimTime now, std::vector<PositionRecord>& out) {
      fleet_.move_to(to_seconds(now - start_));
      fleet_.positions(out);
    };
    return source;
  }

  [[nodiscard]] std::string run_json() const {
    JsonWriter json;
    json.begin_object().field("name", "bench").key("scenario").null().field("version", "bench").key("clock");
    json.begin_object().field("kind", "wall").field("running", true).field("speed", 1.0);
    json.field("time_ms", std::chrono::duration<double, std::milli>(clock_.now().time_since_epoch()).count());
    json.end_object().end_object();
    return json.take();
  }

  adapters::HttpResponse response(const adapters::HttpRequest& request) {
    if (request.path == "/api/v1/zone") return app::json_response(zone_json_);
    if (request.path == "/api/v1/snapshot") return app::json_response(snapshot_json(fleet_, clock_.now()));
    if (request.path == "/api/v1/run") return app::json_response(run_json());
    if (request.path == "/api/v1/zones") return app::json_response(R"({"zones":[]})");
    if (request.path == "/api/v1/traces") return app::json_response(R"({"next":1,"oldest":1,"traces":[]})");
    return adapters::http_error(409, "benchmark.not_now",
                                "this is a benchmark's server: there is nothing but a drawing");
  }

  adapters::EventLoop loop_;
  adapters::WallClock clock_;
  SimTime start_{clock_.now()};
  zone::Rtm rtm_;
  double scale_;
  Fleet fleet_;
  std::string zone_json_;
};

}  // namespace

int main(int argc, char** argv) {
  Options options;
  const cosiva::app::CommandLine line{"A page to measure, with synthetic AIVs"};
  const cosiva::app::Command command = line.root();
  command.add_option("--vehicles", options.vehicles, "number of AIVs").in_range(0U, 32'768U);
  command.add_option("--scale", options.scale, "size of the zone, 1 for lacet4's own; default: enough space for all");
  command.add_option("--port", options.port, "0: any free one");
  command.add_option("--web", options.web_root, "the page's built files");
  command.add_option("--seconds", options.seconds, "end after this time; default: at a signal");
  if (const auto status = line.parse(argc, argv)) return *status;

  std::ifstream file{options.zone, std::ios::binary};
  auto rtm = zone::Rtm::initialise({"toml", options.zone, {std::istreambuf_iterator<char>{file}, {}}});
  if (!rtm) {
    std::fprintf(stderr, "hmi_server: %s\n", to_string(rtm.error()).c_str());
    return 2;
  }
  Fixture fixture{options, std::move(*rtm)};
  return fixture.run(options);
}
