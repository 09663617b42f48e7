#pragma once

#include <charconv>
#include <cstddef>
#include <cstdint>
#include <functional>
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

/// The direct link between the vehicles and crossing units of a world, which needs no broker: seeded faults, its own
/// random numbers, and a reach.
///
/// Invariant: each client of the network belongs to one participant.
class Ether {
 public:
  using Participant = std::size_t;

  /// Whether what one participant sends reaches another one now; empty: always.
  using Reaches = std::function<bool(Participant from, Participant to)>;

  Ether(std::uint64_t seed, const std::optional<wire::NetworkFaults>& faults)
      : enabled_{faults.has_value()}, network_{seed ^ seed_of_its_own, faults.value_or(wire::NetworkFaults{})} {}
  void limit(Reaches reaches) { reaches_ = std::move(reaches); }

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
    const auto client = client_of(from);
    if (!client) return;
    // The topic begins with the participant whose antenna sends; a repeated message has its first sender's name.
    const bool repeated = wire::v2x_source(send.port).has_value();
    const std::string source = repeated ? send.port : wire::v2x_port_of(id, send.port);
    network_.publish(now, *client, {std::to_string(from) + "/" + source, send.bytes, 0, false, send.typed});
  }

  [[nodiscard]] std::optional<SimTime> next_due() const { return network_.next_due(); }
  /// Calls receive(participant, delivery) for everything due.
  template <typename Receive>
  void deliver_due(SimTime now, Receive receive) {
    if (const auto due_at = network_.next_due(); !due_at || *due_at > now) return;
    network_.deliver_due(now, [&](wire::Network::Delivery& delivery) {
      const Participant to = participants_[delivery.to];
      if (to == left) return;
      Participant from = left;
      const char* const end = delivery.topic.data() + delivery.topic.size();
      const char* const slash = std::from_chars(delivery.topic.data(), end, from).ptr;
      if (reaches_ && !reaches_(from, to)) return;
      delivery.topic.erase(0, static_cast<std::size_t>(slash - delivery.topic.data()) + 1);
      receive(to, delivery);
    });
  }

 private:
  static constexpr std::uint64_t seed_of_its_own = 0x5e7e'0e7e'44d1'0a00;
  static constexpr Participant left = static_cast<Participant>(-1);
  [[nodiscard]] static std::vector<std::string> filters() {
    std::vector<std::string> all;
    all.reserve(wire::v2x_ports.size());
    for (const std::string_view port : wire::v2x_ports) all.push_back("+/" + std::string(port) + "/#");
    return all;
  }
  [[nodiscard]] std::optional<wire::Network::ClientId> client_of(Participant participant) const {
    for (std::size_t client = participants_.size(); client-- > 0;)
      if (participants_[client] == participant) return static_cast<wire::Network::ClientId>(client);
    return std::nullopt;
  }

  bool enabled_;
  wire::Network network_;
  Reaches reaches_;
  std::vector<Participant> participants_;  ///< by client
};

}  // namespace cosiva::experiments
