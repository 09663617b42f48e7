#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "cosiva/base/result.h"
#include "cosiva/base/time.h"
#include "cosiva/wire/messages/board.h"

/// CoSiVA's own messages between server and vehicles, for what VDA 5050 does not define (topics.h). JSON, metres,
/// radians, m/s, ISO 8601 times. Readers accept unknown fields and refuse wrong types, numbers that are not finite and
/// lists that are too long ("own.field", naming the field); a refused message stops nothing.
namespace cosiva {
class JsonWriter;
}

namespace cosiva::wire {

/// A body in the plane: all points within `radius_m` of a segment of `length_m` through its centre, along its heading.
/// A disc has length 0; a vehicle of 0.20 m x 0.12 m is length 0.08, radius 0.06.
struct Body {
  std::string id;    ///< "P1", "CoSiVA.virtual/V1"
  std::string kind;  ///< "person", "obstacle", "aiv"
  double x_m{};
  double y_m{};
  double heading_rad{};
  double length_m{};
  double radius_m{};
  double vx_mps{};  ///< in map axes; its own motion, so that the reader can extrapolate it between messages
  double vy_mps{};
  friend bool operator==(const Body&, const Body&) = default;
};

/// Server → vehicle: all virtual objects near its route now; replaces the message before. Sent at once when a body
/// appears, disappears or jumps, every 100 ms while there is any, and five times empty after the last one has
/// disappeared. The vehicle treats the bodies as readings of its own obstacle sensor (DOBS), extrapolates moving ones,
/// and discards all of them after a second without a message while its server's heartbeat goes on.
struct VirtualObstacles {
  std::uint32_t header_id{};
  SimTime timestamp{};
  std::string map_id;
  std::vector<Body> bodies;  ///< at most bodies_max, nearest first
  static constexpr std::size_t bodies_max = 32;
  friend bool operator==(const VirtualObstacles&, const VirtualObstacles&) = default;
};

/// Vehicle → server: a VirtualObstacles message has been taken into account. Sent for the first one received, and then
/// for every one with which a body appeared or disappeared or after which the vehicle's decision changed; `decided` is
/// the time of the command to its motors. One message a second is acknowledged in any case, because acknowledgements
/// may be lost. Where the vehicle begins or ends to brake between two messages, the later acknowledgement names the
/// last one received.
struct VirtualObstaclesAck {
  std::uint32_t virtual_obstacles_header_id{};
  SimTime decided{};
  bool braking{};                    ///< the speed is limited by a virtual body
  std::string body;                  ///< the limiting body; empty: none
  std::optional<double> distance_m;  ///< along the path, from the vehicle's front
  friend bool operator==(const VirtualObstaclesAck&, const VirtualObstaclesAck&) = default;
};

/// Vehicle → server: the nearest obstacle that its DOBS detects in its corridor, ten times a second while there is one
/// within 1.0 m, and three times without one after it has disappeared. DOBS detects other vehicles too; the server
/// distinguishes them.
struct DetectedObstacleReport {
  std::uint32_t header_id{};
  SimTime timestamp{};
  std::string map_id;
  struct Obstacle {
    double x_m{};  ///< of its centre, as far as it can be determined from one side
    double y_m{};
    double radius_m{};    ///< from the number of beams that the obstacle fills
    double distance_m{};  ///< along the path, from the vehicle's front
    friend bool operator==(const Obstacle&, const Obstacle&) = default;
  };
  std::optional<Obstacle> obstacle;
  double clear_m{};  ///< the free length of the corridor
  friend bool operator==(const DetectedObstacleReport&, const DetectedObstacleReport&) = default;
};

/// Messages that have passed through the proxy of a remote agent on board of a vehicle (A26).
struct ProxyCounts {
  std::string agent;          ///< AIV_Server, or "manufacturer/serial" of another AIV
  std::uint64_t sent{};       ///< to the agent
  std::uint64_t delivered{};  ///< of the agent
  friend bool operator==(const ProxyCounts&, const ProxyCounts&) = default;
};

/// Vehicle → server: one line per board (A18), and the ranges of DOBS.
struct BoardsReport {
  /// Proxies in a report: of the server, and of the other AIVs.
  static constexpr std::size_t proxies_max = 33;
  std::uint32_t header_id{};
  SimTime timestamp{};
  struct Line {
    Board board{};
    std::string health;  ///< "ok", "lost", "faulty"; "absent": the vehicle is equipped without this board
    std::uint32_t firmware_hash{};
    std::uint32_t uptime_ms{};
    std::uint64_t frames{};            ///< good ones received from it
    std::uint32_t frames_bad{};        ///< by either side
    std::uint32_t frames_missed{};     ///< by either side
    std::uint8_t self_test{};          ///< 0: passed
    std::vector<PartFinding> parts{};  ///< of the last self-test that was requested; none: no result
    friend bool operator==(const Line&, const Line&) = default;
  };
  std::vector<Line> boards;
  std::optional<Power> power;
  std::optional<Ranges> ranges;     ///< the last
  std::optional<PilsParts> pils{};  ///< what PILS' parts measure
  std::string affi{};               ///< the text on the display; empty: none yet
  std::vector<ProxyCounts> proxies{};
  friend bool operator==(const BoardsReport&, const BoardsReport&) = default;
};

/// The radio's condition, to emulated vehicles (plant_radio_topic).
struct Radio {
  std::string vehicle;  ///< "CoSiVA/AIV2" or "*"
  double loss{};        ///< ratio of messages lost, 0…1
  friend bool operator==(const Radio&, const Radio&) = default;
};

[[nodiscard]] std::string to_json(const VirtualObstacles& ahead);
[[nodiscard]] std::string to_json(const VirtualObstaclesAck& perceived);
[[nodiscard]] std::string to_json(const DetectedObstacleReport& detected);
[[nodiscard]] std::string to_json(const BoardsReport& report);
/// What the parts of PILS measure, as an object, in SI units.
void write_pils(JsonWriter& json, const PilsParts& parts);
[[nodiscard]] std::string to_json(const Radio& radio);
[[nodiscard]] Result<VirtualObstacles> virtual_obstacles_from_json(std::string_view json);
[[nodiscard]] Result<VirtualObstaclesAck> virtual_obstacles_ack_from_json(std::string_view json);
[[nodiscard]] Result<DetectedObstacleReport> detected_obstacle_from_json(std::string_view json);
[[nodiscard]] Result<BoardsReport> boards_report_from_json(std::string_view json);
[[nodiscard]] Result<Radio> radio_from_json(std::string_view json);

}  // namespace cosiva::wire
