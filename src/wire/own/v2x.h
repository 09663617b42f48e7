#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "cosiva/base/pose.h"
#include "cosiva/base/result.h"
#include "cosiva/base/time.h"
#include "cosiva/wire/messages/topics.h"

/// V2X messages of an AIV to those near it (A3, A9, A10): its position and its intention. A message grants no right of
/// way: orders alone decide which vehicle may drive where. docs/protocols/v2x.md.
namespace cosiva::wire {

/// A crossing on the sender's route, including the path that the vehicle needs to leave it.
struct CrossingIntent {
  std::string name;      ///< in the zone, "X1"
  double entry_m{};      ///< from the sender's body origin along its path; 0 where the vehicle is inside
  double exit_m{};       ///< likewise, ≥ entry_m
  double arrival_s{};    ///< after the message was sent, at the earliest
  double departure_s{};  ///< likewise when the vehicle leaves the crossing; ≥ arrival_s
  bool may_enter{};      ///< the base leads through, or the vehicle is inside
  friend bool operator==(const CrossingIntent&, const CrossingIntent&) = default;
};

/// Vehicle → those near it, QoS 0, not retained: position, speed and intended route. As in VDA 5050: header id counted
/// per topic and sender, time stamp, map, the zone's own names.
struct Intent {
  std::uint32_t header_id{};
  SimTime timestamp{};  ///< the sender's clock; a receiver does not rely on it
  std::string map_id;
  VehicleId vehicle;
  Pose2 pose;  ///< X_MB, of the body origin
  double speed_mps{};
  bool braking{};            ///< the vehicle slows down, or stays stopped for an obstacle
  std::uint32_t priority{};  ///< 0…999, as the zone gives it
  struct OnLine {
    std::string section;
    double s_m{};
    friend bool operator==(const OnLine&, const OnLine&) = default;
  };
  std::optional<OnLine> position;         ///< nothing: the vehicle is off-path, or turns on the spot
  std::vector<CrossingIntent> crossings;  ///< in the order of the route, at most crossings_max
  std::vector<std::string> route;         ///< the sections after the present one, at most route_max
  static constexpr std::size_t crossings_max = 8;
  static constexpr std::size_t route_max = 8;
  friend bool operator==(const Intent&, const Intent&) = default;
};

[[nodiscard]] std::string to_json(const Intent& intent);
/// Fails ("own.field", naming the field; "json.syntax") on wrong types, numbers out of bounds, lists that are too long
/// and messages of more than 16 KiB. Unknown fields are ignored. The heading is brought into (−π, π].
[[nodiscard]] Result<Intent> intent_from_json(std::string_view json);

/// The plane is divided into squares of this side; each has its own topics, so that messages stay local.
inline constexpr double v2x_cell_m = 3.0;
/// A vehicle keeps its cell until it is this far outside, so that driving along a border does not change the cell all
/// the time.
inline constexpr double v2x_cell_slack_m = 0.3;
struct Cell {
  std::int32_t x{};
  std::int32_t y{};
  friend bool operator==(const Cell&, const Cell&) = default;
};
/// @param p  on the map; coordinates beyond ±100 km are clamped
[[nodiscard]] Cell cell_of(Point2 p);
/// Distance of `p` from the cell, along the axis along which it is larger; 0 within.
[[nodiscard]] double outside_cell_m(Cell cell, Point2 p);

inline constexpr std::string_view v2x_topic_prefix = "cosiva/v1/v2x/";
/// Levels below the prefix: map, cell, manufacturer, serial number.
inline constexpr int v2x_topic_levels = 4;
/// "cosiva/v1/v2x/lacet4/-1_0/CoSiVA/AIV1". In the map's name, every character other than a letter, digit, dot, dash or
/// underscore becomes an underscore, and the name is cut to 64 bytes; the message holds it in full.
[[nodiscard]] std::string v2x_topic(std::string_view map_id, Cell cell, const VehicleId& vehicle);
/// The filters of all messages sent in the cell and the eight around it.
[[nodiscard]] std::vector<std::string> v2x_filters(std::string_view map_id, Cell cell);
struct V2xTopic {
  std::string map_level;
  Cell cell;
  VehicleId vehicle;
};
/// Nothing where the text is not such a topic.
[[nodiscard]] std::optional<V2xTopic> parse_v2x_topic(std::string_view topic);

}  // namespace cosiva::wire
