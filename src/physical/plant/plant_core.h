#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "cosiva/base/pose.h"
#include "cosiva/base/result.h"
#include "cosiva/physical/plant/plant_options.h"
#include "cosiva/wire/runtime/core.h"
#include "cosiva/zone/rtm/rtm.h"

namespace cosiva::physical {

/// One vehicle as it truly is.
struct TrueVehicle {
  std::uint32_t number;
  Pose2 X_MB;
  double speed_mps;
  double distance_m;    ///< driven along lines since the start
  std::uint32_t laps;   ///< whole ones, on zones that are one ring; those of zones before count on
  double charge;        ///< state of charge, 0…1
  bool powered;         ///< its PILS gets valid drive commands
  std::string display;  ///< what AFFI shows
  /// On the line that it follows, whatever lies beside or under that; nothing in a manoeuvre.
  std::optional<zone::TrackPosition> position;
  /// Its battery, as it truly is, and what it takes of it.
  struct Power {
    double voltage_v;
    double current_a;  ///< positive discharges
    double temperature_c;
    double load_w;
    bool cut_off;
  };
  Power power;
};

/// Two bodies that touch: said once per contact.
struct Collision {
  SimTime at;
  std::string a;  ///< "AIV1", or an obstacle's id
  std::string b;
};

/// The emulated world. Hands its zone over 300 ms after its link came up, unless the broker has one of the same ways:
/// that one's tags, beacons and priorities are then its own (an operator's edit outlives the plant), as are later
/// edits. One of other ways that the broker keeps from before it overrides: what is on the floor is the plant's to say.
/// One that is sent later is a switch: it becomes the floor under each vehicle as soon as that stands, with its body,
/// whose shape no map changes, its odometer, its battery and all obstacles as they are. Nothing is refused for having
/// too many vehicles. A configuration that cannot be read leaves all as it is, and the log says why.
///
/// Commands (plant_command_topic or Input::command): {"addObstacle":{"id","x","y","radius"}}, which also moves the one
/// of this id; {"removeObstacle":"id"}; {"switch":{"format","origin","text","sidecar file"}}, the physical side's new
/// zone by hand, which it then publishes; {"changeBattery":{"vehicle":1,"id":"B7",…}} (power_train.h), another battery
/// in a cart; {"setLoad":{"vehicle":1,"factor":1.02}}, how much more than others it takes; what makes no sense is
/// logged. Ticks once in a cycle; no board speaks more often. Ports: wire::port_name(number, board) for every vehicle,
/// spoken from the board's side.
class PlantCore final : public wire::Core {
 public:
  /// Fails when the zone's configuration is bad or cannot hold so many vehicles.
  [[nodiscard]] static Result<std::unique_ptr<PlantCore>> make(PlantOptions options);
  ~PlantCore() override;

  void handle(const wire::Input& input, wire::Effects& effects) override;
  [[nodiscard]] SimDuration tick_period() const override;
  [[nodiscard]] std::vector<std::string> subscriptions() const override;
  void farewell(SimTime now, wire::Effects& effects) override;
  void fold(Digest& digest) const override;

  /// With the zone as it is now: edited, or switched to.
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
