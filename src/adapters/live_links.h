#pragma once

#include <functional>
#include <memory>
#include <optional>
#include <string>

#include "cosiva/adapters/event_loop.h"
#include "cosiva/adapters/lossy_radio.h"
#include "cosiva/adapters/mqtt_client.h"
#include "cosiva/adapters/ports.h"
#include "cosiva/base/result.h"
#include "cosiva/wire/runtime/core.h"

namespace cosiva::adapters {

/// What arrives over the links, and a line for the log.
struct LinkHandlers {
  std::function<void(bool up)> on_broker;
  std::function<void(std::string topic, std::string payload, bool retained)> on_message;
  PortHandlers ports;
  std::function<void(char level, const std::string& text)> on_log;
};

/// The links of one core to the outside: to the broker, through the emulated radio where the core drives an emulated
/// vehicle, and to the boards. A core may have none of them: then effects for them are dropped.
///
/// Invariant: there is a radio only where there is a connection to the broker, and both are made once.
class LiveLinks {
 public:
  LiveLinks(EventLoop& loop, LinkHandlers handlers) : loop_{loop}, handlers_{std::move(handlers)} {}

  /// Prepares the connection to the broker, with the core's subscriptions and will. Fails as MqttClient::make().
  /// @param obeys_radio  LiveOptions::obeys_radio
  [[nodiscard]] Result<void> prepare(const MqttOptions& options, const wire::Core& core,
                                     const std::string& obeys_radio);
  /// Opens the byte streams. Fails as `open_ports` does.
  [[nodiscard]] Result<void> open(const OpenPorts& open_ports);
  /// Begins to connect to the broker.
  void start();

  void act(const wire::Publish& publish);
  void act(const wire::SendBytes& send);
  void act(const wire::Listen& listen);

  [[nodiscard]] bool up() const { return mqtt_ && mqtt_->connected(); }
  /// Nothing more is lost by the radio: a farewell must get through.
  void end_radio();
  /// Disconnects, then calls `done` from the loop.
  void stop(std::function<void()> done);

 private:
  void receive(std::string topic, std::string payload, bool retained);

  EventLoop& loop_;
  LinkHandlers handlers_;
  std::optional<LossyRadio> radio_;
  // Last, so that they are destroyed first: their handlers use the above.
  std::unique_ptr<Ports> ports_;
  std::unique_ptr<MqttClient> mqtt_;
};

}  // namespace cosiva::adapters
