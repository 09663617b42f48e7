#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "cosiva/aiv/localisation/persisted_position.h"
#include "cosiva/aiv/onboard/driving_context.h"
#include "cosiva/aiv/onboard/onboard_options.h"
#include "cosiva/aiv/onboard/periodic.h"
#include "cosiva/base/archive_fwd.h"
#include "cosiva/wire/runtime/core.h"

namespace cosiva::aiv {

/// The vehicle's position when its program starts, and what the program saves of it for the next start.
///
/// Invariant: a saved position names the PILS session whose odometer it was read from. A restored position is used at
/// most once, and never with the odometer of another session.
class PositionStore {
 public:
  explicit PositionStore(const OnboardOptions& options);

  /// What the program saved before its restart. Pause and imposed profile hold at once.
  void restore(PersistedPosition restored, DrivingContext* context);
  /// True: PILS has restarted since its last hello, so that its odometer counts from another origin.
  [[nodiscard]] bool on_pils_hello(std::uint32_t session);
  /// The first zone is in force.
  void on_first_zone(DrivingContext& context, wire::Effects& effects);
  /// Another zone is in force: the configured start is of the zone before.
  void on_zone_switched(DrivingContext& context);
  /// Finds the position if no better one is known: the restored one first, because a vehicle that has driven is no
  /// longer at its start; then the configured start.
  void find_position(DrivingContext& context);
  /// An operator has given the position: the restored position is void.
  void discard_restored();

  /// The loads on board, which are saved with the position.
  void keep_loads(const std::vector<wire::Load>& loads);
  /// A change has to be saved that the odometer does not show.
  void request_save() { requested_ = true; }
  /// Saves what has changed: periodically, as soon as the vehicle stops, and on request. Where a vehicle that was saved
  /// in another zone has not moved, or that section is in this zone too, its position is known after some seconds.
  void on_tick(SimTime now, DrivingContext& context, wire::Effects& effects);
  void save_now(const DrivingContext& context, wire::Effects& effects);
  /// What was saved last where messages pass as values; empty: nothing yet.
  [[nodiscard]] std::string saved_json() const;
  void archive(Archive& archive);  ///< the state, for a snapshot

 private:
  void restrict(Agent& agent) const;
  /// Sets the estimate to the restored position: false where it is impossible.
  [[nodiscard]] bool restore_position(DrivingContext& context);
  void restore_in_another_zone(SimTime now, DrivingContext& context);
  [[nodiscard]] static std::optional<zone::TrackPosition> restored_position(const zone::Circuit& circuit,
                                                                            const PersistedPosition& restored,
                                                                            double distance_m);
  void save(bool due, const DrivingContext& context, wire::Effects& effects);

  std::optional<OnboardOptions::Start> start_;
  bool as_values_;
  bool start_counts_{true};  ///< the configured start is of the zone in force
  std::optional<PersistedPosition> restored_;
  std::optional<SimTime> other_zone_since_;  ///< the zone in force is not that of the restored position
  std::optional<PersistedPosition> saved_;   ///< where messages pass as values
  std::optional<std::uint32_t> pils_session_;
  Periodic timer_;
  std::optional<std::int64_t> saved_um_;
  std::optional<Pose2> saved_manoeuvre_;
  std::vector<wire::Load> loads_;
  bool requested_{false};
  bool was_stopped_{true};
};

}  // namespace cosiva::aiv
