// Battery tests on a running platform, over its broker and its server's API.
#include "cosiva/app/battery/battery_live.h"

#include <algorithm>
#include <csignal>
#include <filesystem>
#include <memory>
#include <utility>

#include "cosiva/adapters/child_process.h"
#include "cosiva/adapters/files.h"
#include "cosiva/adapters/http/http_client.h"
#include "cosiva/app/battery/battery_text.h"
#include "cosiva/app/cli/console.h"
#include "cosiva/app/cli/progress.h"
#include "cosiva/app/remote/live_session.h"
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
constexpr seconds fleet_max{60};

LiveSessionOptions session_options() {
  LiveSessionOptions options;
  options.client_name = "cosiva-battery";
  options.connect_max = seconds{10};
  options.command_timeout = milliseconds{2000};
  options.stop_max = seconds{10};
  return options;
}

class LiveTest {
 public:
  LiveTest(const BatteryTestArguments& arguments, experiments::LiveRigOptions options, adapters::HttpClient server)
      : arguments_{arguments}, rig_{std::move(options)}, session_{session_options(), std::move(server)} {}

  Result<void> run() {
    if (auto there = session_.connect(arguments_.broker, LiveRig::subscriptions(),
                                      [this](std::string_view topic, std::string_view payload) {
                                        response(rig_.on_message(session_.now(), topic, payload));
                                      });
        !there)
      return there;
    session_.loop().on_signals({SIGINT, SIGTERM}, [this](int) { interrupted_ = true; });
    session_.loop().run_until([this] { return rig_.complete() || interrupted_; }, fleet_max);
    if (interrupted_) return fail("battery.interrupted", "the test was ended before its start", {});
    if (!rig_.complete())
      return fail("battery.fleet", "no message was received for a minute from " + rig_.missing(), session_.address());
    if (auto begun = begin(); !begun) return begun;
    session_.run(tick_period, [this] { heartbeat(); });
    end();
    return {};
  }
  [[nodiscard]] const std::vector<experiments::BatteryRun>& records() const { return rig_.procedure().records(); }

 private:
  Result<void> begin() {
    const std::string& file = arguments_.state_file;
    if (file.empty() || !std::filesystem::exists(file)) {
      response(rig_.start(session_.now()));
      return {};
    }
    const auto saved = adapters::read_file(file);
    if (!saved) return tl::unexpected(saved.error());
    auto responses = rig_.restore(session_.now(), *saved);
    if (!responses) return fail(responses.error().code, responses.error().message, file);
    print_info("continues from " + file);
    response(std::move(*responses));
    return {};
  }

  void heartbeat() {
    if (std::exchange(interrupted_, false)) {
      print_info("interrupted: what runs is known to last longer");
      response(rig_.give_up(session_.now()));
    } else {
      response(rig_.tick(session_.now()));
    }
    session_.send_commands();
    if (!saved_) save();
    if (session_.now() - reported_at_ >= notice_period) notify_observers();
    if (ticker_.ticks()) print_info(progress_text(rig_.procedure(), session_.now()));
    if (rig_.done() && !session_.has_commands()) session_.leave();
  }

  void response(LiveRig::Responses responses) {
    for (const wire::Publish& message : responses.messages) session_.publish(message);
    const bool news = !responses.messages.empty() || !responses.commands.empty();
    for (std::string& command : responses.commands) session_.add_command(std::move(command));
    for (const std::string& operator_messages : responses.operator_messages) {
      print_info(operator_messages);
      notify(operator_messages);
    }
    if (news) notify_observers();
    saved_ = false;
  }

  /// Publishes the status of the test for the operator's page, retained by the broker, also after the end of the test.
  void notify_observers() {
    reported_at_ = session_.now();
    session_.publish({std::string(wire::battery_test_topic), to_json(rig_.test(reported_at_)), 1, true});
  }

  void save() {
    saved_ = true;
    if (arguments_.state_file.empty()) return;
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
    auto child = adapters::Child::start(session_.loop(), std::move(options));
    if (!child) return print_info("warning: " + to_string(child.error()));
    std::erase_if(notified_, [](const auto& one) { return !one->running(); });
    notified_.push_back(std::move(*child));
  }

  void end() {
    notify_observers();
    session_.stop();
    std::error_code missing;
    if (!arguments_.state_file.empty()) std::filesystem::remove(arguments_.state_file, missing);
  }

  const BatteryTestArguments& arguments_;
  LiveRig rig_;
  LiveSession session_;
  std::vector<std::unique_ptr<adapters::Child>> notified_;
  SecondsTicker ticker_;
  SimTime reported_at_{};
  bool saved_{false};
  bool reported_error_{false};
  bool interrupted_{false};
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
