#pragma once

#include <chrono>
#include <cstddef>

#include "cosiva/base/time.h"

namespace cosiva::virtual_side {

/// The parameters of order management.
struct OrderRules {
  double base_reach_m{1.2};  ///< a base is extended until it reaches this far from the vehicle
  std::size_t horizon{4};    ///< nodes announced beyond the base
  std::size_t base_nodes_max{16};
  double deviation_m{0.10};   ///< allowedDeviationXY of every node but the first of a new order
  double arrived_m{0.06};     ///< a vehicle stopped nearer than this to its goal has arrived; past it, `deviation_m`
  double on_circuit_m{0.30};  ///< a vehicle further from the circuit gets no orders
  double on_path_m{0.20};     ///< a vehicle nearer than this to the circuit obstructs others
  SimDuration resend_after{std::chrono::milliseconds{300}};
  SimDuration update_period{std::chrono::milliseconds{200}};
  SimDuration after_refusal{std::chrono::seconds{2}};
  SimDuration let_in_for{std::chrono::seconds{5}};  ///< a vehicle that waits off the path
  SimDuration other_position_after{std::chrono::seconds{1}};
  SimDuration make_room_after{std::chrono::seconds{4}};  ///< then joins the path even where it cannot continue
  SimDuration join_timeout{std::chrono::seconds{15}};
  SimDuration cancel_again{std::chrono::seconds{5}};
  SimDuration unresponsive_for{std::chrono::seconds{12}};  ///< a CoSiVA vehicle stopped with base ahead for no reason
  SimDuration yield_time_max{std::chrono::seconds{12}};    ///< at most
  double others_left_m{0.5};                               ///< continues when the others have moved this far
  double back_up_m_max{0.5};
  /// The longest time that a third-party vehicle may drive on after its last report (BaseReach); 0: not limited.
  SimDuration permitted_time{std::chrono::seconds{2}};
};

}  // namespace cosiva::virtual_side
