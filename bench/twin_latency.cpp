// The latency that the platform adds to the broker's: publish → twin updated, compared with the same broker's bare
// publish → receive.
//
// A private mosquitto on loopback; one publisher sends VDA 5050 states of about 1 kB in turn to a bare libmosquitto
// subscriber, to the server in its live shell (MQTT client, decode, proxy, twin, monitor, with its ticks running), and
// to another such server that has its store, as `cosiva server` does. All streams have the same payloads, rate and
// time, so the machine's noise affects all. Goals: the 99th percentile grows by less than 1 ms at 1 000 messages/s, and
// with the store by a tenth at most.
#include <mosquitto.h>
#include <sys/prctl.h>

#include <algorithm>
#include <atomic>
#include <charconv>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <thread>
#include <variant>
#include <vector>

#include "bench/sample_state.h"
#include "cosiva/adapters/broker.h"
#include "cosiva/adapters/clock.h"
#include "cosiva/adapters/event_loop.h"
#include "cosiva/adapters/files.h"
#include "cosiva/adapters/live_shell.h"
#include "cosiva/adapters/mqtt_client.h"
#include "cosiva/adapters/store/live_store.h"
#include "cosiva/aiv/motion/motion.h"
#include "cosiva/app/cli/options.h"
#include "cosiva/base/json_value.h"
#include "cosiva/base/test_paths.h"
#include "cosiva/virtual/server/core/server_core.h"
#include "cosiva/wire/vda5050/codec.h"

namespace {

using namespace cosiva;
using std::chrono::milliseconds;

struct Options {
  std::string zone{source_dir() + "/zones/lacet4.toml"};
  double seconds{10.0};
  std::uint32_t rate_hz{1000};
  std::uint32_t vehicles{10};
  bool json{false};
};

std::int64_t now_ns() {
  return std::chrono::duration_cast<std::chrono::nanoseconds>(std::chrono::steady_clock::now().time_since_epoch())
      .count();
}

/// The headerId of a payload, which both receivers use as the message's number; the encoder writes it near the front.
std::optional<std::size_t> number_in(std::string_view payload) {
  constexpr std::string_view key = "\"headerId\":";
  const std::size_t at = payload.find(key);
  if (at == std::string_view::npos) return std::nullopt;
  std::size_t number = 0;
  const char* first = payload.data() + at + key.size();
  const auto [end, error] = std::from_chars(first, payload.data() + payload.size(), number);
  return error == std::errc{} && end != first ? std::optional{number} : std::nullopt;
}

/// When each message was sent, and how long it took; one slot per message, so no thread waits for another.
class Latencies {
 public:
  explicit Latencies(std::size_t count) : sent_(count), taken_(count) {}
  void sent(std::size_t number) { sent_[number].store(now_ns(), std::memory_order_release); }
  void arrived(std::size_t number, std::int64_t at_ns) {
    if (number < taken_.size()) taken_[number].store(at_ns - sent_[number].load(), std::memory_order_release);
    count_.fetch_add(1, std::memory_order_release);
  }
  [[nodiscard]] std::size_t count() const { return count_.load(std::memory_order_acquire); }

  /// Sorted, in microseconds, without the first tenth (connections, caches and clocks warm up).
  [[nodiscard]] std::vector<double> sorted_us() const {
    std::vector<double> all;
    for (std::size_t i = taken_.size() / 10; i < taken_.size(); ++i) {
      const std::int64_t ns = taken_[i].load();
      if (ns > 0) all.push_back(static_cast<double>(ns) * 1e-3);
    }
    std::sort(all.begin(), all.end());
    return all;
  }

 private:
  std::vector<std::atomic<std::int64_t>> sent_;
  std::vector<std::atomic<std::int64_t>> taken_;
  std::atomic<std::size_t> count_{0};
};

constexpr const char* bare_interface = "bare";
constexpr const char* twin_interface = "twin";
constexpr const char* stored_interface = "stored";

struct Receiver {
  Receiver(const char* name, std::size_t count) : interface_name{name}, latencies{count} {}
  const char* interface_name;
  Latencies latencies;
};

double quantile(const std::vector<double>& sorted, double ratio) {
  if (sorted.empty()) return 0.0;
  return sorted[std::min(sorted.size() - 1, static_cast<std::size_t>(ratio * static_cast<double>(sorted.size())))];
}

/// A libmosquitto client with its own thread and the library's simplest loop.
class BareClient {
 public:
  BareClient(std::uint16_t port, std::string filter, std::function<void(std::string_view)> on_payload)
      : client_{mosquitto_new(nullptr, true, this)}, filter_{std::move(filter)}, on_payload_{std::move(on_payload)} {
    mosquitto_int_option(client_, MOSQ_OPT_TCP_NODELAY, 1);
    mosquitto_subscribe_callback_set(
        client_, [](mosquitto*, void* self, int, int, const int*) { static_cast<BareClient*>(self)->ready_ = true; });
    mosquitto_message_callback_set(client_, [](mosquitto*, void* self, const mosquitto_message* message) {
      static_cast<BareClient*>(self)->on_payload_(
          {static_cast<const char*>(message->payload), static_cast<std::size_t>(message->payloadlen)});
    });
    if (mosquitto_connect(client_, "127.0.0.1", port, 60) != MOSQ_ERR_SUCCESS) return;
    if (filter_.empty()) {
      // A publisher: receive CONNACK, then write from the calling thread.
      for (int i = 0; i < 3; ++i) mosquitto_loop(client_, 20, 1);
      ready_ = true;
      return;
    }
    mosquitto_subscribe(client_, nullptr, filter_.c_str(), 0);
    thread_ = std::thread{[this] {
      while (!stop_) mosquitto_loop(client_, 100, 1);
    }};
    for (int i = 0; i < 200 && !ready_; ++i) std::this_thread::sleep_for(milliseconds{10});
  }
  ~BareClient() {
    stop_ = true;
    if (thread_.joinable()) thread_.join();
    mosquitto_disconnect(client_);
    mosquitto_destroy(client_);
  }
  BareClient(const BareClient&) = delete;
  BareClient& operator=(const BareClient&) = delete;

  [[nodiscard]] bool ready() const { return ready_; }
  void publish(const std::string& topic, const std::string& payload, int qos = 0, bool retained = false) {
    mosquitto_publish(client_, nullptr, topic.c_str(), static_cast<int>(payload.size()), payload.data(), qos, retained);
  }

 private:
  mosquitto* client_;
  std::string filter_;
  std::function<void(std::string_view)> on_payload_;
  std::atomic<bool> ready_{false};
  std::atomic<bool> stop_{false};
  std::thread thread_;
};

/// The unchanged server core, with the clock read after each message that the core has handled.
class WatchedServer final : public wire::Core {
 public:
  using Handled = std::function<void(const wire::Input&)>;
  WatchedServer(const virtual_side::ServerOptions& options, Handled handled)
      : server_{options}, handled_{std::move(handled)} {}

  void handle(const wire::Input& input, wire::Effects& effects) override {
    server_.handle(input, effects);
    if (input.kind == wire::InputKind::message) handled_(input);
  }
  [[nodiscard]] SimDuration tick_period() const override { return server_.tick_period(); }
  [[nodiscard]] std::vector<std::string> subscriptions() const override { return server_.subscriptions(); }
  [[nodiscard]] std::optional<wire::Will> will() const override { return server_.will(); }
  void farewell(SimTime now, wire::Effects& effects) override { server_.farewell(now, effects); }
  void fold(Digest& digest) const override { server_.fold(digest); }
  [[nodiscard]] Result<std::string> snapshot() const override { return server_.snapshot(); }

  [[nodiscard]] const virtual_side::ServerCore& server() const { return server_; }

 private:
  virtual_side::ServerCore server_;
  Handled handled_;
};

/// The vehicles: each drives along the circuit, and reports in turn.
class Publisher {
 public:
  Publisher(const Options& options, const zone::TrafficZone& zone, std::uint16_t port)
      : options_{options}, zone_{zone}, client_{port, "", {}} {
    for (const zone::TrackPosition position : zone.start_positions(options.vehicles)) {
      motions_.emplace_back(zone.circuit, position);
      ids_.push_back({std::string(wire::our_manufacturer), "AIV" + std::to_string(ids_.size() + 1)});
    }
  }

  [[nodiscard]] bool ready() const { return client_.ready() && !ids_.empty(); }

  void announce() {
    for (const wire::VehicleId& id : ids_) {
      wire::Connection online;
      online.header = {1, clock_.now(), "2.1.0", id.manufacturer, id.serial_number};
      online.state = wire::ConnectionState::online;
      for (const char* interface_name : {twin_interface, stored_interface})
        client_.publish(wire::vda_topic(id, "connection", interface_name), wire::vda5050::encode(online), 0, true);
    }
  }

  /// Sends `count` messages to each of the receivers, one after the other within a period.
  void run(std::size_t count, const std::vector<Receiver*>& receivers) {
    prctl(PR_SET_TIMERSLACK, 1);
    const std::chrono::nanoseconds period{1'000'000'000 / options_.rate_hz / receivers.size()};
    auto due = std::chrono::steady_clock::now();
    const double step_m = 0.3 * static_cast<double>(ids_.size()) / options_.rate_hz;
    for (std::size_t number = 0; number < count; ++number) {
      const std::size_t vehicle = number % ids_.size();
      motions_[vehicle].move(zone_.circuit, step_m);
      const std::string payload = wire::vda5050::encode(state_of(vehicle, static_cast<std::uint32_t>(number)));
      bytes_ += payload.size();
      for (Receiver* to : receivers) {
        due += period;
        std::this_thread::sleep_until(due);
        to->latencies.sent(number);
        client_.publish(wire::vda_topic(ids_[vehicle], "state", to->interface_name), payload);
      }
    }
  }

  [[nodiscard]] std::size_t bytes() const { return bytes_; }

 private:
  /// The state of the vehicle at its present position, between the zone's own waypoints.
  [[nodiscard]] wire::State state_of(std::size_t vehicle, std::uint32_t number) const {
    const aiv::AivMotion& motion = motions_[vehicle];
    wire::State state =
        fixture::sample_state(ids_[vehicle], number, clock_.now(), motion.pose(zone_.circuit), zone_.name);
    state.order_id = "round-" + ids_[vehicle].serial_number;
    state.order_update_id = 1;
    std::size_t waypoint = zone_.waypoint_behind(motion.track_position(zone_.circuit));
    state.last_node_id = zone_.waypoints[waypoint].id;
    for (std::size_t i = 0; i < state.node_states.size(); ++i) {
      const std::size_t next = zone_.next_waypoint(waypoint);
      state.edge_states[i].edge_id = zone_.waypoints[waypoint].id + "-" + zone_.waypoints[next].id;
      state.node_states[i].node_id = zone_.waypoints[next].id;
      waypoint = next;
    }
    return state;
  }

  const Options& options_;
  const zone::TrafficZone& zone_;
  BareClient client_;
  adapters::WallClock clock_;
  std::vector<aiv::AivMotion> motions_;
  std::vector<wire::VehicleId> ids_;
  std::size_t bytes_{0};
};

/// Whether the twin's snapshot agrees with the message. Checked for a few messages only, since it takes time.
bool twin_reports(const virtual_side::ServerCore& core, const std::string& payload) {
  const auto state = wire::vda5050::decode_state(payload);
  const auto snapshot = JsonValue::parse(core.snapshot_json());
  if (!state || !state->position || !snapshot) return false;
  const JsonValue* aivs = snapshot->find("aivs");
  if (aivs == nullptr || aivs->array() == nullptr) return false;
  const std::string id = wire::to_string(wire::VehicleId{state->header.manufacturer, state->header.serial_number});
  for (const JsonValue& aiv : *aivs->array()) {
    const JsonValue* reported = aiv.find("reported");
    if (aiv.text("id") != id || reported == nullptr) continue;
    const double dx_m = reported->number("x").value_or(1e9) - state->position->pose.x_m;
    const double dy_m = reported->number("y").value_or(1e9) - state->position->pose.y_m;
    return std::abs(dx_m) < 2e-3 && std::abs(dy_m) < 2e-3;
  }
  return false;
}

/// A server in its live shell, on a thread of its own.
class MeasuredServer {
 public:
  /// @param vehicles  they register in the first two rounds
  MeasuredServer(const zone::ZoneConfiguration& zone, Receiver& receiver, std::uint32_t vehicles)
      : options_{options_of(zone, receiver.interface_name)},
        core_{options_, [this, &receiver, vehicles](const wire::Input& input) { handled(input, receiver, vehicles); }} {
  }
  ~MeasuredServer() {
    loop_.post([this] { loop_.stop(); });
    if (thread_.joinable()) thread_.join();
  }
  MeasuredServer(const MeasuredServer&) = delete;
  MeasuredServer& operator=(const MeasuredServer&) = delete;

  /// @param store  folder; empty: without a store
  [[nodiscard]] Result<void> start(std::uint16_t port, const std::string& store) {
    adapters::LiveOptions live;
    live.kind = live.name = "server";
    live.options = virtual_side::to_json(options_);
    live.mqtt.emplace().port = port;
    if (!store.empty()) {
      auto opened = adapters::LiveStore::open(loop_, store, {});
      if (!opened) return tl::unexpected<Error>(opened.error());
      live.store = std::move(*opened);
    }
    shell_ = std::make_unique<adapters::LiveShell>(loop_, core_, std::move(live));
    if (auto started = shell_->start(); !started) return started;
    if (!loop_.run_until([this] { return shell_->link_up(); }, milliseconds{5000}))
      return fail("twin_latency.broker", "the server found no broker");
    thread_ = std::thread{[this] { loop_.run(); }};
    return {};
  }
  [[nodiscard]] std::size_t checked() const { return checked_; }
  [[nodiscard]] std::size_t wrong() const { return wrong_; }

 private:
  static virtual_side::ServerOptions options_of(const zone::ZoneConfiguration& zone, const char* interface_name) {
    virtual_side::ServerOptions options;
    options.zone = zone;
    options.drive = false;
    options.interface_name = interface_name;
    return options;
  }
  void handled(const wire::Input& input, Receiver& receiver, std::uint32_t vehicles) {
    const std::int64_t at_ns = now_ns();
    if (!input.source.ends_with("/state")) return;
    const auto number = number_in(input.payload);
    if (!number) return;
    receiver.latencies.arrived(*number, at_ns);
    if (*number % 199 != 198 || *number < 2 * vehicles) return;
    ++checked_;
    if (!twin_reports(core_.server(), input.payload)) ++wrong_;
  }

  virtual_side::ServerOptions options_;
  adapters::EventLoop loop_;
  WatchedServer core_;
  std::unique_ptr<adapters::LiveShell> shell_;
  std::thread thread_;
  std::atomic<std::size_t> checked_{0};
  std::atomic<std::size_t> wrong_{0};
};

struct Metrics {
  std::size_t received{};
  double p50_us{};
  double p99_us{};
};
Metrics metrics(const Receiver& receiver) {
  const std::vector<double> us = receiver.latencies.sorted_us();
  return {receiver.latencies.count(), quantile(us, 0.50), quantile(us, 0.99)};
}

struct Outcome {
  std::size_t sent{};
  double bytes{};
  Metrics bare{};
  Metrics twin{};
  Metrics stored{};
  std::size_t checked{};
  std::size_t wrong{};
};

void print_json(const Options& options, const Outcome& outcome) {
  const auto one = [](const char* name, const Metrics& m) {
    std::printf("\"%s\":{\"received\":%zu,\"p50_us\":%.1f,\"p99_us\":%.1f},", name, m.received, m.p50_us, m.p99_us);
  };
  const auto ratio = [](const char* name, const Metrics& a, const Metrics& b) {
    std::printf("\"%s\":{\"p50\":%.3f,\"p99\":%.3f},", name, a.p50_us / b.p50_us, a.p99_us / b.p99_us);
  };
  std::printf("{\"rate_hz\":%u,\"vehicles\":%u,\"payload_bytes\":%.0f,\"sent\":%zu,", options.rate_hz, options.vehicles,
              outcome.bytes, outcome.sent);
  one("broker", outcome.bare);
  one("twin", outcome.twin);
  one("twin_with_store", outcome.stored);
  ratio("ratio", outcome.twin, outcome.bare);
  ratio("ratio_of_store", outcome.stored, outcome.twin);
  std::printf("\"added_us\":{\"p50\":%.1f,\"p99\":%.1f},\"twins_checked\":%zu,\"twins_wrong\":%zu}\n",
              outcome.twin.p50_us - outcome.bare.p50_us, outcome.twin.p99_us - outcome.bare.p99_us, outcome.checked,
              outcome.wrong);
}

void print_text(const Options& options, const Outcome& outcome) {
  const auto one = [](const char* name, const Metrics& m) {
    std::printf("  %-34s p50 %7.1f us  p99 %7.1f us  (%zu received)\n", name, m.p50_us, m.p99_us, m.received);
  };
  std::printf("%zu states of %.0f bytes to each, %u a second, %u vehicles\n", outcome.sent, outcome.bytes,
              options.rate_hz, options.vehicles);
  one("broker alone, publish to receive:", outcome.bare);
  one("publish to twin updated:", outcome.twin);
  one("the same of a server with store:", outcome.stored);
  std::printf("  %-34s p50 %7.2f     p99 %7.2f     (goal: 1.1 at most)\n",
              "ratio of the store:", outcome.stored.p50_us / outcome.twin.p50_us,
              outcome.stored.p99_us / outcome.twin.p99_us);
  std::printf("  %-34s p50 %7.1f us  p99 %7.1f us  (goal: p99 under 1000)\n",
              "added to the broker:", outcome.twin.p50_us - outcome.bare.p50_us,
              outcome.twin.p99_us - outcome.bare.p99_us);
  std::printf("  twins compared with what was sent: %zu, wrong: %zu\n", outcome.checked, outcome.wrong);
}

int report(const Options& options, const Outcome& outcome) {
  if (options.json)
    print_json(options, outcome);
  else
    print_text(options, outcome);
  const bool whole = outcome.bare.received == outcome.sent && outcome.twin.received == outcome.sent &&
                     outcome.stored.received == outcome.sent;
  return outcome.wrong == 0 && outcome.checked > 0 && whole ? 0 : 1;
}

int report_error(const std::string& text) {
  std::fprintf(stderr, "twin_latency: %s\n", text.c_str());
  return 3;
}

/// A folder for the broker and the store, removed at the end.
struct WorkFolder {
  WorkFolder() : path{std::filesystem::temp_directory_path() / ("cosiva-twin-latency-" + std::to_string(now_ns()))} {
    std::filesystem::create_directory(path);
  }
  ~WorkFolder() { std::filesystem::remove_all(path); }
  WorkFolder(const WorkFolder&) = delete;
  WorkFolder& operator=(const WorkFolder&) = delete;
  std::filesystem::path path;
};

int measure(const Options& options) {
  auto text = adapters::read_file(options.zone);
  if (!text) return report_error(to_string(text.error()));
  const zone::ZoneConfiguration configuration{"toml", options.zone, *std::move(text)};
  const auto rtm = zone::Rtm::initialise(configuration);
  if (!rtm) return report_error(to_string(rtm.error()));

  adapters::EventLoop loop;
  const WorkFolder folder;
  auto broker = adapters::PrivateBroker::start(loop, {folder.path.string(), (folder.path / "broker.log").string(), ""});
  if (!broker) return report_error(to_string(broker.error()));
  const std::uint16_t port = (*broker)->port();

  const auto count = static_cast<std::size_t>(options.seconds * options.rate_hz);
  Receiver bare{bare_interface, count};
  Receiver twin{twin_interface, count};
  Receiver stored{stored_interface, count};
  const BareClient subscriber{port, "bare/#", [&bare](std::string_view payload) {
                                const std::int64_t at_ns = now_ns();
                                if (const auto number = number_in(payload)) bare.latencies.arrived(*number, at_ns);
                              }};
  MeasuredServer server{configuration, twin, options.vehicles};
  MeasuredServer storing{configuration, stored, options.vehicles};
  if (const auto started = server.start(port, ""); !started) return report_error(to_string(started.error()));
  if (const auto started = storing.start(port, (folder.path / "store").string()); !started)
    return report_error(to_string(started.error()));
  Publisher publisher{options, rtm->zone(), port};
  if (!publisher.ready() || !subscriber.ready()) return report_error("a bare client found no broker");
  publisher.announce();
  loop.run_for(milliseconds{300});

  std::thread vehicles{[&] { publisher.run(count, {&bare, &twin, &stored}); }};
  const milliseconds limit{static_cast<int>(options.seconds * 1000.0) + 5000};
  const auto arrived = [count](const Receiver& receiver) { return receiver.latencies.count() >= count; };
  loop.run_until([&] { return arrived(bare) && arrived(twin) && arrived(stored); }, limit);
  vehicles.join();
  return report(options, {count, static_cast<double>(publisher.bytes()) / static_cast<double>(count), metrics(bare),
                          metrics(twin), metrics(stored), server.checked() + storing.checked(),
                          server.wrong() + storing.wrong()});
}

}  // namespace

int main(int argc, char** argv) {
  Options options;
  const cosiva::app::CommandLine line{"Measures publish to twin updated compared with the bare broker, in one run"};
  const cosiva::app::Command command = line.root();
  command.add_option("--zone", options.zone, "Zone file").show_default();
  command.add_option("--seconds", options.seconds, "Length of the run").show_default().positive();
  command.add_option("--rate", options.rate_hz, "Messages per second").show_default().in_range(1, 100'000);
  command.add_option("--vehicles", options.vehicles, "Vehicles that report").show_default().in_range(1, 100);
  command.add_flag("--json", options.json, "Print the metrics as JSON");
  if (const auto status = line.parse(argc, argv)) return *status;
  return measure(options);
}
