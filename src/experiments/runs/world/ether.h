#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "cosiva/base/expect.h"
#include "cosiva/wire/messages/topics.h"
#include "cosiva/wire/own/v2x_port.h"
#include "cosiva/wire/runtime/network.h"

namespace cosiva::experiments {

/// The direct link between the vehicles of a world, which needs no broker: seeded faults, and its own random numbers.
///
/// Invariant: each client of the network belongs to one participant.
class Ether {
 public:
  using Participant = std::size_t;

  Ether(std::uint64_t seed, const std::optional<wire::NetworkFaults>& faults)
      : enabled_{faults.has_value()}, network_{seed ^ seed_of_its_own, faults.value_or(wire::NetworkFaults{})} {}

  /// A process starts. @param loss  ratio of lost messages around the vehicle
  void join(SimTime now, Participant participant, double loss) {
    if (!enabled_) return;
    leave(now, participant);
    const auto client = network_.connect(now, filters(), std::nullopt);
    COSIVA_EXPECT(client == participants_.size());
    participants_.push_back(participant);
    set_loss(participant, loss);
  }
  /// The process has died.
  void leave(SimTime now, Participant participant) {
    if (const auto client = client_of(participant)) {
      network_.disconnect(now, *client);
      participants_[*client] = left;
    }
  }
  void set_loss(Participant participant, double loss) {
    if (const auto client = client_of(participant)) network_.set_loss(*client, loss);
  }
  void broadcast(SimTime now, Participant from, const wire::VehicleId& id, const wire::SendBytes& send) {
    if (const auto client = client_of(from))
      network_.publish(now, *client, {wire::v2x_port_of(id, send.port), send.bytes, 0, false, send.typed});
  }

  [[nodiscard]] std::optional<SimTime> next_due() const { return network_.next_due(); }
  /// Calls receive(participant, delivery) for everything due.
  template <typename Receive>
  void deliver_due(SimTime now, Receive receive) {
    if (const auto due_at = network_.next_due(); !due_at || *due_at > now) return;
    network_.deliver_due(now, [&](wire::Network::Delivery& delivery) {
      if (participants_[delivery.to] != left) receive(participants_[delivery.to], delivery);
    });
  }

 private:
  static constexpr std::uint64_t seed_of_its_own = 0x5e7e'0e7e'44d1'0a00;
  static constexpr Participant left = static_cast<Participant>(-1);
  [[nodiscard]] static std::vector<std::string> filters() {
    std::vector<std::string> all;
    all.reserve(wire::v2x_ports.size());
    for (const std::string_view port : wire::v2x_ports) all.push_back(std::string(port) + "/#");
    return all;
  }
  [[nodiscard]] std::optional<wire::Network::ClientId> client_of(Participant participant) const {
    for (std::size_t client = participants_.size(); client-- > 0;)
      if (participants_[client] == participant) return static_cast<wire::Network::ClientId>(client);
    return std::nullopt;
  }

  bool enabled_;
  wire::Network network_;
  std::vector<Participant> participants_;  ///< by client
};

}  // namespace cosiva::experiments
