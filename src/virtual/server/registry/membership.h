#pragma once

#include <optional>

#include "cosiva/base/archive_fwd.h"
#include "cosiva/base/time.h"

namespace cosiva::virtual_side {

/// Whether a vehicle takes part in the table and the traffic of this server.
///
/// Invariant: a retired vehicle is neither handed over nor awaited, a departed one is retired, and the first
/// publication of a handover is not after the last one. The last message is not before the first one.
class Membership {
 public:
  /// The server has published that the vehicle belongs to another control area: nothing more is sent to the vehicle.
  struct HandedOver {
    SimTime first;
    SimTime last;  ///< published again until the server receives its own message back
  };
  /// A vehicle that was handed over is shown again after this time: the handover has not succeeded.
  static constexpr SimDuration comes_back_within{std::chrono::seconds{1}};

  explicit Membership(SimTime first_received) : first_received_{first_received}, last_received_{first_received} {}

  /// A message of the vehicle, of any kind, has been received. @param now  not before the last one (checked)
  void on_message(SimTime now);

  /// The vehicle leaves the table and the traffic; a vehicle of the same name may return.
  void on_retired();
  /// The vehicle has left the zone: its next report, and not another control area, brings the vehicle back.
  void on_departed();
  /// The server drives the vehicle from now on.
  void on_accepted() { retired_ = departed_ = false; }
  /// A server before a restart controlled the vehicle, and its report is awaited. The vehicle is not retired (checked).
  void on_awaited();
  /// The vehicle is awaited no longer.
  void on_awaited_end() { awaited_ = false; }
  /// The new owner has been published, for the first time or again.
  /// @param now  not before the last publication (checked); the vehicle is not retired (checked)
  void on_handed_over(SimTime now);
  /// The vehicle still belongs to this server.
  void on_handover_void() { handed_over_.reset(); }

  [[nodiscard]] SimTime first_received() const { return first_received_; }
  [[nodiscard]] SimTime last_received() const { return last_received_; }
  [[nodiscard]] bool retired() const { return retired_; }
  [[nodiscard]] bool departed() const { return departed_; }
  [[nodiscard]] bool awaited() const { return awaited_; }
  [[nodiscard]] const std::optional<HandedOver>& handed_over() const { return handed_over_; }
  /// A vehicle that is being handed over is not shown, so that no two control areas show the vehicle at once.
  [[nodiscard]] bool hidden_by_handover(SimTime now) const {
    return handed_over_ && now - handed_over_->first < comes_back_within;
  }
  void archive(Archive& archive);  ///< the state, for a snapshot

 private:
  SimTime first_received_;
  SimTime last_received_;
  bool retired_{false};
  bool departed_{false};
  bool awaited_{false};
  std::optional<HandedOver> handed_over_;
};

}  // namespace cosiva::virtual_side
