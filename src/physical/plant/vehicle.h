#pragma once

#include <cstdint>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "cosiva/base/archive_fwd.h"
#include "cosiva/battery/cell_table.h"
#include "cosiva/physical/plant/floor.h"
#include "cosiva/physical/plant/odometer.h"
#include "cosiva/physical/plant/plant_core.h"
#include "cosiva/physical/plant/plant_options.h"
#include "cosiva/physical/plant/power_train.h"
#include "cosiva/physical/plant/ranging.h"
#include "cosiva/physical/plant/tag_reader.h"
#include "cosiva/physical/plant/trip_counter.h"
#include "cosiva/physical/plant/vehicle_boards.h"
#include "cosiva/physical/plant/vehicle_dynamics.h"
#include "cosiva/physical/plant/vehicle_faults.h"

namespace cosiva::physical {

/// One emulated AIV: its body on the path, its sensors and battery, and the four boards, the on-board program's only
/// access to them. Invariant: the floor changes only under a stopped vehicle.
class Vehicle {
 public:
  Vehicle(std::uint32_t number, std::shared_ptr<const Floor> floor, zone::TrackPosition start, const PlantNoise& noise,
          const VehicleEquipment& equipment, std::uint64_t seed, const std::shared_ptr<const battery::CellTable>& cells,
          SimDuration step_max);

  /// Switches the boards on. Their session numbers come from the seed and the time, so that the same plant started
  /// later has others, as after a real power cut.
  void power_up(SimTime now, std::uint64_t seed);
  [[nodiscard]] VehicleBoards& boards() { return boards_; }
  [[nodiscard]] const VehicleBoards& boards() const { return boards_; }
  /// A fault that a scenario injects; nothing: all of them end.
  void inject(SimTime now, const std::optional<VehicleFault>& fault);

  /// Moves the body over `dt`, in steps of at most step_max.
  void move(SimTime now, SimDuration dt);
  /// Whether the floor under the vehicle may be replaced: it is at rest, and in no commanded manoeuvre.
  [[nodiscard]] bool is_stopped() const { return motion_.is_stopped(); }
  /// Another floor is pending: when commanded to seek a line, which can only be one of that floor, the vehicle first
  /// comes to rest.
  void await_floor() { awaits_floor_ = true; }
  /// Puts the vehicle on another floor, the body unchanged. Only while it is stopped.
  void set_zone(std::shared_ptr<const Floor> floor);
  /// The floor has other tags than before.
  void on_tags_changed() { tag_reader_.on_tags_changed(); }
  /// Lets the boards send. @param scan exact ranges, used only when wants_scan(now)
  void speak(SimTime now, const Scan& scan, wire::Effects& effects);

  [[nodiscard]] std::uint32_t number() const { return number_; }
  /// In the travel frame of the floor's zone.
  [[nodiscard]] const LineVehicle& motion() const { return motion_; }
  [[nodiscard]] PowerTrain& power() { return power_; }
  [[nodiscard]] const PowerTrain& power() const { return power_; }
  [[nodiscard]] const std::shared_ptr<const Floor>& floor() const { return floor_; }
  [[nodiscard]] const TripCounter& trip() const { return trip_; }
  [[nodiscard]] bool powered(SimTime now) const { return boards_.driven(now) && !power_.cut_off(); }
  /// The state, for a restart of the emulation: to be read on the floor that it was written on.
  void archive(Archive& archive);

 private:
  void step(SimTime now, double dt_s);
  void step_manoeuvre();
  void read_tags(SimTime now, Point2 before);
  void book_energy(double dt_s);
  void book_waiting(SimDuration dt);
  void end_faults(SimTime now);
  [[nodiscard]] WheelReadings wheel_readings() const;

  std::uint32_t number_;
  SimDuration step_max_;
  std::shared_ptr<const Floor> floor_;
  LineVehicle motion_;
  Odometer odometer_;
  TagReader tag_reader_;
  PowerTrain power_;
  VehicleBoards boards_;
  TripCounter trip_;

  VehicleFaults faults_;
  std::uint64_t seed_;

  bool awaits_floor_{false};
  bool in_manoeuvre_{false};
  struct Draw {
    double energy_j;  ///< of the wheels, since the last update of the battery
    double time_s;
    double power_w;  ///< of the wheels, in the last step
  };
  Draw draw_{};
  std::vector<TagReader::Reading> readings_;
};

/// X_MB of the vehicle's body, whose motion() is in the travel frame.
[[nodiscard]] inline Pose2 body_pose(const Vehicle& vehicle) {
  return zone::body_pose(*vehicle.floor()->zone, vehicle.motion().body().X_MB);
}

}  // namespace cosiva::physical
