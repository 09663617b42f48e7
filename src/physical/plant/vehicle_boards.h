#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

#include "cosiva/base/archive_fwd.h"
#include "cosiva/base/random.h"
#include "cosiva/base/time.h"
#include "cosiva/physical/boards/boards.h"
#include "cosiva/physical/plant/plant_options.h"
#include "cosiva/physical/plant/ranging.h"
#include "cosiva/wire/in_process/board_frames.h"
#include "cosiva/wire/in_process/frame_batch.h"
#include "cosiva/wire/messages/board.h"
#include "cosiva/wire/runtime/core.h"

namespace cosiva::physical {

/// The four boards of one emulated vehicle, the on-board program's only access to it.
/// Invariant: between two calls no bytes wait to be sent, and no board has anything to do before the next event.
class VehicleBoards {
 public:
  /// @param number  of the vehicle
  /// @param noise   of the ranges that DOBS measures
  VehicleBoards(std::uint32_t number, const VehicleEquipment& equipment, const PlantNoise& noise, Random range_random);

  /// From now on the boards' frames are passed on as values, all boards' together, instead of bytes.
  void pass_values() { batch_.emplace(number_); }

  /// @param sessions  gives the boards their session numbers
  void power_up(SimTime now, Random sessions);
  /// The supply has failed: no board does anything before power_up().
  void power_off() { powered_ = false; }
  [[nodiscard]] bool powered() const { return powered_; }
  void connect(wire::Board board, bool up);
  void on_bytes(SimTime now, wire::Board board, std::string_view bytes);
  /// Frames passed on as values.
  void on_frames(SimTime now, const wire::BoardFrames& frames);
  void on_tag(SimTime read_at, std::uint32_t number);

  void set_reader_failed(bool failed);
  /// Boards that the vehicle has; RALI is optional.
  [[nodiscard]] bool has(wire::Board board) const { return board != wire::Board::RALI || rali_fitted_; }

  /// Whether a command is in force; if not, the boards are off, or the watchdog has stopped the motors.
  [[nodiscard]] bool driven(SimTime now) const { return powered_ && pils_.driven(now); }
  /// The command in force where the encoders have counted `distance_m`; nothing: none is.
  [[nodiscard]] std::optional<wire::Drive> drive(SimTime now, double distance_m) {
    return powered_ ? pils_.drive(now, distance_m) : std::nullopt;
  }
  [[nodiscard]] LineTracker& line_tracker() { return pils_.line_tracker(); }
  [[nodiscard]] const LineTracker& line_tracker() const { return pils_.line_tracker(); }
  [[nodiscard]] bool wants_scan(SimTime now) const { return dobs_.wants_scan(now) && dobs_.link().connected(); }
  /// Whether speak() has anything to do; half of the time no board has.
  [[nodiscard]] bool due(SimTime now) const { return powered_ && now >= next_event_; }
  /// Lets the boards send what is due. Only when due(now) (checked). @param scan exact ranges, used only when
  /// wants_scan(now)
  void speak(SimTime now, const WheelReadings& wheels, const Scan& scan, const PowerReadings& power,
             wire::Effects& effects);

  /// The boards' sessions and clocks, for a restart of the emulation: the other side finds the same boards again.
  void archive(Archive& archive);
  [[nodiscard]] const std::string& display() const { return prav_.display(); }
  [[nodiscard]] const std::string& port(wire::Board board) const { return ports_[static_cast<std::size_t>(board) - 1]; }

 private:
  [[nodiscard]] BoardLink& link(wire::Board board);
  void speak_bytes(SimTime now, const WheelReadings& wheels, const Scan& scan, const PowerReadings& power,
                   wire::Effects& effects);
  void speak_values(SimTime now, const WheelReadings& wheels, const Scan& scan, const PowerReadings& power,
                    wire::Effects& effects);
  void tick_dobs(SimTime now, const Scan& scan, BoardOutput out);
  void send(wire::Board board, wire::Effects& effects);

  std::uint32_t number_;
  double range_sd_m_;
  double range_dropout_;
  Random range_random_;
  PilsBoard pils_;
  PravBoard prav_;
  DobsBoard dobs_;
  RaliBoard rali_;
  bool rali_fitted_;
  bool powered_{true};
  std::array<std::string, wire::all_boards.size()> ports_;
  std::string out_;
  SimTime next_event_{SimTime::min()};     ///< the first of what the boards have to do
  std::optional<wire::FrameBatch> batch_;  ///< where frames are passed on as values
};

}  // namespace cosiva::physical
