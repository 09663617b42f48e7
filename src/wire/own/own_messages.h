#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "cosiva/base/result.h"
#include "cosiva/base/time.h"
#include "cosiva/wire/messages/board.h"

/// CoSiVA's own messages between server and vehicles, for what VDA 5050 has no word for (topics.h). JSON, metres,
/// radians, m/s, ISO 8601 times. Readers take unknown fields, refuse wrong types, numbers that are not finite and lists
/// that are too long ("own.field", naming the field); nothing that runs stops.
namespace cosiva::wire {

/// A body in the plane: all points within `radius_m` of a segment of `length_m` through its middle, along its heading.
/// A disc has length 0; a vehicle of 0.20 m x 0.12 m is length 0.08, radius 0.06.
struct Body {
  std::string id;    ///< "P1", "CoSiVA.virtual/V1"
  std::string kind;  ///< "person", "obstacle", "aiv"
  double x_m{};
  double y_m{};
  double heading_rad{};
  double length_m{};
  double radius_m{};
  double vx_mps{};  ///< in map axes; its own motion, so that the reader may carry it on between messages
  double vy_mps{};
  friend bool operator==(const Body&, const Body&) = default;
};

/// Server → vehicle: everything only virtual that is near its way now; replaces the one before. Sent at once when a
/// body comes, goes or leaps, every 100 ms while there is any, and five times empty after the last one went. The
/// vehicle treats the bodies as its own obstacle detection's readings (DOBS), carries moving ones on, and forgets all
/// of it after a second without news while its server beats.
struct VirtualObstacles {
  std::uint32_t header_id{};
  SimTime timestamp{};
  std::string map_id;
  std::vector<Body> bodies;  ///< at most bodies_max, nearest first
  static constexpr std::size_t bodies_max = 32;
  friend bool operator==(const VirtualObstacles&, const VirtualObstacles&) = default;
};

/// Vehicle → server: the first Ahead it heard, and then every one with which somebody came or went or after which its
/// decision changed, has been taken into account; `decided` is the time at which its motors were told. One a second is
/// answered anyway, because answers may be lost. Where it begins or ends to brake between two of them, the last is
/// named.
struct VirtualObstaclesAck {
  std::uint32_t virtual_obstacles_header_id{};
  SimTime decided{};
  bool braking{};                    ///< its speed is limited by a virtual body
  std::string body;                  ///< by which; empty: none
  std::optional<double> distance_m;  ///< along its way, from its front
  friend bool operator==(const VirtualObstaclesAck&, const VirtualObstaclesAck&) = default;
};

/// Vehicle → server: the nearest thing its DOBS sees in its corridor, ten times a second while there is one within
/// 1.0 m, and three times without one after it went. Other vehicles are seen too: telling them apart is the server's.
struct DetectedObstacleReport {
  std::uint32_t header_id{};
  SimTime timestamp{};
  std::string map_id;
  struct Obstacle {
    double x_m{};  ///< of its middle, as far as can be told from one side
    double y_m{};
    double radius_m{};    ///< from the number of beams it fills
    double distance_m{};  ///< along the way, from the vehicle's front
    friend bool operator==(const Obstacle&, const Obstacle&) = default;
  };
  std::optional<Obstacle> obstacle;
  double clear_m{};  ///< so much of its corridor is free
  friend bool operator==(const DetectedObstacleReport&, const DetectedObstacleReport&) = default;
};

/// Vehicle → server: one line per board (A18), and what DOBS sees.
struct BoardsReport {
  std::uint32_t header_id{};
  SimTime timestamp{};
  struct Line {
    Board board{};
    std::string health;  ///< "ok", "lost", "faulty"
    std::uint32_t firmware_hash{};
    std::uint32_t uptime_ms{};
    std::uint64_t frames{};         ///< good ones received from it
    std::uint32_t frames_bad{};     ///< by either side
    std::uint32_t frames_missed{};  ///< by either side
    std::uint8_t self_test{};       ///< 0: passed
    friend bool operator==(const Line&, const Line&) = default;
  };
  std::vector<Line> boards;
  std::optional<Power> power;
  std::optional<Ranges> ranges;  ///< the last
  friend bool operator==(const BoardsReport&, const BoardsReport&) = default;
};

/// The ether's condition, to emulated vehicles (plant_radio_topic).
struct Radio {
  std::string vehicle;  ///< "CoSiVA/AIV2" or "*"
  double loss{};        ///< share of messages lost, 0…1
  friend bool operator==(const Radio&, const Radio&) = default;
};

[[nodiscard]] std::string to_json(const VirtualObstacles& ahead);
[[nodiscard]] std::string to_json(const VirtualObstaclesAck& perceived);
[[nodiscard]] std::string to_json(const DetectedObstacleReport& detected);
[[nodiscard]] std::string to_json(const BoardsReport& report);
[[nodiscard]] std::string to_json(const Radio& radio);
[[nodiscard]] Result<VirtualObstacles> virtual_obstacles_from_json(std::string_view json);
[[nodiscard]] Result<VirtualObstaclesAck> virtual_obstacles_ack_from_json(std::string_view json);
[[nodiscard]] Result<DetectedObstacleReport> detected_obstacle_from_json(std::string_view json);
[[nodiscard]] Result<BoardsReport> boards_report_from_json(std::string_view json);
[[nodiscard]] Result<Radio> radio_from_json(std::string_view json);

}  // namespace cosiva::wire
