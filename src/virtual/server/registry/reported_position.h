#pragma once

#include <optional>
#include <string>

#include "cosiva/base/archive_fwd.h"
#include "cosiva/base/pose.h"
#include "cosiva/base/time.h"

namespace cosiva::virtual_side {

/// The position that a vehicle last reported, and since when the vehicle has lost it.
///
/// Invariant: a known position has a pose, is not lost at the same time, and was not overtaken by an older one within
/// its session.
class ReportedPosition {
 public:
  /// Of a position's time stamp, compared with the last one of this session.
  enum class Order {
    newer,      ///< or the vehicle's clock was set
    same,       ///< state and visualization of one instant contain the same position
    overtaken,  ///< an older one must not move the twin back
  };
  [[nodiscard]] Order order_of(SimTime stamp) const;
  static constexpr double coordinate_m_max = 1e5;
  /// False: more than 100 km away, or no number.
  [[nodiscard]] static bool plausible(const Pose2& pose);

  /// @param stamp  on the vehicle's own clock, newer than the last one (checked, also below)
  /// @param pose   plausible (checked)
  void on_position(SimTime stamp, std::string map_id, const Pose2& pose);
  /// The vehicle reports that it does not know its position.
  void on_lost(SimTime stamp, std::string map_id, SimTime now);
  /// The vehicle reports a position that is not plausible: what was known stays.
  void on_implausible(SimTime stamp, std::string map_id);
  /// The previous control area has handed over the vehicle's last pose (plausible, checked).
  void on_handover(const Pose2& pose);
  /// A session begins: time stamps may start again, and the vehicle has not reported its present position yet.
  void on_session();
  void on_retired() { lost_since_.reset(); }
  /// The server has sent the vehicle its last known position. There is one (checked).
  void on_initialisation_sent(SimTime now);

  [[nodiscard]] const std::optional<Pose2>& pose() const { return pose_; }  ///< the last one, even when it is lost
  [[nodiscard]] const std::string& map_id() const { return map_id_; }       ///< empty: not reported
  [[nodiscard]] bool known() const { return known_; }
  [[nodiscard]] bool lost_for_longer_than(SimDuration time, SimTime now) const {
    return lost_since_ && now - *lost_since_ > time;
  }
  [[nodiscard]] bool initialised_within(SimDuration time, SimTime now) const {
    return initialisation_sent_at_ && now - *initialisation_sent_at_ < time;
  }
  void archive(Archive& archive);  ///< the state, for a snapshot

 private:
  void take(SimTime stamp, std::string map_id);
  void know(const Pose2& pose);

  std::optional<SimTime> stamp_;  ///< of the last position, on the vehicle's own clock
  std::optional<Pose2> pose_;
  std::string map_id_;
  bool known_{false};
  std::optional<SimTime> lost_since_;
  std::optional<SimTime> initialisation_sent_at_;
};

}  // namespace cosiva::virtual_side
