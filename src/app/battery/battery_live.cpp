// Battery tests on a running platform, over its broker and its server's API.
#include "cosiva/app/battery/battery_live.h"

#include <algorithm>
#include <csignal>
#include <deque>
#include <filesystem>
#include <memory>
#include <utility>

#include "cosiva/adapters/child_process.h"
#include "cosiva/adapters/clock.h"
#include "cosiva/adapters/event_loop.h"
#include "cosiva/adapters/files.h"
#include "cosiva/adapters/http_client.h"
#include "cosiva/adapters/mqtt_client.h"
#include "cosiva/app/battery/battery_text.h"
#include "cosiva/app/cli/console.h"
#include "cosiva/app/cli/progress.h"
#include "cosiva/app/remote/zone_switch.h"
#include "cosiva/app/resources/resource_paths.h"
#include "cosiva/base/json_value.h"
#include "cosiva/experiments/battery/analysis.h"
#include "cosiva/wire/own/battery_exchange.h"

namespace cosiva::app {
namespace {

using experiments::LiveRig;
using std::chrono::milliseconds;
using std::chrono::seconds;

constexpr milliseconds tick_period{250};
/// Period of the battery test's status message, which is also sent at each change.
constexpr seconds notice_period{1};
/// A server that was killed is back within a few seconds; commands to it wait meanwhile.
constexpr milliseconds command_timeout{2000};
constexpr seconds fleet_max{60};
constexpr seconds goodbye_max{10};

class LiveTest {
 public:
  LiveTest(const BatteryTestArguments& arguments, experiments::LiveRigOptions options, adapters::HttpClient server)
      : arguments_{arguments}, rig_{std::move(options)}, server_{std::move(server)}, heartbeat_{loop_} {}

  Result<void> run() {
    if (auto there = open(); !there) return there;
    loop_.on_signals({SIGINT, SIGTERM}, [this](int) { interrupted_ = true; });
    loop_.run_until([this] { return rig_.complete() || interrupted_; }, fleet_max);
    if (interrupted_) return fail("battery.interrupted", "the test was ended before its start", {});
    if (!rig_.complete())
      return fail("battery.fleet", "no message was received for a minute from " + rig_.missing(), address_);
    if (auto begun = begin(); !begun) return begun;
    heartbeat_.every(tick_period, [this] { heartbeat(); });
    loop_.run();
    if (failure_) return tl::unexpected(*failure_);
    return publish_offline();
  }
  [[nodiscard]] const std::vector<experiments::BatteryRun>& records() const { return rig_.procedure().records(); }

 private:
  Result<void> open() {
    BrokerArguments broker = arguments_.broker;
    if (broker.address.empty()) broker.address = "127.0.0.1:1883";
    auto options = mqtt_options(broker, "cosiva-battery");
    if (!options) return tl::unexpected(options.error());
    address_ = options->host + ":" + std::to_string(options->port);
    adapters::MqttHandlers handlers;
    handlers.on_link = [](bool) {};
    handlers.on_message = [this](std::string_view topic, std::string_view payload, bool) {
      if (!ended_) response(rig_.on_message(clock_.now(), topic, payload));
    };
    auto client =
        adapters::MqttClient::make(loop_, std::move(*options), LiveRig::subscriptions(), std::nullopt, handlers);
    if (!client) return tl::unexpected(client.error());
    bus_ = std::move(*client);
    bus_->start();
    bool connected = false;
    loop_.run_until([&] { return connected = bus_->connected(); }, seconds{10});
    if (connected) return {};
    return fail("mqtt.connect", "no broker responds at this address", address_);
  }

  Result<void> begin() {
    const std::string& file = arguments_.state_file;
    if (file.empty() || !std::filesystem::exists(file)) {
      response(rig_.start(clock_.now()));
      return {};
    }
    const auto saved = adapters::read_file(file);
    if (!saved) return tl::unexpected(saved.error());
    auto responses = rig_.restore(clock_.now(), *saved);
    if (!responses) return fail(responses.error().code, responses.error().message, file);
    print_info("continues from " + file);
    response(std::move(*responses));
    return {};
  }

  void heartbeat() {
    if (std::exchange(interrupted_, false)) {
      print_info("interrupted: what runs is known to last longer");
      response(rig_.give_up(clock_.now()));
    } else {
      response(rig_.tick(clock_.now()));
    }
    notify_server();
    if (!saved_) save();
    if (clock_.now() - reported_at_ >= notice_period) notify_observers();
    if (ticker_.ticks()) print_info(progress_text(rig_.procedure(), clock_.now()));
    if ((rig_.done() || failure_) && commands_.empty()) loop_.stop();
  }

  void response(LiveRig::Responses responses) {
    for (const wire::Publish& message : responses.messages) bus_->publish(message);
    const bool news = !responses.messages.empty() || !responses.commands.empty();
    for (std::string& command : responses.commands) commands_.push_back(std::move(command));
    for (const std::string& operator_messages : responses.operator_messages) {
      print_info(operator_messages);
      notify(operator_messages);
    }
    if (news) notify_observers();
    saved_ = false;
  }

  /// Publishes the status of the test for the operator's page, retained by the broker, also after the end of the test.
  void notify_observers() {
    reported_at_ = clock_.now();
    bus_->publish({std::string(wire::battery_test_topic), to_json(rig_.test(reported_at_)), 1, true});
  }

  /// Sends the commands in order, each until the server has accepted it; a server that is restarting is retried.
  void notify_server() {
    while (!commands_.empty()) {
      const auto taken = server_.send_request("POST", "/api/v1/commands", commands_.front(), command_timeout);
      if (!taken) {
        if (!std::exchange(waiting_, true)) print_info("the server does not respond; commands to it wait");
        return;
      }
      if (std::exchange(waiting_, false)) print_info("the server responds again");
      if (taken->status >= 500) return;
      if (taken->status >= 400)
        print_info("the server refused " + commands_.front() + ": " +
                   to_string(refusal_in(taken->body, taken->status)));
      commands_.pop_front();
    }
  }

  void save() {
    saved_ = true;
    if (arguments_.state_file.empty() || ended_) return;
    if (auto kept = adapters::write_file(arguments_.state_file, rig_.state_json()); !kept && !reported_error_) {
      // The test continues: a failed save only matters after a crash.
      reported_error_ = true;
      print_info("warning: " + to_string(kept.error()));
    }
  }

  /// Runs the operator's own command with the message as its last argument; its duration is not limited.
  void notify(const std::string& operator_messages) {
    if (arguments_.notify.empty()) return;
    adapters::ChildOptions options;
    options.argv = {"/bin/sh", "-c", arguments_.notify + " \"$1\"", "notify", operator_messages};
    options.log_file = "/dev/null";
    options.on_exit = [](const adapters::ChildExit&) {};
    auto child = adapters::Child::start(loop_, std::move(options));
    if (!child) return print_info("warning: " + to_string(child.error()));
    std::erase_if(notified_, [](const auto& one) { return !one->running(); });
    notified_.push_back(std::move(*child));
  }

  Result<void> publish_offline() {
    notify_observers();
    ended_ = true;
    heartbeat_.cancel();
    bool out = false;
    bus_->stop([&] { out = true; });
    loop_.run_until([&] { return out; }, goodbye_max);
    std::error_code missing;
    if (!arguments_.state_file.empty()) std::filesystem::remove(arguments_.state_file, missing);
    return {};
  }

  const BatteryTestArguments& arguments_;
  adapters::EventLoop loop_;
  adapters::WallClock clock_;
  LiveRig rig_;
  adapters::HttpClient server_;
  std::unique_ptr<adapters::MqttClient> bus_;
  std::string address_;
  std::deque<std::string> commands_;
  std::vector<std::unique_ptr<adapters::Child>> notified_;
  SecondsTicker ticker_;
  std::optional<Error> failure_;
  SimTime reported_at_{};
  bool waiting_{false};
  bool saved_{false};
  bool reported_error_{false};
  bool interrupted_{false};
  bool ended_{false};
  adapters::Timer heartbeat_;
};

}  // namespace

Result<std::vector<experiments::BatteryRun>> run_live(const BatteryTestArguments& arguments,
                                                      experiments::LiveRigOptions options) {
  auto server = adapters::HttpClient::make(arguments.url);
  if (!server) return tl::unexpected(server.error());
  LiveTest test{arguments, std::move(options), std::move(*server)};
  if (auto done = test.run(); !done) return tl::unexpected(done.error());
  return test.records();
}

}  // namespace cosiva::app
