#pragma once

#include <cstdint>
#include <optional>

#include "cosiva/base/archive_fwd.h"

namespace cosiva::virtual_side {

/// What operators, the zone and the server have set for a vehicle: its priority, its limit of speed, and whether it
/// gets orders, is excluded, or is paused.
///
/// Invariant: the priority is one that a zone can give (0 to 999), a limit of speed is positive and finite, and a
/// vehicle is paused for at most one virtual body at a time.
class OperatorSettings {
 public:
  /// @param priority  from 0 to zone::priority_max (checked)
  void set_priority(std::int32_t priority);

  /// An operator has stopped the vehicle: from now on the operator, and not a virtual body, pauses the vehicle, which
  /// must confirm that before it gets orders.
  void on_stop() {
    paused_for_body_ = false;
    stop_awaited_ = true;
  }
  void on_restart();
  /// An operator has cancelled the order: the vehicle gets no orders until it is restarted or given a mission.
  void on_cancel() { no_orders_ = true; }
  void on_mission() { no_orders_ = false; }
  /// An operator has excluded the vehicle, or included it again: excluded, it gets neither orders nor missions.
  void set_excluded(bool excluded) { excluded_ = excluded; }
  /// Whether the vehicle must confirm first that it is stopped, before it gets orders.
  void await_stop(bool awaited) { stop_awaited_ = awaited; }
  /// An operator has chosen a speed profile, which replaces a limit.
  void on_profile() { speed_mps_max_.reset(); }
  /// The vehicle has confirmed an individual limit of an operator.
  /// @param speed_mps  positive and finite (checked)
  void on_limit(double speed_mps);
  /// The vehicle may have been restarted: no limit is confirmed any more.
  void on_session() { speed_mps_max_.reset(); }
  /// The server pauses the vehicle for a virtual body that the vehicle cannot perceive; no other body paused it
  /// (checked).
  void on_body_in_path();
  /// The server ends that pause (checked).
  void on_body_left();
  void on_retired() { paused_for_body_ = false; }

  [[nodiscard]] std::int32_t priority() const { return priority_; }  ///< higher goes first at a crossing
  [[nodiscard]] std::optional<double> speed_mps_max() const { return speed_mps_max_; }
  [[nodiscard]] bool no_orders() const { return no_orders_ || stop_awaited_ || excluded_; }
  [[nodiscard]] bool excluded() const { return excluded_; }
  /// An operator's Stop holds, and the vehicle has not confirmed it.
  [[nodiscard]] bool stop_awaited() const { return stop_awaited_; }
  [[nodiscard]] bool paused_for_body() const { return paused_for_body_; }
  void archive(Archive& archive);  ///< the state, for a snapshot

 private:
  std::int32_t priority_{0};
  std::optional<double> speed_mps_max_;
  bool no_orders_{false};
  bool stop_awaited_{false};
  bool excluded_{false};
  bool paused_for_body_{false};
};

}  // namespace cosiva::virtual_side
