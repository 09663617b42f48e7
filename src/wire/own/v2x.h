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

/// What AIVs tell those near them, directly (A3, A9, A10): where each is and what it is about to do. It is talk, never
/// a right: who may go where is said by orders alone. docs/protocols/v2x.md.
namespace cosiva::wire {

/// A crossing on the sender's way. What a vehicle has to leave it again counts as part of it.
struct CrossingIntent {
  std::string name;      ///< in the zone, "X1"
  double entry_m{};      ///< from the sender's middle along its way; 0 where it is inside
  double exit_m{};       ///< likewise, ≥ entry_m
  double arrival_s{};    ///< after the message was sent, at the earliest
  double departure_s{};  ///< likewise when it leaves it again; ≥ arrival_s
  bool may_enter{};      ///< its base leads through, or it is inside
  friend bool operator==(const CrossingIntent&, const CrossingIntent&) = default;
};

/// Vehicle → those near it, QoS 0, not retained: position, speed and what comes next. In VDA 5050's spirit: header id
/// counted per topic and sender, time stamp, map, the zone's own names.
struct Intent {
  std::uint32_t header_id{};
  SimTime timestamp{};  ///< the sender's clock; a receiver does not rely on it
  std::string map_id;
  VehicleId vehicle;
  Pose2 pose;  ///< X_MB, of its middle
  double speed_mps{};
  bool braking{};            ///< it slows down, or keeps standing for something
  std::uint32_t priority{};  ///< 0…999, as the zone gives it
  struct OnLine {
    std::string section;
    double s_m{};
    friend bool operator==(const OnLine&, const OnLine&) = default;
  };
  std::optional<OnLine> position;         ///< nothing: it stands beside the line, or turns on the spot
  std::vector<CrossingIntent> crossings;  ///< in the order of its way, at most crossings_max
  std::vector<std::string> route;         ///< the sections after the one it is on, at most route_max
  static constexpr std::size_t crossings_max = 8;
  static constexpr std::size_t route_max = 8;
  friend bool operator==(const Intent&, const Intent&) = default;
};

[[nodiscard]] std::string to_json(const Intent& intent);
/// Fails ("own.field", naming the field; "json.syntax") on wrong types, numbers out of bounds, lists that are too long
/// and messages of more than 16 KiB. Unknown fields are left alone. A heading comes out in (−π, π].
[[nodiscard]] Result<Intent> intent_from_json(std::string_view json);

/// The plane is cut into squares of this side; each has its topics, so that talk stays near.
inline constexpr double v2x_cell_m = 3.0;
/// A vehicle keeps its cell until it is so far outside of it, lest one that drives along a border changes all the time.
inline constexpr double v2x_cell_slack_m = 0.3;
struct Cell {
  std::int32_t x{};
  std::int32_t y{};
  friend bool operator==(const Cell&, const Cell&) = default;
};
/// @param p  on the map; coordinates beyond ±100 km count as there
[[nodiscard]] Cell cell_of(Point2 p);
/// How far `p` is outside of the cell, along the axis along which it is further; 0 within.
[[nodiscard]] double outside_cell_m(Cell cell, Point2 p);

inline constexpr std::string_view v2x_topic_prefix = "cosiva/v1/v2x/";
/// Levels below the prefix: map, cell, manufacturer, serial number.
inline constexpr int v2x_topic_levels = 4;
/// "cosiva/v1/v2x/lacet4/-1_0/CoSiVA/AIV1". Of the map's name, whatever is no letter, digit, dot, dash or underscore
/// becomes an underscore, and 64 bytes are kept; the message names it in full.
[[nodiscard]] std::string v2x_topic(std::string_view map_id, Cell cell, const VehicleId& vehicle);
/// The filters of all that is said in the cell and the eight around it.
[[nodiscard]] std::vector<std::string> v2x_filters(std::string_view map_id, Cell cell);
struct V2xTopic {
  std::string map_level;
  Cell cell;
  VehicleId vehicle;
};
/// Nothing where the text is no such topic.
[[nodiscard]] std::optional<V2xTopic> parse_v2x_topic(std::string_view topic);

}  // namespace cosiva::wire
