#pragma once

#include <algorithm>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "cosiva/base/pose.h"
#include "cosiva/base/time.h"
#include "cosiva/physical/boards/board_link.h"
#include "cosiva/physical/boards/line_tracker.h"
#include "cosiva/wire/messages/board.h"

/// The four boards of one vehicle (A14 to A17), between the plant's values and the module link's frames. Each board is
/// given frames and the time, and appends frames to `out`; measured values are passed in as plain SI values.
namespace cosiva::physical {

/// The inputs of PILS from its line sensors and wheel encoders.
struct WheelReadings {
  double distance_m;     ///< counted by the encoders since power-up, forwards positive
  double speed_mps;      ///< negative backwards
  double line_offset_m;  ///< of the line from the sensor's centre, left positive
  bool line_lost;
  const Pose2* manoeuvre{nullptr};  ///< the displacement by the wheels since the vehicle left the path, if it did
  struct Motor {
    double speed_mps{};  ///< of its wheel
    double current_a{};
    bool turns{true};  ///< in a test pulse, too short to move the vehicle
  };
  Motor left{};
  Motor right{};
  DemsRow dems{};          ///< the leading row
  double supply_v{5.0};    ///< at BRAC
  bool rear_leads{false};  ///< the vehicle travels in indirect direction
};

/// Line tracking (A16): odometry out at 50 Hz, Drive in; the motors stop by themselves 300 ms after the last valid
/// Drive, at the latest at the end of its room, and with a fault of DEMS or PMOT. Steers by its line tracking.
class PilsBoard {
 public:
  static constexpr SimDuration drive_timeout = std::chrono::milliseconds{300};

  /// @param line_tracking  one of line_tracking_names() (checked)
  explicit PilsBoard(std::string_view line_tracking = "centroid_pd") : line_tracker_{line_tracking} {}

  [[nodiscard]] BoardLink& link() { return link_; }
  [[nodiscard]] const BoardLink& link() const { return link_; }
  void power_up(SimTime now, std::uint32_t session, SimDuration phase);
  void on_bytes(SimTime now, std::string_view bytes);
  void on_frame(SimTime now, const wire::BoardFrames::Frame& frame);
  void tick(SimTime now, const WheelReadings& readings, BoardOutput out);
  /// Whether the last Drive is recent enough to be obeyed.
  [[nodiscard]] bool driven(SimTime now) const { return drive_ && now - driven_at_ <= drive_timeout; }
  /// What the motors have to do where the encoders have counted `distance_m`; nothing: stop.
  [[nodiscard]] std::optional<wire::Drive> drive(SimTime now, double distance_m);
  [[nodiscard]] LineTracker& line_tracker() { return line_tracker_; }
  [[nodiscard]] const LineTracker& line_tracker() const { return line_tracker_; }

  /// As BoardLink::next_due.
  [[nodiscard]] SimTime next_due() const { return std::min(link_.next_due(), odometry_.next()); }

 private:
  void on_message(SimTime now, const wire::BoardMessage& message);
  void send_odometry(SimTime now, const WheelReadings& readings, BoardOutput out);
  void send_parts(SimTime now, const WheelReadings& readings, BoardOutput out);
  void watch_parts(const WheelReadings& readings);
  [[nodiscard]] static std::vector<wire::PartFinding> test_parts(const WheelReadings& readings);

  BoardLink link_{wire::Board::PILS};
  LineTracker line_tracker_;
  Every odometry_{std::chrono::milliseconds{20}};
  Every parts_{std::chrono::milliseconds{500}};
  int uneven_cycles_{0};  ///< in which one wheel has turned and the other one has not
  std::optional<wire::Drive> drive_;
  SimTime driven_at_{};
  std::optional<double> received_at_m_;  ///< of the encoders, at the first step after drive_ arrived
};

/// Tag reading and display control (A15): one frame per tag read, texts for AFFI in.
class PravBoard {
 public:
  [[nodiscard]] BoardLink& link() { return link_; }
  [[nodiscard]] const BoardLink& link() const { return link_; }
  void power_up(SimTime now, std::uint32_t session);
  void on_bytes(SimTime now, std::string_view bytes);
  void on_frame(SimTime now, const wire::BoardFrames::Frame& frame);
  /// The reader has a tag's number from `read_at` on, which may be in the future: the board sends the number at the
  /// first tick from then on.
  void on_tag(SimTime read_at, std::uint32_t number);
  void tick(SimTime now, BoardOutput out);
  [[nodiscard]] const std::string& display() const { return display_; }
  /// The RFID module responds no more, or again.
  void set_reader_failed(bool failed) { reader_failed_ = failed; }

  /// As BoardLink::next_due; a new reading comes before it, too.
  [[nodiscard]] SimTime next_due() const;

 private:
  void on_message(const wire::BoardMessage& message);

  struct Reading {
    SimTime read_at;
    std::uint32_t number;
  };
  BoardLink link_{wire::Board::PRAV};
  std::vector<Reading> readings_;
  std::string display_;
  bool reader_failed_{false};
};

/// Obstacle ranging (A17): a fan of sectors at the vehicle's leading end, 60 ms apart as echoes need. Invariant: one
/// range for each beam.
class DobsBoard {
 public:
  static constexpr std::size_t beams = 13;
  static constexpr std::uint16_t beam_width_crad = 14;
  static constexpr std::int16_t first_bearing_crad = -84;  ///< thirteen beams centred on straight ahead
  static constexpr std::int16_t half_turn_crad = 314;      ///< added to the bearings of the fan at the rear
  static constexpr double reach_m = 2.0;                   ///< from the sensor

  [[nodiscard]] BoardLink& link() { return link_; }
  [[nodiscard]] const BoardLink& link() const { return link_; }
  void power_up(SimTime now, std::uint32_t session, SimDuration phase);
  void on_bytes(SimTime now, std::string_view bytes);
  void on_frame(SimTime now, const wire::BoardFrames::Frame& frame);
  /// The sensor at the rear measures from now on, or the one at the front: whichever end leads.
  void select_rear(bool at_rear) { at_rear_ = at_rear; }
  /// True when the next tick sends ranges and therefore needs them.
  [[nodiscard]] bool wants_scan(SimTime now) const { return scan_.due(now); }
  /// @param range_m  one per beam [m], negative: no echo; used only when wants_scan(now)
  void tick(SimTime now, std::span<const double, beams> range_m, BoardOutput out);

  /// As BoardLink::next_due.
  [[nodiscard]] SimTime next_due() const { return std::min(link_.next_due(), scan_.next()); }

 private:
  BoardLink link_{wire::Board::DOBS};
  Every scan_{std::chrono::milliseconds{60}};
  bool at_rear_{false};
  wire::BoardMessage ranges_{wire::Ranges{}};  ///< stored, so that a scan allocates nothing
};

/// What RALI measures and counts.
struct PowerReadings {
  double voltage_v;
  double current_a;  ///< positive discharges
  double temperature_c;
  double charge;          ///< 0…1, as the gauge estimates
  double charge_sd{0.0};  ///< of its error; 0: the gauge gives no uncertainty
};

/// Regulated supply (A17), 2 Hz.
class RaliBoard {
 public:
  [[nodiscard]] BoardLink& link() { return link_; }
  [[nodiscard]] const BoardLink& link() const { return link_; }
  void power_up(SimTime now, std::uint32_t session, SimDuration phase);
  void on_bytes(SimTime now, std::string_view bytes);
  void on_frame(SimTime now, const wire::BoardFrames::Frame& frame);
  /// @param readings  used only when a report is due
  void tick(SimTime now, const PowerReadings& readings, BoardOutput out);

  /// As BoardLink::next_due.
  [[nodiscard]] SimTime next_due() const { return std::min(link_.next_due(), report_.next()); }

 private:
  BoardLink link_{wire::Board::RALI};
  Every report_{std::chrono::milliseconds{500}};
};

}  // namespace cosiva::physical
