#pragma once

#include <cstddef>
#include <optional>

#include "cosiva/base/archive_fwd.h"
#include "cosiva/base/time.h"
#include "cosiva/zone/circuit/circuit.h"

namespace cosiva::virtual_side {

/// The entries of a vehicle in the simulator and in the bijection monitor.
///
/// Invariant: a vehicle keeps its twin and its monitored entity once it has them, and has a base only with a twin.
class TwinLink {
 public:
  /// A position and the state that names the tag of its correction are two messages.
  static constexpr SimDuration shift_kept{std::chrono::milliseconds{300}};

  /// The twin has appeared in the simulator. The vehicle had none (checked).
  void on_appeared(std::size_t twin);
  /// The monitor counts the vehicle as this entity. The vehicle had none (checked).
  void on_monitored(std::size_t entity);
  void on_present() { present_ = true; }
  void on_absent() { present_ = false; }
  /// @param end  of the base that the vehicle has reported; nothing: the vehicle has no base. With a twin (checked).
  void on_base(std::optional<zone::TrackPosition> end);
  /// A report is so much further from the one before than the vehicle can have driven. @param m  not negative (checked)
  void on_shift(SimTime now, double m);
  /// The vehicle returns after its retirement.
  void on_returned();

  [[nodiscard]] std::optional<std::size_t> twin() const { return twin_; }
  /// In the monitor; of a vehicle that the monitor counts (checked).
  [[nodiscard]] std::size_t entity() const;
  /// Physically: reported its position while online, or reported for some time without ONLINE.
  [[nodiscard]] bool present() const { return present_; }
  [[nodiscard]] const std::optional<zone::TrackPosition>& base_end() const { return base_end_; }
  /// The largest such distance of late, once; 0: none.
  [[nodiscard]] double take_shift_m(SimTime now);
  void archive(Archive& archive);  ///< the state, for a snapshot

 private:
  std::optional<std::size_t> twin_;
  std::optional<std::size_t> entity_;
  bool present_{false};
  std::optional<zone::TrackPosition> base_end_;
  std::optional<SimTime> shifted_at_;
  double shift_m_{0.0};
};

}  // namespace cosiva::virtual_side
