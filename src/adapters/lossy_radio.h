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

/// The emulated radio between one emulated vehicle and the broker (wire::plant_radio_topic). Messages are treated as by
/// wire::Network in virtual time: QoS 0 is lost with the given ratio as probability, QoS 1 comes a retry later for each
/// loss, and in order. Loopback loses nothing by itself, hence this class.
///
/// Invariant: the loss is a probability, and late messages are in the order in which they are due.
class LossyRadio {
 public:
  /// @param vehicle  "CoSiVA/AIV2", the vehicle whose commands apply, in addition to "*"
  LossyRadio(EventLoop& loop, std::string vehicle);

  /// Reads a command to the radio; false when the message is not one. A bad command changes nothing.
  bool take(std::string_view topic, std::string_view payload);
  [[nodiscard]] double loss() const { return loss_; }

  /// Calls `deliver` at once, later, or never. Each direction keeps its own order.
  void receive(int qos, std::function<void()> deliver) { pass(incoming_, qos, std::move(deliver)); }
  void send(int qos, std::function<void()> deliver) { pass(outgoing_, qos, std::move(deliver)); }
  /// Everything still in transit outwards is delivered now, and nothing is lost any more: a farewell must get through.
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

/// The QoS with which the platform sends messages that a vehicle receives on this topic (docs/architecture.md, "What
/// travels"): an MQTT client does not learn the sender's QoS.
[[nodiscard]] int qos_of_received(std::string_view topic);

}  // namespace cosiva::adapters
