#pragma once

#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "cosiva/base/archive_fwd.h"
#include "cosiva/wire/messages/messages.h"
#include "cosiva/wire/runtime/core.h"
#include "cosiva/zone/rtm/rtm.h"

namespace cosiva::aiv {

/// Which zone is in force, which one is pending until the vehicle has stopped, and why an announced one is not used.
///
/// Invariant: maps() lists the zone in force first, the pending one second, and no other. There is no pending zone
/// before a first one is in force.
class ZoneSelection {
 public:
  enum class Verdict {
    unchanged,   ///< the announced zone is in force or pending already
    refused,     ///< the announcement is no zone; refusal() gives the reason
    first,       ///< the zone can be put in force, because no other is
    edited,      ///< the circuit in force with other fiducials: in force at once
    pending,     ///< another circuit: the zone waits until the vehicle has stopped
    called_off,  ///< the zone in force again, before the vehicle had stopped
  };
  struct Decision {
    Verdict verdict;
    std::shared_ptr<const zone::Rtm> rtm;  ///< of `first` and `edited`
  };
  /// @param built     the RTM of `announced` where it was built already; null: it is built here if it is news
  /// @param in_force  none before the first zone
  [[nodiscard]] Decision on_announced(const zone::ZoneConfiguration& announced, std::shared_ptr<const zone::Rtm> built,
                                      const zone::TrafficZone* in_force, wire::Effects& effects);
  /// The zone is in force from now on, and none is pending.
  void enforce(const zone::Rtm& rtm);

  /// Of the zone in force; null: none.
  [[nodiscard]] const zone::ZoneConfiguration* configuration() const {
    return configuration_ ? &*configuration_ : nullptr;
  }
  /// Null: none.
  [[nodiscard]] const std::shared_ptr<const zone::Rtm>& pending() const { return pending_; }
  /// Why the zone announced last is not used; empty: it is.
  [[nodiscard]] const std::string& refusal() const { return refusal_; }
  [[nodiscard]] const std::vector<wire::MapInfo>& maps() const { return maps_; }
  void archive(Archive& archive);  ///< the state, for a snapshot

 private:
  [[nodiscard]] Decision refuse(const Error& error, char level, wire::Effects& effects);
  /// False: none was pending.
  [[nodiscard]] bool call_off(const zone::TrafficZone& in_force, wire::Effects& effects);
  void list_maps();

  std::optional<zone::ZoneConfiguration> configuration_;  ///< of the zone in force
  std::string name_;                                      ///< likewise
  std::shared_ptr<const zone::Rtm> pending_;
  std::string refusal_;
  std::vector<wire::MapInfo> maps_;
};

}  // namespace cosiva::aiv
