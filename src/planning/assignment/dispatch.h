#pragma once

#include <cstdint>
#include <limits>
#include <span>
#include <vector>

#include "cosiva/base/random.h"
#include "cosiva/planning/floor/distances.h"
#include "cosiva/planning/window/itinerary.h"

namespace cosiva::planning {

/// A load that waits to be transported.
struct OpenOrder {
  std::uint64_t id{};  ///< the same in each call; no two open orders have the same
  Stop pick_up;
  Stop delivery;
  std::uint32_t priority{0};  ///< 0 is the usual one; each level makes a step of waiting cost as much as 16 do
  std::uint32_t age{0};       ///< steps since the order was accepted
};

/// A vehicle as the dispatcher sees it.
struct Carrier {
  StateId at{};
  std::vector<Stop> stops;  ///< that it has to finish before it can take an order, such as the delivery of its load
  bool available{true};     ///< false: takes no orders, for example while it charges
};

struct DispatchOptions {
  std::uint32_t orders_max = 1000;       ///< considered at once, those of the highest priority and age first
  std::uint32_t exchanges_max = 20'000;  ///< attempts at a better plan per call
  /// A step of waiting for the pick-up costs `waiting_cost`, and the end of a tour its square: that keeps the last
  /// vehicle from finishing long after the others, and with few orders is like the waiting alone.
  std::uint32_t waiting_cost = 10;
};

/// Plans for each vehicle a tour of open orders, of which the first one is its next. Tours are planned again in each
/// call, so that an order can be given to another vehicle until it is picked up, and vehicles that still deliver a load
/// are considered by the time at which they become free. Tours are those of the call before, with new orders inserted
/// where they cost least, and improved by exchanges between two tours (relocation, swap, exchange of tails) as long as
/// those reduce the cost. With no more orders than vehicles, tours of one order each are tried as well, by
/// least_cost_assignment.
///
/// Distances are those on the empty floor. Same calls and seed: same tours.
///
/// Invariant: each considered order that some available vehicle can carry is in exactly one tour, exactly once.
class Dispatch {
 public:
  static constexpr std::size_t none = std::numeric_limits<std::size_t>::max();

  /// @param floor, distances  must outlive this object; `distances` has room for the tables of all orders considered
  Dispatch(const Floor& floor, Distances& distances, const DispatchOptions& options, std::uint64_t seed);

  void plan(std::span<const Carrier> carriers, std::span<const OpenOrder> orders);

  /// Indices of orders of the last call, in the sequence in which the vehicle is to carry them.
  [[nodiscard]] std::span<const std::size_t> tour(std::size_t carrier) const noexcept { return tours_[carrier]; }
  [[nodiscard]] std::size_t next(std::size_t carrier) const noexcept {
    return tours_[carrier].empty() ? none : tours_[carrier].front();
  }
  /// Steps until a vehicle has finished its stops and its tour.
  [[nodiscard]] std::uint32_t busy_for(std::size_t carrier) const { return cost(carrier, tours_[carrier]).end; }

 private:
  using Tour = std::vector<std::size_t>;

  /// An order with what the search needs.
  struct Leg {
    const Distances::Steps* to_pick_up{};
    std::span<const StateId> delivery;
    std::uint32_t duration{};  // from the arrival at the pick-up to the end of the delivery
    std::uint64_t waiting_cost{};
  };
  struct Start {
    StateId state{};
    GoalId goal{no_goal};  // where the vehicle becomes free, if not in its present state
    std::uint32_t free_in{};
    bool available{};
  };
  struct TourCost {
    std::uint64_t cost{};
    std::uint32_t end{};
  };
  /// Before the order with this index, or at the end of a tour.
  struct Position {
    std::size_t carrier{};
    std::size_t index{};
  };

  void accept(std::span<const Carrier> carriers, std::span<const OpenOrder> orders);
  [[nodiscard]] Start start_of(const Carrier& carrier);
  /// False: the delivery cannot be reached from the pick-up.
  [[nodiscard]] bool make_leg(const OpenOrder& order, Leg& leg);
  void adopt_tours(std::span<const OpenOrder> orders);
  void insert(std::size_t order);
  void assign_singly();
  [[nodiscard]] TourCost cost(std::size_t carrier, std::span<const std::size_t> tour) const;
  void exchange();
  [[nodiscard]] std::size_t some_order();
  /// Of an order of a vehicle that finishes late; none, if it has no orders.
  [[nodiscard]] Position position_of_late();
  /// After an order whose delivery is near the pick-up of the order at `a`, or at one of the ends of a tour.
  [[nodiscard]] Position position_after_near(Position a);
  void try_exchange(Position a, Position b, std::uint64_t kind);
  void try_within(Position a, Position b);
  void set_tour(std::size_t carrier, const Tour& tour);

  const Floor* floor_;
  Distances* distances_;
  DispatchOptions options_;
  Random random_;
  std::vector<Start> starts_;                    // by carrier
  std::vector<Leg> legs_;                        // by order
  std::vector<std::size_t> considered_;          // orders
  std::vector<Tour> tours_;                      // by carrier
  std::vector<std::uint64_t> costs_;             // by carrier: of its tour
  std::vector<std::vector<std::uint64_t>> ids_;  // by carrier: the orders of its tour, for the next call
  std::vector<Position> positions_;              // by order
  Tour first_, second_;                          // of an attempt
};

}  // namespace cosiva::planning
