#pragma once

#include <cstddef>
#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "cosiva/base/digest.h"
#include "cosiva/base/json_writer.h"
#include "cosiva/base/result.h"
#include "cosiva/base/time.h"
#include "cosiva/wire/messages/topics.h"
#include "cosiva/wire/own/crossing_status.h"
#include "cosiva/wire/runtime/core.h"

namespace cosiva::virtual_side {

/// The crossing units that the server observes. They are shown, and have no effect on anything that the server decides,
/// sends or stores, so that a snapshot of the server does not contain them: a unit is known again after its next
/// message, 200 ms later.
///
/// Invariant: at most units_max units are stored, each under its crossing's name.
class CrossingUnits {
 public:
  static constexpr std::size_t units_max = 256;
  /// Ten of a unit's periods.
  static constexpr SimDuration unresponsive_after{std::chrono::seconds{2}};
  /// A vehicle in a crossing sends several messages a second.
  static constexpr SimDuration evidence_age_max{std::chrono::seconds{10}};
  /// No vehicle needs so long to leave a crossing, unless it is stopped there.
  static constexpr SimDuration held_for_max{std::chrono::seconds{60}};

  [[nodiscard]] static bool handles(std::string_view topic);
  [[nodiscard]] static std::vector<std::string> subscriptions();
  /// Fails where the message cannot be used.
  [[nodiscard]] Result<void> on_message(SimTime now, const wire::Input& input);

  /// [{"crossing","x","y","state":"online"|"unresponsive","age_ms","holders":[{"id","age_ms"}],"waiting":[…],
  /// "trouble":null|text}…] of the units of this zone.
  void write(JsonWriter& json, SimTime now, std::string_view map_id) const;
  /// Changes with whatever an operator waits for: states, holders and troubles.
  void fold(Digest& digest, SimTime now) const;

 private:
  struct Unit {
    wire::CrossingStatus last;
    SimTime at{};
    SimTime held_since{};  ///< by the first of the present holders
  };
  [[nodiscard]] static bool unresponsive(const Unit& unit, SimTime now) { return now - unit.at >= unresponsive_after; }
  /// What an operator should check, as a text; empty: nothing.
  [[nodiscard]] static std::string trouble(const Unit& unit, SimTime now);

  std::map<std::string, Unit> units_;
};

}  // namespace cosiva::virtual_side
