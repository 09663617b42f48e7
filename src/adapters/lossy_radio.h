#pragma once

#include <chrono>
#include <deque>
#include <functional>
#include <memory>
#include <string>
#include <string_view>

#include "cosiva/adapters/event_loop.h"
#include "cosiva/base/random.h"

namespace cosiva::adapters {

/// The emulated ether between one emulated vehicle and the broker (wire::plant_radio_topic). It treats messages as
/// wire::Network does in virtual time: QoS 0 is lost with the share's probability, QoS 1 comes a retry later for each
/// loss, and in order. Loopback loses nothing by itself, so somebody has to.
class LossyRadio {
 public:
  /// @param vehicle  "CoSiVA/AIV2", whom it obeys for besides "*"
  LossyRadio(EventLoop& loop, std::string vehicle);

  /// Takes in what is said about the ether; false when the message is no such thing. A bad one changes nothing.
  bool take(std::string_view topic, std::string_view payload);
  [[nodiscard]] double loss() const { return loss_; }

  /// Calls `deliver` at once, later, or never. Each direction keeps its own order.
  void receive(int qos, std::function<void()> deliver) { pass(incoming_, qos, std::move(deliver)); }
  void send(int qos, std::function<void()> deliver) { pass(outgoing_, qos, std::move(deliver)); }
  /// Everything still on its way out is delivered now, and nothing is lost any more: a goodbye must get through.
  void end();

  static constexpr std::chrono::milliseconds retry{200};
  static constexpr int tries_max = 100;

 private:
  using Clock = std::chrono::steady_clock;
  struct Late {
    Clock::time_point due;
    std::function<void()> deliver;
  };
  struct Lane {
    explicit Lane(EventLoop& loop) : timer{loop} {}
    std::deque<Late> late;
    Timer timer;
  };
  void pass(Lane& lane, int qos, std::function<void()> deliver);
  void deliver_due(Lane& lane);

  std::string vehicle_;
  Random random_;
  double loss_{0.0};
  Lane incoming_;
  Lane outgoing_;
};

/// With what QoS the platform sends what a vehicle hears on this topic (docs/architecture.md, "What travels"): an MQTT
/// client is not told how a message came.
[[nodiscard]] int qos_of_received(std::string_view topic);

}  // namespace cosiva::adapters
