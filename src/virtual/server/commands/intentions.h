#pragma once

#include <map>
#include <optional>
#include <string>
#include <vector>

#include "cosiva/aiv/motion/speed.h"
#include "cosiva/base/archive_fwd.h"
#include "cosiva/base/json_value.h"
#include "cosiva/base/json_writer.h"
#include "cosiva/virtual/server/commands/values/operator_command.h"

namespace cosiva::virtual_side {

/// The speed profile that a command imposes; nothing where it imposes none.
[[nodiscard]] std::optional<aiv::Profile> profile_of(OperatorCommandKind kind);

/// What an operator has decided for a vehicle and not lifted. An intention holds whether the vehicle is there or not,
/// and over restarts of vehicle and server; no time limit ends it.
struct Intention {
  bool stopped{false};
  bool cancelled{false};
  std::optional<aiv::Profile> profile;
  std::optional<double> speed_mps_max{};
  bool excluded{false};  ///< gets no orders and no missions until it is included

  [[nodiscard]] bool empty() const { return *this == Intention{}; }
  void take(OperatorCommandKind kind, double speed_mps);
  friend bool operator==(const Intention&, const Intention&) = default;
};

/// The intentions for all vehicles: those of one vehicle, and those for every vehicle that has none of its own, also
/// for one that is not known yet.
///
/// Invariant: a vehicle has an intention of its own only where that differs from the one for every vehicle.
class Intentions {
 public:
  /// @param speed_mps  of `limit`
  void take(const std::string& vehicle_name, OperatorCommandKind kind, double speed_mps);
  /// A command to all vehicles.
  void take_for_all(OperatorCommandKind kind, double speed_mps);
  /// A mission was given: the cancellation is lifted.
  void on_mission(const std::string& vehicle_name);

  [[nodiscard]] const Intention& of(const std::string& vehicle_name) const;
  /// The names of the vehicles that have an intention of their own, sorted.
  [[nodiscard]] std::vector<std::string> names() const;
  [[nodiscard]] bool empty() const { return everyone_.empty() && own_.empty(); }

  /// {"all":{…},"vehicles":{"CoSiVA/AIV1":{"stopped":true,"cancelled":true,"excluded":true,"profile":"slow","speed":0.25}}}
  void write(JsonWriter& json) const;
  /// Replaces all intentions; items that cannot be read are skipped, and false is returned.
  [[nodiscard]] bool restore(const JsonValue& json);
  void archive(Archive& archive);  ///< the state, for a snapshot

 private:
  void set(const std::string& vehicle_name, const Intention& intention);

  Intention everyone_;
  std::map<std::string, Intention, std::less<>> own_;
};

}  // namespace cosiva::virtual_side
