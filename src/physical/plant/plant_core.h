#pragma once

#include <cstdint>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "cosiva/base/pose.h"
#include "cosiva/base/result.h"
#include "cosiva/physical/plant/plant_options.h"
#include "cosiva/wire/runtime/core.h"
#include "cosiva/zone/rtm/rtm.h"

namespace cosiva::physical {

/// The ground truth of one vehicle.
struct TrueVehicle {
  std::uint32_t number;
  Pose2 X_MB;
  double speed_mps;
  double distance_m;    ///< driven along paths since the start
  std::uint32_t laps;   ///< complete laps, on zones that form one loop; those of earlier zones count on
  double charge;        ///< state of charge, 0…1
  bool powered;         ///< its PILS receives valid drive commands
  std::string display;  ///< the text on AFFI
  /// On the path that it follows, regardless of other sections next to or under that; nothing in a manoeuvre.
  std::optional<zone::TrackPosition> position;
  /// The ground truth of its battery, and the current that the vehicle draws.
  struct Power {
    double voltage_v;
    double current_a;  ///< positive discharges
    double temperature_c;
    double load_w;
    bool cut_off;
  };
  Power power;
};

/// Two bodies in contact: reported once per contact.
struct Collision {
  SimTime at;
  std::string a;  ///< "AIV1", or an obstacle's id
  std::string b;
};

/// The emulated plant. Publishes its zone 300 ms after its link was established, unless the broker has a zone with the
/// same sections: the plant then adopts that zone's tags, beacons and priorities (an operator's edit outlives the
/// plant), as well as later edits. A retained zone with other sections from an earlier run is overridden: the plant
/// decides what is on the floor. A zone with other sections that is sent later is a switch: it becomes the floor under
/// each vehicle as soon as that vehicle is stopped; the body, whose shape no map changes, the odometer, the battery and
/// all obstacles stay as they are. No zone is refused because the plant has too many vehicles. A configuration that
/// cannot be read changes nothing, and the reason is logged.
///
/// Commands (plant_command_topic or Input::command): {"addObstacle":{"id","x","y","radius"}}, which also moves the
/// obstacle of this id; {"removeObstacle":"id"}; {"switch":{"format","origin","text","sidecar"}}, the physical
/// side's new zone by hand, which the plant then publishes; {"changeBattery":{"vehicle":1,"id":"B7",…}}
/// (power_train.h), another battery in a vehicle; {"setLoad":{"vehicle":1,"factor":1.02}}, the vehicle's consumption
/// relative to the others; {"setFault":{"vehicle":1,"fault":"dead_motor",…}} (vehicle_faults.h); an invalid command is
/// logged.
///
/// The world persists ten times a second, and at each of those commands: a plant that starts again begins where it
/// ended. Bodies, trips, batteries, obstacles, contacts and the zone in force are as they were, and the boards continue
/// their sessions, so a vehicle's program finds the same odometer; only the random draws begin again. What a plant with
/// other options has persisted is not restored, and the reason is logged.
///
/// Ticks once in a cycle; no board sends more often. Ports:
/// wire::port_name(number, board) for every vehicle, from the board's side.
class PlantCore final : public wire::Core {
 public:
  /// Fails when the zone's configuration is invalid or cannot hold so many vehicles.
  [[nodiscard]] static Result<std::unique_ptr<PlantCore>> make(PlantOptions options);
  ~PlantCore() override;

  void handle(const wire::Input& input, wire::Effects& effects) override;
  [[nodiscard]] SimDuration tick_period() const override;
  [[nodiscard]] std::vector<std::string> subscriptions() const override;
  void farewell(SimTime now, wire::Effects& effects) override;
  void fold(Digest& digest) const override;

  /// Which types are persisted, and the types of their members.
  friend std::map<std::string, std::string> persisted_layout(PlantCore& plant);
  /// Number of the format of persisted_bytes(): increases with every change of what the plant's classes store.
  static constexpr std::uint32_t persisted_format = 2;
  /// Digest of persisted_layout() in this format: a test compares, so that no change of the members is overlooked.
  static constexpr std::string_view persisted_layout_digest = "e67fb85cf59ac936";
  /// What is persisted; read from a dead core where frames pass as values, because nothing is persisted there.
  [[nodiscard]] std::string persisted_bytes() const;
  /// With the present zone: edited, or switched to.
  [[nodiscard]] const PlantOptions& options() const;
  [[nodiscard]] std::vector<std::string> ports() const;
  [[nodiscard]] std::vector<TrueVehicle> vehicles() const;
  [[nodiscard]] const std::vector<Collision>& collisions() const;
  /// {"vehicles":[{"number","x","y","heading","speed","distance","laps","charge"}…],"collisions":[…],"laps":total,"longest_wait_s":…}
  [[nodiscard]] std::string summary_json() const;

 private:
  PlantCore();
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace cosiva::physical
