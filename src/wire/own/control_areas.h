#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

#include "cosiva/base/pose.h"
#include "cosiva/base/result.h"
#include "cosiva/base/time.h"

/// Several servers on one broker, one for each control area (docs/protocols/own-messages.md): the topics of each
/// server, and the owner of each vehicle.
namespace cosiva::wire {

/// A server's own topics are below this prefix and the control area's name.
inline constexpr std::string_view area_topic_prefix = "cosiva/v1/area/";
/// Retained, one for each vehicle: its owner (Owner). The last message that the broker retains decides.
inline constexpr std::string_view owner_topic_prefix = "cosiva/v1/owner/";

/// Letters, digits and _ . : - only, 32 at most.
[[nodiscard]] bool valid_area_name(std::string_view name);

/// The topics that one server publishes about itself.
struct ServerTopics {
  std::string zone_prefix;  ///< the last level is the format
  std::string connection;
  std::string heartbeat;
  friend bool operator==(const ServerTopics&, const ServerTopics&) = default;
};
/// @param area  empty: the only server of its broker, with the topics of topics.h
[[nodiscard]] ServerTopics server_topics(std::string_view area);

/// "cosiva/v1/area/<area>/<rest>"; nothing where the topic has another form, or the name is not a valid area name.
struct AreaTopic {
  std::string_view area;
  std::string_view rest;  ///< "zone/toml", "server/connection", "server/heartbeat"
};
[[nodiscard]] std::optional<AreaTopic> parse_area_topic(std::string_view topic);

/// The control area that owns a vehicle from now on, and what that server needs to have its twin at once. An empty
/// retained message leaves the vehicle without an owner.
struct Owner {
  std::string area;
  std::uint32_t sequence{};  ///< one more than that of the message before
  SimTime timestamp{};
  std::optional<Pose2> pose;  ///< where the vehicle is, in the frame that all control areas have in common
  struct Mission {
    std::string kind;  ///< "go" or "circulate"
    std::string name;  ///< of the station, waypoint or loop; empty: the zone's first loop
    friend bool operator==(const Mission&, const Mission&) = default;
  };
  std::optional<Mission> mission;  ///< that the new server is to give the vehicle
  friend bool operator==(const Owner&, const Owner&) = default;
};
[[nodiscard]] std::string to_json(const Owner& owner);
[[nodiscard]] Result<Owner> owner_from_json(std::string_view text);

}  // namespace cosiva::wire
