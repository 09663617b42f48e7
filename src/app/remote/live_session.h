#pragma once

#include <chrono>
#include <deque>
#include <functional>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "cosiva/adapters/clock.h"
#include "cosiva/adapters/event_loop.h"
#include "cosiva/adapters/http/http_client.h"
#include "cosiva/adapters/mqtt_client.h"
#include "cosiva/app/resources/resource_paths.h"
#include "cosiva/base/result.h"
#include "cosiva/base/time.h"
#include "cosiva/wire/runtime/core.h"

namespace cosiva::app {

struct LiveSessionOptions {
  std::string client_name;  ///< for the broker's log
  std::chrono::seconds connect_max{};
  std::string connect_hint;  ///< ends the message that no broker responds
  /// A server that was killed is back within a few seconds; commands to it wait meanwhile.
  std::chrono::milliseconds command_timeout{};
  std::chrono::seconds retry_after{};  ///< between two attempts at a server that does not respond
  bool announces_failures{false};      ///< whether a response of 500 or more is reported to the operator as no response
  std::chrono::seconds stop_max{};     ///< for the broker's acknowledgements at the end
  std::string prefix;                  ///< of each line for the operator
};

/// A test's session on a running platform: its connection to the broker, its commands to the server, its timer.
/// Invariant: messages are received and the timer runs only between connect() and stop(); commands are sent in the
/// order of their arrival, each once the server has accepted those before it.
class LiveSession {
 public:
  using OnMessage = std::function<void(std::string_view topic, std::string_view payload)>;

  LiveSession(LiveSessionOptions options, adapters::HttpClient server);

  /// Connects to the broker (127.0.0.1:1883 without an address) and subscribes. Called once (checked).
  /// Errors: those of mqtt_options() and MqttClient::make(); `mqtt.connect` where no broker responds in time.
  [[nodiscard]] Result<void> connect(BrokerArguments broker, std::vector<std::string> filters, OnMessage on_message);
  /// Fails (`http.connect`) where the server does not respond.
  [[nodiscard]] Result<void> check_server();
  /// Calls `on_tick` at this period until leave(); after connect() (checked).
  void run(std::chrono::milliseconds period, std::function<void()> on_tick);
  void leave() { loop_.stop(); }
  /// Disconnects once the broker has acknowledged all messages, or after `stop_max`; after connect() (checked).
  void stop();

  /// Publishes after connect() (checked).
  void publish(const wire::Publish& message);
  /// Adds a command, as JSON, to those that wait for the server.
  void add_command(std::string command) { commands_.push_back(std::move(command)); }
  /// Sends the waiting commands in order, each until the server has accepted it; a server that is restarting is
  /// retried in a later call. Blocks for up to `command_timeout` per command.
  void send_commands();
  [[nodiscard]] bool has_commands() const { return !commands_.empty(); }

  [[nodiscard]] adapters::EventLoop& loop() { return loop_; }
  [[nodiscard]] SimTime now() { return clock_.now(); }
  [[nodiscard]] const std::string& address() const { return address_; }  ///< of the broker: "127.0.0.1:1883"

 private:
  LiveSessionOptions options_;
  adapters::EventLoop loop_;
  adapters::WallClock clock_;
  adapters::HttpClient server_;
  std::unique_ptr<adapters::MqttClient> bus_;
  std::string address_;
  std::deque<std::string> commands_;
  SimTime next_attempt_{};
  bool waiting_{false};
  bool stopped_{false};
  adapters::Timer timer_;
};

}  // namespace cosiva::app
