#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "cosiva/base/archive_fwd.h"
#include "cosiva/planning/window/itinerary.h"
#include "cosiva/planning/window/reservations.h"

namespace cosiva::planning {

/// Finds the best path of one vehicle through a window of steps among the paths of the others: A* over states, steps
/// and stops, with the distances on the empty floor as the bound (Silver 2005).
///
/// Invariant: a node was examined in the present search if its stamp is `search_`.
class PathSearch {
 public:
  /// @param floor  must outlive this object
  PathSearch(const Floor& floor, std::uint32_t horizon);

  /// The path of least cost (Itinerary::cost) that contradicts no path of other vehicles; among equal ones one that
  /// moves early. A vehicle without stops takes the least moves.
  /// @param limit  only paths of less cost than this are searched for
  /// @param path   horizon + 1 states; unchanged when false is returned: there is no such path
  [[nodiscard]] bool find(Vehicle vehicle, StateId at, const Itinerary& itinerary, const Reservations& reservations,
                          std::uint32_t limit, std::span<StateId> path);

  /// Nodes examined since the search was made.
  [[nodiscard]] std::uint64_t expansions() const noexcept { return expansions_; }
  void archive(Archive& archive);  ///< the state, for a snapshot

 private:
  static constexpr std::uint32_t legs_max = 4;  // of one window; later ones count by their distance alone

  struct Node {
    std::uint32_t parent{};
    std::uint32_t cost{};
    StateId state{};
    std::uint32_t step{};
    Itinerary::Progress progress;
    bool is_first{};  // of the nodes with its state, step and leg; otherwise that is open
  };

  void begin(std::uint32_t limit, std::uint32_t least);
  void add(const Node& node);
  /// True once in a search for nodes with the same state, step and leg.
  [[nodiscard]] bool is_first(const Node& node);
  [[nodiscard]] std::uint32_t cost_after(const Node& node, StateId to, const Itinerary& itinerary,
                                         Itinerary::Progress& progress) const;
  void expand(std::uint32_t index, Vehicle vehicle, const Itinerary& itinerary, const Reservations& reservations);
  void trace(std::uint32_t index, std::span<StateId> path) const;

  const Floor* floor_;
  std::uint32_t horizon_;
  std::uint32_t search_{0};
  std::uint32_t limit_{0};
  std::uint32_t least_{0};
  std::uint64_t expansions_{0};
  std::vector<std::uint32_t> stamps_;                // (horizon + 1) × states × (legs_max + 1)
  std::vector<Node> nodes_;                          // of the present search
  std::vector<std::vector<std::uint32_t>> by_cost_;  // nodes to be examined, by cost above the least possible one
};

}  // namespace cosiva::planning
