#include "cosiva/app/remote/live_session.h"

#include <optional>
#include <utility>

#include "cosiva/app/cli/console.h"
#include "cosiva/app/remote/zone_switch.h"
#include "cosiva/base/expect.h"

namespace cosiva::app {

LiveSession::LiveSession(LiveSessionOptions options, adapters::HttpClient server)
    : options_{std::move(options)}, server_{std::move(server)}, timer_{loop_} {}

Result<void> LiveSession::connect(BrokerArguments broker, std::vector<std::string> filters, OnMessage on_message) {
  COSIVA_EXPECT(bus_ == nullptr);
  if (broker.address.empty()) broker.address = "127.0.0.1:1883";
  auto options = mqtt_options(broker, options_.client_name);
  if (!options) return tl::unexpected(options.error());
  address_ = options->host + ":" + std::to_string(options->port);
  adapters::MqttHandlers handlers;
  handlers.on_link = [](bool) {};
  handlers.on_message = [this, take = std::move(on_message)](std::string_view topic, std::string_view payload, bool) {
    if (!stopped_) take(topic, payload);
  };
  auto client = adapters::MqttClient::make(loop_, std::move(*options), std::move(filters), std::nullopt, handlers);
  if (!client) return tl::unexpected(client.error());
  bus_ = std::move(*client);
  bus_->start();
  bool connected = false;
  loop_.run_until([&] { return connected = bus_->connected(); }, options_.connect_max);
  if (!connected) return fail("mqtt.connect", "no broker responds at this address" + options_.connect_hint, address_);
  return {};
}

Result<void> LiveSession::check_server() {
  if (server_.send_request("GET", "/api/v1/snapshot", {}, options_.command_timeout)) return {};
  return fail("http.connect",
              "no server responds at this address: is the platform running (cosiva up), is --url its own?",
              server_.url());
}

void LiveSession::run(std::chrono::milliseconds period, std::function<void()> on_tick) {
  COSIVA_EXPECT(bus_ != nullptr && !stopped_);
  timer_.every(period, std::move(on_tick));
  loop_.run();
}

void LiveSession::stop() {
  COSIVA_EXPECT(bus_ != nullptr && !stopped_);
  timer_.cancel();
  stopped_ = true;
  bool out = false;
  bus_->stop([&] { out = true; });
  loop_.run_until([&] { return out; }, options_.stop_max);
}

void LiveSession::publish(const wire::Publish& message) {
  COSIVA_EXPECT(bus_ != nullptr);
  bus_->publish(message);
}

void LiveSession::send_commands() {
  if (clock_.now() < next_attempt_) return;
  while (!commands_.empty()) {
    const auto taken = server_.send_request("POST", "/api/v1/commands", commands_.front(), options_.command_timeout);
    const bool failed = taken && taken->status >= 500;
    if (!taken || (failed && options_.announces_failures)) {
      if (!std::exchange(waiting_, true))
        print_info(options_.prefix + "the server does not respond; commands to it wait");
      if (options_.retry_after > std::chrono::seconds{0}) next_attempt_ = clock_.now() + options_.retry_after;
      return;
    }
    if (std::exchange(waiting_, false)) print_info(options_.prefix + "the server responds again");
    if (failed) return;
    if (taken->status >= 400)
      print_info(options_.prefix + "the server refused " + commands_.front() + ": " +
                 to_string(refusal_in(taken->body, taken->status)));
    commands_.pop_front();
  }
}

}  // namespace cosiva::app
