#pragma once

#include <cstdint>
#include <string>
#include <string_view>

#include "cosiva/base/archive_fwd.h"
#include "cosiva/base/result.h"
#include "cosiva/wire/messages/messages.h"
#include "cosiva/wire/messages/topics.h"
#include "cosiva/wire/own/battery_exchange.h"
#include "cosiva/wire/own/control_areas.h"
#include "cosiva/wire/own/link_check.h"
#include "cosiva/wire/own/own_messages.h"
#include "cosiva/wire/runtime/core.h"

namespace cosiva::aiv {

/// The topics of one vehicle, except those of its intents, which depend on where it is.
struct ServerProxyTopics {
  // Subscribed.
  std::string order;
  std::string instant_actions;
  std::string virtual_obstacles;
  std::string owner;
  std::string estimate_request;
  std::string battery_change;
  std::string battery_fitted;
  std::string link_check;  ///< published, too
  // Published.
  std::string connection;
  std::string state;
  std::string visualization;
  std::string factsheet;
  std::string virtual_obstacles_ack;
  std::string estimate_response;
  std::string detected_obstacle;
  std::string boards;
  std::string battery_ready;
};

/// Which message of the server has arrived, by its topic.
enum class ServerMessage : std::uint8_t {
  none,  ///< of another sender
  order,
  instant_actions,
  virtual_obstacles,
  estimate_request,
  battery_change,
  battery_fitted,
  owner,
  heartbeat,
  connection,
  zone,
};

/// The proxy of the server that the vehicle hosts (A26): every message to the server is handed to it, and every message
/// of the server is delivered by it. Topics, headers counted per topic, retained flags and quality of service are those
/// of VDA 5050 (§6.2, §6.4, §6.14, §6.15). While the broker is away nothing is sent, because a state that waits would
/// be outdated.
///
/// Invariant: a message is counted once, when it has been sent or delivered; nothing is counted while the broker is
/// away.
class ServerProxy {
 public:
  /// @param as_values  frequent messages are passed on as values (wire/in_process/typed_message.h)
  ServerProxy(wire::VehicleId id, std::string_view interface_name, bool as_values = false);

  [[nodiscard]] const ServerProxyTopics& topics() const { return topics_; }

  /// @param now  of the connect that will carry it; its header is not for ordering (trap 18)
  [[nodiscard]] wire::Will will(SimTime now) const;

  void set_online(bool online) { online_ = online; }
  [[nodiscard]] bool online() const { return online_; }
  void publish(SimTime now, wire::ConnectionState state, wire::Effects& effects);
  void publish(SimTime now, wire::State&& state, wire::Effects& effects);
  void publish(SimTime now, wire::Visualization&& visualization, wire::Effects& effects);
  void publish(SimTime now, wire::Factsheet&& factsheet, wire::Effects& effects);

  // CoSiVA's own messages (wire/own/own_messages.h), all of them with QoS 0; headers are counted here, too.
  void publish(const wire::VirtualObstaclesAck& perceived, wire::Effects& effects);
  void publish(SimTime now, wire::DetectedObstacleReport&& detected, wire::Effects& effects);
  void publish(SimTime now, wire::BoardsReport&& report, wire::Effects& effects);
  void publish(SimTime now, wire::LinkCheck&& check, wire::Effects& effects);
  void publish(const wire::BatteryReady& ready, wire::Effects& effects);  ///< with QoS 1: a test waits for it
  /// wire::EstimateResponse, encoded when it was due: it is sent again when its request is repeated.
  void publish_estimate(std::string&& json, wire::Effects& effects);

  /// Delivers a message of the server.
  /// @param server  topics of the server that the vehicle obeys
  [[nodiscard]] ServerMessage deliver(std::string_view topic, const wire::ServerTopics& server);
  [[nodiscard]] wire::ProxyCounts counts() const { return {"AIV_Server", sent_, delivered_}; }

  /// Whether the message is meant for this vehicle, in a version that it supports (2.x). Error code: validationError.
  [[nodiscard]] Result<void> accepts(const wire::Header& header) const;
  void archive(Archive& archive);  ///< the state, for a snapshot

 private:
  /// The id of the next message of each topic (§6.4).
  struct HeaderIds {
    std::uint32_t connection{0};
    std::uint32_t state{0};
    std::uint32_t visualization{0};
    std::uint32_t factsheet{0};
    std::uint32_t detected_obstacle{0};
    std::uint32_t boards{0};
    std::uint32_t link_check{0};
  };
  [[nodiscard]] wire::Header header(SimTime now, std::uint32_t header_id) const;
  [[nodiscard]] ServerMessage kind_of(std::string_view topic, const wire::ServerTopics& server) const;
  void send(wire::Publish&& message, wire::Effects& effects);

  wire::VehicleId id_;
  bool as_values_;
  ServerProxyTopics topics_;
  bool online_{false};
  HeaderIds next_;
  std::uint64_t sent_{0};
  std::uint64_t delivered_{0};
};

}  // namespace cosiva::aiv
