#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "cosiva/battery/cell_table.h"
#include "cosiva/physical/boards/boards.h"
#include "cosiva/physical/plant/floor.h"
#include "cosiva/physical/plant/odometer.h"
#include "cosiva/physical/plant/plant_core.h"
#include "cosiva/physical/plant/plant_options.h"
#include "cosiva/physical/plant/power_train.h"
#include "cosiva/physical/plant/ranging.h"
#include "cosiva/physical/plant/tag_reader.h"
#include "cosiva/physical/plant/vehicle_dynamics.h"

namespace cosiva::physical {

/// One emulated AIV: its body on the path, its sensors and battery, and the four boards, the on-board program's only
/// access to them.
class Vehicle {
 public:
  Vehicle(std::uint32_t number, std::shared_ptr<const Floor> floor, zone::TrackPosition start, const PlantNoise& noise,
          std::uint64_t seed, const std::shared_ptr<const battery::CellTable>& cells, SimDuration step_max);

  /// Switches the boards on. Their session numbers come from the seed and the time, so that the same plant started
  /// later has others, as after a real power cut.
  void power_up(SimTime now, std::uint64_t seed);
  void connect(wire::Board board, bool up);
  void on_bytes(SimTime now, wire::Board board, std::string_view bytes);

  /// Moves the body over `dt`, in steps of at most step_max.
  void move(SimTime now, SimDuration dt);
  /// Whether the floor under the vehicle may be replaced: it is at rest, and in no commanded manoeuvre.
  [[nodiscard]] bool is_stopped() const { return motion_.is_stopped(); }
  /// Another floor is pending: when commanded to seek a line, which can only be one of that floor, the vehicle first
  /// comes to rest.
  void await_floor() { awaits_floor_ = true; }
  /// Puts the vehicle on another floor, the body unchanged. Only while it is stopped.
  void set_zone(std::shared_ptr<const Floor> floor);
  [[nodiscard]] bool wants_scan(SimTime now) const { return dobs_.wants_scan(now) && dobs_.link().connected(); }
  /// Lets the boards send. @param scan exact ranges, used only when wants_scan(now)
  void speak(SimTime now, const Scan& scan, wire::Effects& effects);

  [[nodiscard]] std::uint32_t number() const { return number_; }
  [[nodiscard]] const LineVehicle& motion() const { return motion_; }
  [[nodiscard]] PowerTrain& power() { return power_; }
  [[nodiscard]] const PowerTrain& power() const { return power_; }
  [[nodiscard]] const std::shared_ptr<const Floor>& floor() const { return floor_; }
  /// Along sections: motion in manoeuvres is not counted.
  [[nodiscard]] double distance_m() const { return distance_m_; }
  /// Complete laps, on floors that form one loop.
  [[nodiscard]] std::uint32_t laps() const { return laps_before_ + laps_here(); }
  [[nodiscard]] double longest_wait_s() const { return to_seconds(longest_wait_); }
  [[nodiscard]] bool powered(SimTime now) const { return pils_.drive(now) != nullptr && !power_.cut_off(); }
  [[nodiscard]] const std::string& display() const { return prav_.display(); }
  [[nodiscard]] double charge() const { return power_.pack().charge(); }
  [[nodiscard]] const std::string& port(wire::Board board) const;

 private:
  [[nodiscard]] BoardLink& link(wire::Board board);
  void step(SimTime now, double dt_s);
  void step_manoeuvre();
  void read_tags(SimTime now, Point2 before);
  void book_energy(double dt_s);
  [[nodiscard]] std::uint32_t laps_here() const;
  void book_waiting(SimDuration dt);
  void send(wire::Board board, wire::Effects& effects);

  std::uint32_t number_;
  SimDuration step_max_;
  PlantNoise noise_;
  std::shared_ptr<const Floor> floor_;
  LineVehicle motion_;
  Odometer odometer_;
  TagReader tag_reader_;
  Random range_random_;
  PowerTrain power_;
  PilsBoard pils_;
  PravBoard prav_;
  DobsBoard dobs_;
  RaliBoard rali_;
  std::array<std::string, wire::all_boards.size()> ports_;

  double distance_m_{0.0};
  double distance_before_m_{0.0};  ///< on the previous floors
  std::uint32_t laps_before_{0};
  bool awaits_floor_{false};
  bool in_manoeuvre_{false};
  double drive_energy_j_{0.0};  ///< since the last update of the battery
  double drive_time_s_{0.0};
  bool has_moved_{false};
  SimDuration wait_{};
  SimDuration longest_wait_{};
  std::vector<TagReader::Reading> readings_;
  std::string out_;
};

}  // namespace cosiva::physical
