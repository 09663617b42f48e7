#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

#include "cosiva/base/pose.h"
#include "cosiva/base/result.h"
#include "cosiva/base/time.h"

/// Several servers on one broker, one for each control area (docs/protocols/own-messages.md): where each speaks, and
/// whose each vehicle is.
namespace cosiva::wire {

/// What is a server's own stands below it and the control area's name.
inline constexpr std::string_view area_topic_prefix = "cosiva/v1/area/";
/// Retained, one for each vehicle: whose it is (Owner). The last that the broker keeps decides.
inline constexpr std::string_view owner_topic_prefix = "cosiva/v1/owner/";

/// Letters, digits and _ . : - only, 32 at most.
[[nodiscard]] bool valid_area_name(std::string_view name);

/// Where one server speaks about itself.
struct ServerTopics {
  std::string zone_prefix;  ///< the last level is the format
  std::string connection;
  std::string heartbeat;
  friend bool operator==(const ServerTopics&, const ServerTopics&) = default;
};
/// @param control area  empty: the only server of its broker, in topics.h's places
[[nodiscard]] ServerTopics server_topics(std::string_view area);

/// "cosiva/v1/control area/<control area>/<rest>"; nothing where it is not that, or the name is none of a control area.
struct AreaTopic {
  std::string_view area;
  std::string_view rest;  ///< "zone/toml", "server/connection", "server/heartbeat"
};
[[nodiscard]] std::optional<AreaTopic> parse_area_topic(std::string_view topic);

/// Whose a vehicle is from now on, and what that server needs to have its twin at once. An empty retained message makes
/// it nobody's.
struct Owner {
  std::string area;
  std::uint32_t sequence{};  ///< one more than that of the message before
  SimTime timestamp{};
  std::optional<Pose2> pose;  ///< where it stands, in the frame that all control areas share
  struct Mission {
    std::string kind;  ///< "go" or "circulate"
    std::string name;  ///< of the station, waypoint or loop; empty: the zone's first loop
    friend bool operator==(const Mission&, const Mission&) = default;
  };
  std::optional<Mission> mission;  ///< that the new server is to give it
  friend bool operator==(const Owner&, const Owner&) = default;
};
[[nodiscard]] std::string to_json(const Owner& owner);
[[nodiscard]] Result<Owner> owner_from_json(std::string_view text);

}  // namespace cosiva::wire
