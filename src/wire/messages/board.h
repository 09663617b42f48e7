#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <variant>
#include <vector>

/// Messages between the on-board program (TSVA) and its boards, as plain values (A14 to A17). The frames belong to
/// module_link/; the agent never handles one.
namespace cosiva::wire {

enum class Board : std::uint8_t { PILS = 1, PRAV = 2, DOBS = 3, RALI = 4 };
inline constexpr std::array all_boards{Board::PILS, Board::PRAV, Board::DOBS, Board::RALI};
[[nodiscard]] std::string_view to_string(Board board);

/// First frame of a board after power-up or on request: the board's identity (A18).
struct Hello {
  Board board;
  std::uint8_t protocol_version{1};
  std::uint32_t firmware_hash{};
  std::uint32_t session{};  ///< random per power-up: odometers count from zero again when it changes
  friend bool operator==(const Hello&, const Hello&) = default;
};

/// Sent at 10 Hz in both directions; a side that misses it for 500 ms considers the other one lost.
struct Heartbeat {
  std::uint32_t uptime_ms{};
  std::uint16_t frames_bad{};     ///< received with a wrong CRC, length or type since power-up
  std::uint16_t frames_missed{};  ///< gaps in the sequence numbers received
  std::uint8_t self_test{};       ///< 0: passed; else the board's own code
  friend bool operator==(const Heartbeat&, const Heartbeat&) = default;
};

/// PILS has left the line: it turns on the spot where the line bends sharply, or searches for another line
/// (Drive::seek). The fields are the body's present pose in the body frame at the start of the manoeuvre, from the
/// wheels: x forward, y left. The goal (Drive::goal) is given in the same frame.
struct Manoeuvre {
  std::int16_t x_mm{};
  std::int16_t y_mm{};
  std::int16_t turned_mrad{};  ///< left positive
  friend bool operator==(const Manoeuvre&, const Manoeuvre&) = default;
};

/// PILS → TSVA, 50 Hz. Distance counts along the line since power-up, forwards positive; not during a manoeuvre.
struct Odometry {
  std::uint32_t board_ms{};
  std::int64_t distance_um{};
  std::int16_t speed_mmps{};
  std::int16_t line_offset_01mm{};  ///< of the line from the sensor's centre, left positive, in 0.1 mm
  bool line_lost{};
  std::optional<Manoeuvre> manoeuvre{};
  friend bool operator==(const Odometry&, const Odometry&) = default;
};
/// No branch is commanded: PILS stops where the line forks or bends sharply.
inline constexpr std::uint8_t no_branch = 0xFF;
/// TSVA → PILS: follow the line at this speed. The board stops by itself 300 ms after the last valid frame.
struct Drive {
  std::int16_t speed_mmps{};  ///< negative drives backwards
  std::uint16_t acceleration_mmps2{};
  std::uint16_t braking_mmps2{};
  std::uint8_t branch{};  ///< at the next fork or sharp bend take the n-th branch, 0 = default; no_branch: stop there
  /// Off the line: drive to the nearest line within reach, turn into it, and follow it. At speed 0 the vehicle waits.
  bool seek{};
  /// Not to the nearest line, but to the one at this pose in the frame of the stopped body. Read when a seek begins.
  std::optional<Manoeuvre> goal{};
  /// The vehicle stops within this distance, counted from where it receives this message, even if no other follows;
  /// nothing: no limit.
  std::optional<std::uint16_t> room_mm{};
  friend bool operator==(const Drive&, const Drive&) = default;
};

/// PRAV → TSVA, each time a tag enters the antenna's field.
struct TagRead {
  std::uint32_t board_ms{};
  std::uint32_t number{};
  std::uint16_t age_ms{};  ///< how long ago the tag was read when the frame was sent
  friend bool operator==(const TagRead&, const TagRead&) = default;
};
/// TSVA → PRAV: text for AFFI, at most 32 bytes.
struct Display {
  std::string text;
  friend bool operator==(const Display&, const Display&) = default;
};

/// DOBS → TSVA, every 60 ms. Beam i points at first_bearing + i·beam_width; each beam covers only its own width.
struct Ranges {
  std::uint32_t board_ms{};
  std::int16_t first_bearing_crad{};  ///< of the first beam's centre, hundredths of a radian, left positive
  std::uint16_t beam_width_crad{};
  std::vector<std::uint16_t> range_mm;  ///< from the sensor; 0xFFFF: nothing within reach. At most 32 beams
  friend bool operator==(const Ranges&, const Ranges&) = default;
};
inline constexpr std::uint16_t no_echo = 0xFFFF;

/// RALI → TSVA, 2 Hz.
struct Power {
  /// Sent by a gauge that knows its own uncertainty.
  struct Gauge {
    std::uint32_t charge_ppm{};    ///< the charge again, at a finer resolution
    std::uint16_t charge_sd_01{};  ///< one standard deviation of its error [0.01 %]
    friend bool operator==(const Gauge&, const Gauge&) = default;
  };
  std::uint16_t voltage_mv{};
  std::int16_t current_ma{};  ///< positive discharges
  std::int16_t temperature_01C{};
  std::uint16_t charge_permille{};
  std::optional<Gauge> gauge{};
  /// At the finest resolution sent, 0…1.
  [[nodiscard]] double charge() const { return gauge ? 1e-6 * gauge->charge_ppm : 1e-3 * charge_permille; }
  friend bool operator==(const Power&, const Power&) = default;
};

/// What PILS joins by BRAC (A16), 2 Hz: readings for the operator; nothing on board depends on them.
struct PilsParts {
  static constexpr std::size_t sensors = 8;
  std::uint32_t board_ms{};
  std::uint16_t supply_mv{};  ///< measured by BRAC, the connection module
  std::uint8_t plugs{};       ///< connected to BRAC; bit 0: DEMS, bits 1 and 2: left and right motor of PMOT
  /// Of DEMS' leading row, from right to left; 0: floor … 255: marking.
  std::array<std::uint8_t, sensors> reading{};
  struct Motor {
    std::int16_t speed_mmps{};  ///< of the wheel
    std::int16_t current_ma{};
    friend bool operator==(const Motor&, const Motor&) = default;
  };
  Motor left{};
  Motor right{};
  friend bool operator==(const PilsParts&, const PilsParts&) = default;
};

/// What a self-test examines.
enum class BoardPart : std::uint8_t { controller = 1, BRAC, DEMS, PMOT, RFID, AFFI, ranging, regulator };
inline constexpr std::size_t part_count = 8;
[[nodiscard]] std::string_view to_string(BoardPart part);
/// What a self-test finds.
enum class Finding : std::uint8_t { passed = 0, no_response, implausible, does_not_turn, low_supply };
inline constexpr std::size_t finding_count = 5;
[[nodiscard]] std::string_view to_string(Finding finding);

struct PartFinding {
  BoardPart part{BoardPart::controller};
  Finding finding{Finding::passed};
  friend bool operator==(const PartFinding&, const PartFinding&) = default;
};
/// The code of a fault in a board's heartbeats.
[[nodiscard]] constexpr std::uint8_t fault_code(PartFinding fault) {
  return fault.finding == Finding::passed ? std::uint8_t{0}
                                          : static_cast<std::uint8_t>(static_cast<unsigned>(fault.part) << 4U |
                                                                      static_cast<unsigned>(fault.finding));
}
/// "DEMS: implausible readings", or "fault 77" for a code that is none of these.
[[nodiscard]] std::string fault_text(std::uint8_t code);

/// TSVA → board: test each part. Only a vehicle at standstill requests it.
struct SelfTestRequest {
  std::uint8_t number{};  ///< of the request; the result has the same
  friend bool operator==(const SelfTestRequest&, const SelfTestRequest&) = default;
};
/// Board → TSVA: the result, once. The heartbeats' code of a fault found earlier is replaced by this result.
struct SelfTestResult {
  std::uint8_t number{};
  std::vector<PartFinding> parts;  ///< at most part_count
  friend bool operator==(const SelfTestResult&, const SelfTestResult&) = default;
};

using BoardMessage = std::variant<Hello, Heartbeat, Odometry, Drive, TagRead, Display, Ranges, Power, PilsParts,
                                  SelfTestRequest, SelfTestResult>;

/// Port names of one vehicle's boards: "1/PILS".
[[nodiscard]] std::string port_name(std::uint32_t vehicle_number, Board board);

}  // namespace cosiva::wire
