#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "cosiva/base/result.h"
#include "cosiva/base/time.h"
#include "cosiva/wire/messages/topics.h"
#include "cosiva/wire/own/crossing_claims.h"
#include "cosiva/wire/own/crossing_status.h"
#include "cosiva/wire/own/v2x.h"
#include "cosiva/wire/runtime/core.h"
#include "cosiva/zone/rtm/rtm.h"

namespace cosiva::physical {

struct CrossingUnitOptions {
  std::shared_ptr<const zone::Rtm> rtm;  ///< of its zone; not null (checked)
  std::string crossing;                  ///< "X1"
  bool direct{false};                    ///< it has the direct link
  bool emulated{false};                  ///< scenarios switch it off and on (wire::plant_unit_topic)
  bool off{false};                       ///< it begins switched off
};
/// For the journal, and back. Fails ("unit.options").
[[nodiscard]] std::string to_json(const CrossingUnitOptions& options);
[[nodiscard]] Result<CrossingUnitOptions> crossing_unit_options_from_json(std::string_view json);

/// A roadside unit at one crossing (A3): it receives the vehicles' V2X messages; it repeats claims of vehicles near its
/// crossing over the direct link, unchanged, for vehicles out of the sender's reach; and it sends which vehicles
/// occupy, hold and await its crossing, with the age of what it knows: five times a second, and within 100 ms after a
/// change.
///
/// A vehicle occupies the crossing while its newest message states that it is inside, or that its claim is granted. A
/// vehicle that has become unresponsive there occupies the crossing until it sends that it is outside. A vehicle awaits
/// the crossing while it claims it, or lists it in an intent, in a message younger than `fresh`.
///
/// Invariant: the vehicles are in the order of their names, each once, and at most `vehicles_max`.
class CrossingUnit final : public wire::Core {
 public:
  static constexpr std::size_t vehicles_max = 64;
  static constexpr SimDuration fresh{std::chrono::seconds{1}};
  static constexpr SimDuration period{std::chrono::milliseconds{200}};
  /// Vehicles within this distance take part in a claim (docs/protocols/v2x.md).
  static constexpr double repeats_within_m = 4.5;

  /// Fails ("unit.crossing") where the zone has no crossing of this name, or the name cannot be a serial number.
  [[nodiscard]] static Result<std::unique_ptr<CrossingUnit>> make(CrossingUnitOptions options);

  void handle(const wire::Input& input, wire::Effects& effects) override;
  [[nodiscard]] SimDuration tick_period() const override { return std::chrono::milliseconds{100}; }
  [[nodiscard]] std::vector<std::string> subscriptions() const override;
  void farewell(SimTime now, wire::Effects& effects) override;
  void fold(Digest& digest) const override;

  [[nodiscard]] const wire::VehicleId& id() const { return status_.unit; }
  /// What it sent last.
  [[nodiscard]] const wire::CrossingStatus& status() const { return status_; }
  [[nodiscard]] bool on() const { return on_; }
  struct Counters {
    std::uint64_t repeated{};  ///< claims sent again
    std::uint64_t refused{};   ///< messages that could not be read, or of another sender or map than they name
  };
  [[nodiscard]] const Counters& counters() const { return counters_; }

 private:
  struct Vehicle {
    wire::VehicleId id;
    std::shared_ptr<const wire::Intent> intent;
    SimTime intent_at{};
    std::shared_ptr<const wire::CrossingClaims> claims;
    SimTime claims_at{};
  };
  struct Presence;
  explicit CrossingUnit(CrossingUnitOptions options) : options_{std::move(options)}, on_{!options_.off} {}
  void on_message(const wire::Input& input);
  void on_bytes(const wire::Input& input, wire::Effects& effects);
  void on_intent(SimTime now, const wire::VehicleId& sender, const wire::Input& input);
  void on_claims(SimTime now, const wire::VehicleId& sender, const wire::Input& input, wire::Effects& effects);
  void switch_to(const std::string& json);
  /// Null: there are too many.
  [[nodiscard]] Vehicle* vehicle_of(const wire::VehicleId& sender);
  [[nodiscard]] Presence presence_of(const Vehicle& vehicle, SimTime now) const;
  void compute(SimTime now);
  void publish(SimTime now, wire::Effects& effects);

  CrossingUnitOptions options_;
  bool on_;
  bool online_{false};  ///< the broker
  std::vector<Vehicle> vehicles_;
  wire::CrossingStatus status_;
  std::optional<SimTime> published_at_;
  Counters counters_;
};

}  // namespace cosiva::physical
