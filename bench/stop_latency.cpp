// How long a Stop takes from the page's request to its publication and to the vehicle, while the store is stalled.
//
// A private mosquitto on loopback; the server core in its live shell with page, store and sender of Stops as in `cosiva
// server`; vehicles on a thread and a connection of their own that report at 10 Hz. The disk of the store blocks from
// before the first click to after the last. Each click is an HTTP request over one connection, and the next one follows
// its response. Goals: p99 of 5 ms to the publication, of 20 ms to the vehicle; all vehicles published within 50 ms.
#include <netinet/in.h>
#include <sys/socket.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <chrono>
#include <cstdint>
#include <cstdio>
#include <filesystem>
#include <functional>
#include <memory>
#include <mutex>
#include <optional>
#include <set>
#include <string>
#include <string_view>
#include <thread>
#include <unordered_map>
#include <utility>
#include <vector>

#include "cosiva/adapters/broker.h"
#include "cosiva/adapters/clock.h"
#include "cosiva/adapters/files.h"
#include "cosiva/adapters/live_shell.h"
#include "cosiva/adapters/loop_thread.h"
#include "cosiva/adapters/mqtt_client.h"
#include "cosiva/adapters/stop/stop_sender.h"
#include "cosiva/adapters/store/group_commit.h"
#include "cosiva/app/cli/options.h"
#include "cosiva/app/resources/file_zone_library.h"
#include "cosiva/base/json_value.h"
#include "cosiva/base/test_paths.h"
#include "cosiva/hmi/server_page.h"
#include "cosiva/journal/store/simulated_disk.h"
#include "cosiva/virtual/server/core/server_core.h"
#include "cosiva/wire/vda5050/encode.h"

namespace {

using namespace cosiva;
using std::chrono::milliseconds;

struct Options {
  std::string zone{source_dir() + "/zones/lacet4.toml"};
  std::uint32_t vehicles{100};
  std::uint32_t clicks{300};
  double pause_ms{30.0};
  bool disk_works{false};
  bool json{false};
};

std::int64_t now_ns() {
  return std::chrono::duration_cast<std::chrono::nanoseconds>(std::chrono::steady_clock::now().time_since_epoch())
      .count();
}

/// When the messages of each Stop were published and received, by the Stop's id; the first one of each vehicle counts.
class Recorder {
 public:
  struct Times {
    std::set<std::string, std::less<>> published_topics;
    std::set<std::string, std::less<>> received_topics;
    std::int64_t last_published_ns{0};
    std::int64_t last_received_ns{0};
  };

  void published(std::string_view topic, std::string_view payload) {
    record(topic, payload, &Times::published_topics, &Times::last_published_ns);
  }
  void received(std::string_view topic, std::string_view payload) {
    record(topic, payload, &Times::received_topics, &Times::last_received_ns);
  }
  [[nodiscard]] Times of(const std::string& id) {
    const std::lock_guard lock{mutex_};
    return times_[id];
  }

 private:
  void record(std::string_view topic, std::string_view payload, std::set<std::string, std::less<>> Times::*topics,
              std::int64_t Times::*last) {
    const std::int64_t at_ns = now_ns();
    constexpr std::string_view key = "\"actionId\":\"";
    const std::size_t begin = payload.find(key);
    if (begin == std::string_view::npos) return;
    const std::string_view rest = payload.substr(begin + key.size());
    const std::lock_guard lock{mutex_};
    Times& times = times_[std::string(rest.substr(0, rest.find('"')))];
    if ((times.*topics).insert(std::string(topic)).second) times.*last = at_ns;
  }

  std::mutex mutex_;
  std::unordered_map<std::string, Times> times_;
};

/// The vehicles, on a thread and a connection of their own: each reports ten times a second, and is paused once it was
/// stopped.
class Vehicles {
 public:
  Vehicles(const Options& options, const zone::TrafficZone& zone, const adapters::MqttOptions& mqtt, Recorder& recorder)
      : zone_{zone}, start_{zone.start_positions(1).front()}, timer_{thread_.loop()} {
    for (std::uint32_t i = 1; i <= options.vehicles; ++i)
      ids_.push_back({std::string(wire::our_manufacturer), "AIV" + std::to_string(i)});
    adapters::MqttHandlers handlers;
    handlers.on_link = [this](bool up) {
      connected_ = up;
      if (up) announce();
    };
    handlers.on_message = [this, &recorder](std::string_view topic, std::string_view payload, bool) {
      recorder.received(topic, payload);
      paused_.insert(std::string(topic));
    };
    client_ = adapters::MqttClient::make(thread_.loop(), mqtt, {"uagv/v2/+/+/instantActions"}, std::nullopt,
                                         std::move(handlers))
                  .value();
    thread_.start();
    thread_.loop().post([this] {
      client_->start();
      timer_.every(std::chrono::nanoseconds{100'000'000 / static_cast<std::int64_t>(ids_.size())},
                   [this] { report(); });
    });
  }
  ~Vehicles() { thread_.stop(); }
  Vehicles(const Vehicles&) = delete;
  Vehicles& operator=(const Vehicles&) = delete;

  [[nodiscard]] bool connected() const { return connected_; }
  [[nodiscard]] std::string name(std::size_t i) const { return to_string(ids_[i % ids_.size()]); }

 private:
  void announce() {
    for (const wire::VehicleId& id : ids_) {
      wire::Connection online;
      online.header = {1, clock_.now(), "2.1.0", id.manufacturer, id.serial_number};
      online.state = wire::ConnectionState::online;
      (void)client_->publish({wire::vda_topic(id, "connection"), wire::vda5050::encode(online), 0, true});
    }
  }
  void report() {
    const wire::VehicleId& id = ids_[next_ % ids_.size()];
    wire::State state;
    state.header = {static_cast<std::uint32_t>(next_++), clock_.now(), "2.1.0", id.manufacturer, id.serial_number};
    state.position = wire::AgvPosition{zone_.circuit.pose_at(start_), zone_.name, true, 1.0, 0.0};
    state.velocity = wire::Velocity{};
    state.battery = {87.0, 12.1, std::nullopt, false};
    state.paused = paused_.contains(wire::vda_topic(id, "instantActions"));
    (void)client_->publish({wire::vda_topic(id, "state"), wire::vda5050::encode(state), 0, false});
  }

  const zone::TrafficZone& zone_;
  zone::TrackPosition start_;
  adapters::WallClock clock_;
  std::vector<wire::VehicleId> ids_;
  std::set<std::string> paused_;
  std::size_t next_{0};
  std::atomic<bool> connected_{false};
  adapters::LoopThread thread_;
  adapters::Timer timer_;
  std::unique_ptr<adapters::MqttClient> client_;
};

/// A disk that blocks while `stalled` is set.
class StallingDisk {
 public:
  [[nodiscard]] std::unique_ptr<journal::Disk> open() {
    auto disk = std::make_unique<journal::SimulatedDisk>(1);
    disk->set_faults([this](journal::SimulatedDisk::Call, const std::string&) {
      while (stalled) std::this_thread::sleep_for(milliseconds{1});
      return std::string{};
    });
    return disk;
  }
  std::atomic<bool> stalled{false};
};

class Store final : public adapters::InputStore {
 public:
  Store(adapters::EventLoop& loop, std::unique_ptr<journal::Disk> disk)
      : commit_{loop, std::move(disk), journal::SegmentStart{1, 1, {}}, {}} {}
  void append(const wire::Input& input) override { input_.add(input); }
  void complete() override {
    if (!input_.empty()) commit_.append(std::exchange(input_, {}));
  }
  void complete_now(std::function<void()> durable) override {
    commit_.append_now(std::exchange(input_, {}), std::move(durable));
  }
  void propose(wire::Input proposal, Decided decided) override {
    commit_.propose(std::move(proposal), std::move(decided));
  }
  void drain() override { commit_.drain(); }
  [[nodiscard]] Left take_left() override { return {}; }
  void set_complete_state(CompleteState) override {}

 private:
  journal::Batch input_;
  adapters::GroupCommit commit_;
};

/// The page's end of one HTTP connection.
class Browser {
 public:
  explicit Browser(std::uint16_t port) : fd_{::socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC, 0)} {
    sockaddr_in address{};
    address.sin_family = AF_INET;
    address.sin_port = htons(port);
    address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
    // NOLINTNEXTLINE(cppcoreguidelines-pro-type-reinterpret-cast)
    open_ = ::connect(fd_, reinterpret_cast<const sockaddr*>(&address), sizeof address) == 0;
  }
  ~Browser() { ::close(fd_); }
  Browser(const Browser&) = delete;
  Browser& operator=(const Browser&) = delete;

  /// The body of the response; empty where none comes.
  std::string send(const std::string& first_line, const std::string& body) {
    const std::string request = first_line + " HTTP/1.1\r\nHost: localhost\r\nContent-Type: application/json\r\n" +
                                "Content-Length: " + std::to_string(body.size()) + "\r\n\r\n" + body;
    if (!open_ || ::send(fd_, request.data(), request.size(), MSG_NOSIGNAL) < 0) return {};
    std::string response;
    for (;;) {
      std::array<char, 4096> buffer;
      const ssize_t got = ::recv(fd_, buffer.data(), buffer.size(), 0);
      if (got <= 0) return {};
      response.append(buffer.data(), static_cast<std::size_t>(got));
      const std::size_t head = response.find("\r\n\r\n");
      const std::size_t length = response.find("Content-Length: ");
      if (head == std::string::npos || length == std::string::npos) continue;
      const std::size_t bytes = std::stoul(response.substr(length + 16));
      if (response.size() >= head + 4 + bytes) return response.substr(head + 4);
    }
  }

 private:
  int fd_;
  bool open_{false};
};

struct Delays {
  std::vector<double> publish_ms;
  std::vector<double> vehicle_ms;
  std::vector<double> response_ms;
  std::size_t lost{0};
  std::size_t durable_at_once{0};
};

double quantile(std::vector<double> values, double ratio) {
  if (values.empty()) return 0.0;
  std::ranges::sort(values);
  return values[std::min(values.size() - 1, static_cast<std::size_t>(ratio * static_cast<double>(values.size())))];
}

/// One click on Stop; its delays are added.
void click(Browser& browser, Recorder& recorder, const std::string& vehicle, std::size_t receivers, Delays& delays) {
  const std::int64_t sent_ns = now_ns();
  const std::string response =
      browser.send("POST /api/v1/commands", R"({"command":"stop","vehicle":")" + vehicle + "\"}");
  const std::int64_t responded_ns = now_ns();
  const auto json = JsonValue::parse(response);
  const std::string id = json ? json->text("id").value_or("") : "";
  if (json && json->flag("durable") == true) ++delays.durable_at_once;
  Recorder::Times times;
  // The vehicle may have a message before the sender's thread has recorded that it was published.
  const auto complete = [&] {
    return times.received_topics.size() >= receivers && times.published_topics.size() >= receivers;
  };
  for (int i = 0; i < 3000 && !complete(); ++i) {
    std::this_thread::sleep_for(milliseconds{1});
    times = recorder.of(id);
  }
  if (id.empty() || !complete()) {
    ++delays.lost;
    return;
  }
  const auto ms = [sent_ns](std::int64_t at_ns) { return static_cast<double>(at_ns - sent_ns) * 1e-6; };
  delays.publish_ms.push_back(ms(times.last_published_ns));
  delays.vehicle_ms.push_back(ms(times.last_received_ns));
  delays.response_ms.push_back(ms(responded_ns));
}

void print(const char* what, const std::vector<double>& ms, const char* goal) {
  std::printf("  %-34s p50 %7.2f ms  p99 %7.2f ms  max %7.2f ms  %s\n", what, quantile(ms, 0.5), quantile(ms, 0.99),
              quantile(ms, 1.0), goal);
}

void print_json(const char* name, const std::vector<double>& ms) {
  std::printf("\"%s\":{\"p50\":%.3f,\"p99\":%.3f,\"max\":%.3f}", name, quantile(ms, 0.5), quantile(ms, 0.99),
              quantile(ms, 1.0));
}

int report(const Options& options, const Delays& one, const Delays& all, double stalled_s, bool durable_in_the_end) {
  const bool stalled = !options.disk_works;
  if (options.json) {
    std::printf("{\"vehicles\":%u,\"clicks\":%zu,\"stalled_s\":%.1f,\"lost\":%zu,\"one_ms\":{", options.vehicles,
                one.publish_ms.size(), stalled ? stalled_s : 0.0, one.lost + all.lost);
    print_json("publish", one.publish_ms);
    std::printf(",");
    print_json("vehicle", one.vehicle_ms);
    std::printf("},\"all_ms\":{");
    print_json("publish", all.publish_ms);
    std::printf(",");
    print_json("vehicle", all.vehicle_ms);
    std::printf("}}\n");
  } else {
    std::printf("%zu Stops of one of %u vehicles, %zu of all; disk stalled for %.1f s; lost: %zu\n",
                one.publish_ms.size(), options.vehicles, all.publish_ms.size(), stalled ? stalled_s : 0.0,
                one.lost + all.lost);
    print("one: request to publication", one.publish_ms, "(goal: p99 5)");
    print("one: request to vehicle", one.vehicle_ms, "(goal: p99 20)");
    print("one: request to response", one.response_ms, "");
    print("all: request to last publication", all.publish_ms, "(goal: 50)");
    print("all: request to last vehicle", all.vehicle_ms, "");
  }
  const bool honest = !stalled || one.durable_at_once + all.durable_at_once == 0;
  return one.lost + all.lost == 0 && honest && durable_in_the_end ? 0 : 1;
}

int report_error(const std::string& text) {
  std::fprintf(stderr, "stop_latency: %s\n", text.c_str());
  return 3;
}

/// The server, its page and its sender of Stops, as in `cosiva server`.
struct Server {
  Server(const Options& options, const zone::ZoneConfiguration& zone, const adapters::MqttOptions& mqtt,
         StallingDisk& disk, Recorder& recorder)
      : core{core_options(zone)}, timer{thread.loop()} {
    adapters::StopHandlers handlers;
    handlers.on_published = [&recorder](const wire::Publish& message) {
      recorder.published(message.topic, message.payload);
    };
    stops = adapters::StopSender::open(mqtt, std::move(handlers)).value();
    adapters::LiveOptions live;
    live.kind = "server";
    live.options = virtual_side::to_json(core_options(zone));
    live.name = "server";
    live.mqtt = mqtt;
    live.store = std::make_shared<Store>(thread.loop(), disk.open());
    shell.emplace(thread.loop(), core, std::move(live));
    page = app::ServerPage::open(thread.loop(), host(), 0, {}, true).value();
    shell->after_input([this] { page->changed(); });
    vehicles = options.vehicles;
  }
  ~Server() { thread.stop(); }

  static virtual_side::ServerOptions core_options(const zone::ZoneConfiguration& zone) {
    virtual_side::ServerOptions options;
    options.zone = zone;
    options.drive = false;
    return options;
  }
  app::PageHost host() {
    app::PageHost made;
    made.core = &core;
    made.command = [this](const std::string& source, std::string json,
                          std::shared_ptr<const virtual_side::DecodedCommand> decoded, app::PageHost::Decided decided) {
      shell->command(source, std::move(json), std::move(decoded), std::move(decided));
    };
    made.stop = [this](const std::string& source, std::string json,
                       std::shared_ptr<const virtual_side::DecodedCommand> decoded, std::function<void()> durable) {
      shell->urgent_command(source, std::move(json), std::move(decoded), std::move(durable));
    };
    made.stop_line.send = [this](const std::string& id, const auto& names) { return stops->send(id, names); };
    made.stop_line.lift = [this](const auto& names) { stops->lift(names); };
    made.stop_line.unconfirmed = [this](const std::string& id) { return stops->unconfirmed(id); };
    made.now = [] { return adapters::WallClock{}.now(); };
    made.zones = std::make_shared<const app::FileZoneLibrary>();
    return made;
  }
  Result<void> start() {
    if (auto started = shell->start(); !started) return started;
    timer.every(milliseconds{100}, [this] {
      auto targets = core.stop_targets();
      known = static_cast<std::uint32_t>(targets.size());
      stops->know(std::move(targets));
    });
    thread.start();
    return {};
  }

  adapters::LoopThread thread;
  virtual_side::ServerCore core;
  std::unique_ptr<adapters::StopSender> stops;
  std::optional<adapters::LiveShell> shell;
  adapters::Timer timer;
  std::unique_ptr<app::ServerPage> page;
  std::uint32_t vehicles{0};
  std::atomic<std::uint32_t> known{0};
};

bool wait_for(const std::function<bool()>& done, milliseconds limit) {
  const auto deadline = std::chrono::steady_clock::now() + limit;
  while (!done()) {
    if (std::chrono::steady_clock::now() > deadline) return false;
    std::this_thread::sleep_for(milliseconds{5});
  }
  return true;
}

int measure(const Options& options) {
  auto text = adapters::read_file(options.zone);
  if (!text) return report_error(to_string(text.error()));
  const zone::ZoneConfiguration configuration{"toml", options.zone, *std::move(text)};
  const auto rtm = zone::Rtm::initialise(configuration);
  if (!rtm) return report_error(to_string(rtm.error()));

  adapters::EventLoop loop;  // of the broker
  const auto directory = std::filesystem::temp_directory_path() / ("cosiva-stop-latency-" + std::to_string(now_ns()));
  std::filesystem::create_directory(directory);
  struct Remove {
    std::filesystem::path what;
    ~Remove() { std::filesystem::remove_all(what); }
  } const remove{directory};
  auto broker = adapters::PrivateBroker::start(loop, {directory.string(), (directory / "broker.log").string(), ""});
  if (!broker) return report_error(to_string(broker.error()));
  adapters::MqttOptions mqtt;
  mqtt.port = (*broker)->port();

  Recorder recorder;
  StallingDisk disk;
  Server server{options, configuration, mqtt, disk, recorder};
  if (auto started = server.start(); !started) return report_error(to_string(started.error()));
  Vehicles vehicles{options, rtm->zone(), mqtt, recorder};
  if (!wait_for([&] { return server.known == options.vehicles && server.stops->connected(); }, milliseconds{20'000}))
    return report_error("the vehicles did not register");

  Browser browser{server.page->port()};
  Delays one;
  Delays all;
  disk.stalled = !options.disk_works;
  const std::int64_t stalled_at_ns = now_ns();
  for (std::uint32_t i = 0; i < options.clicks; ++i) {
    if (i % 10 == 9)
      click(browser, recorder, "*", options.vehicles, all);
    else
      click(browser, recorder, vehicles.name(i), 1, one);
    std::this_thread::sleep_for(std::chrono::duration<double, std::milli>{options.pause_ms});
  }
  const double stalled_s = static_cast<double>(now_ns() - stalled_at_ns) * 1e-9;
  disk.stalled = false;

  // Once the disk works, the record of the last Stop becomes durable.
  const auto last = JsonValue::parse(browser.send("POST /api/v1/commands", R"({"command":"stop","vehicle":"*"})"));
  const std::string id = last ? last->text("id").value_or("") : "";
  const bool durable = wait_for(
      [&] {
        const auto progress = JsonValue::parse(browser.send("GET /api/v1/commands/" + id, ""));
        return progress && progress->flag("durable") == true;
      },
      milliseconds{10'000});
  return report(options, one, all, stalled_s, durable);
}

}  // namespace

int main(int argc, char** argv) {
  Options options;
  const app::CommandLine line{"Measures how long a Stop takes from the page's request to the vehicle"};
  const app::Command command = line.root();
  command.add_option("--zone", options.zone, "Zone file").show_default();
  command.add_option("--vehicles", options.vehicles, "Vehicles that report").show_default().in_range(1, 256);
  command.add_option("--clicks", options.clicks, "Stops, one in ten of all vehicles")
      .show_default()
      .in_range(1, 100'000);
  command.add_option("--pause", options.pause_ms, "Milliseconds between two clicks").show_default().positive();
  command.add_flag("--disk-works", options.disk_works, "The disk of the store is not stalled");
  command.add_flag("--json", options.json, "Print the metrics as JSON");
  if (const auto status = line.parse(argc, argv)) return *status;
  return measure(options);
}
