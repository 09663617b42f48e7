#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <utility>
#include <vector>

#include "cosiva/base/archive_fwd.h"
#include "cosiva/base/pose.h"
#include "cosiva/base/time.h"
#include "cosiva/virtual/server/messages/message_publisher.h"
#include "cosiva/virtual/server/orders/line_join.h"
#include "cosiva/virtual/server/orders/order_context.h"
#include "cosiva/virtual/server/orders/order_session.h"
#include "cosiva/virtual/server/orders/path_positions.h"
#include "cosiva/virtual/server/orders/wait_graph.h"
#include "cosiva/virtual/server/orders/wait_records.h"
#include "cosiva/virtual/server/registry/proxy.h"

namespace cosiva::virtual_side {

/// The means by which a vehicle lets others out of a deadlock, the cheapest first.
enum class Means : std::uint8_t {
  move_up,  ///< closes up to its leader as far as its obstacle sensor permits, so that its follower leaves a crossing
  wait,     ///< releases what it requested and holds ahead, and lets the others go first
  detour,   ///< takes another route
  other_position,  ///< joins the path at another position
  back_up,         ///< drives backwards along the path, and lets the others go first
};

/// One vehicle lets others out of a deadlock. The vehicle moves up, releases what it holds ahead, takes another route,
/// joins the path at another position, or backs up.
///
/// Invariant: a vehicle that backs up drops its order first.
class Yielding {
 public:
  Yielding(OrderContext& context, std::vector<OrderSession>& sessions, const PathPositions& positions, LineJoin& joins,
           const WaitRecords& waits)
      : context_{context}, sessions_{sessions}, positions_{positions}, joins_{joins}, waits_{waits} {}

  void resize(std::size_t vehicles) { vehicles_.resize(vehicles); }
  void forget(VehicleIndex vehicle) { vehicles_[vehicle] = {}; }

  /// The cost of yielding so that `waits`, all of which are for this vehicle, end: the distance to back up [m], 0 for
  /// all other means. Nothing: the vehicle cannot yield by `means`.
  [[nodiscard]] std::optional<double> can_yield(VehicleIndex vehicle, Means means, std::span<const Wait> waits) const;
  /// False: the means could not be applied.
  bool yield(VehicleIndex vehicle, Means means, std::span<const Wait> waits);
  /// The vehicle is stopped for others, or is backing up for them.
  [[nodiscard]] bool yields(VehicleIndex vehicle) const { return vehicles_[vehicle].stop.has_value(); }
  /// True while the vehicle has to remain stopped.
  [[nodiscard]] bool continue_yielding(VehicleIndex vehicle);
  void end(VehicleIndex vehicle);
  /// The next stretch may end nearer to the leader than the gap.
  [[nodiscard]] bool moves_up(VehicleIndex vehicle) const { return vehicles_[vehicle].moves_up; }
  void end_moving_up(VehicleIndex vehicle) { vehicles_[vehicle].moves_up = false; }
  void archive(Archive& archive);  ///< the state, for a snapshot

 private:
  struct Stop {
    SimTime until{};
    std::vector<std::pair<VehicleIndex, Point2>> others;  ///< the other vehicles, and their positions at the start
    bool drops_order{false};
    double back_m{0.0};                           ///< 0: does not back up
    InstantActionSender::ActionHandle handle{0};  ///< of its backUp; 0: not sent yet
    double clear_m{0.0};                          ///< stops when any body is nearer
    bool stopped{false};                          ///< while backing up, as a body came near
  };
  struct Vehicle {
    std::optional<Stop> stop;
    bool moves_up{false};
  };
  /// Whether the body of `wait.blocker` would still obstruct `wait.waiter` if it were stopped at `position`.
  [[nodiscard]] bool keeps_off(const Wait& wait, zone::TrackPosition position) const;
  /// By closing up to its leader the vehicle lets its follower out of a crossing that another vehicle waits for.
  [[nodiscard]] bool makes_room_by_moving_up(VehicleIndex vehicle, std::span<const Wait> waits) const;
  [[nodiscard]] bool has_what_to_give_back(VehicleIndex vehicle) const;
  /// The sections that a detour has to avoid; empty: there is nothing to avoid.
  [[nodiscard]] std::vector<zone::SectionId> contested(VehicleIndex vehicle) const;
  [[nodiscard]] std::optional<double> distance_back_m(VehicleIndex vehicle, std::span<const Wait> waits) const;
  /// Whether the vehicle may back up this far: no vehicle is there, and none approaches.
  [[nodiscard]] bool is_free_behind(VehicleIndex vehicle, double back_m) const;
  [[nodiscard]] bool near_anything(VehicleIndex vehicle, const Pose2& X_MB, double clear_m) const;
  void follow_back_up(VehicleIndex vehicle, Stop& stop);
  [[nodiscard]] InstantActionSender::ActionHandle send_back_up(VehicleIndex vehicle, double distance_m);

  OrderContext& context_;
  std::vector<OrderSession>& sessions_;
  const PathPositions& positions_;
  LineJoin& joins_;
  const WaitRecords& waits_;
  std::vector<Vehicle> vehicles_;
};

}  // namespace cosiva::virtual_side
