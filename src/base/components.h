#pragma once

#include <algorithm>
#include <cstdint>
#include <span>
#include <utility>
#include <vector>

namespace cosiva {

/// Strongly connected components of a directed graph (Tarjan 1972): vertices that can all be reached from each other. A
/// reused object allocates nothing.
class StrongComponents {
 public:
  /// In time linear in vertices and edges, with a stack depth independent of the length of paths.
  /// @param count  vertices are 0 … count − 1
  /// @param next   next(vertex) is an indexable range of the vertices that its edges lead to, the same at every call
  template <class Next>
  void find(std::size_t count, const Next& next) {
    visits_.assign(count, {});
    component_.assign(count, 0);
    members_.clear();
    first_.assign(1, 0);
    visited_ = 0;
    for (std::uint32_t v = 0; v < count; ++v)
      if (visits_[v].order == 0) visit_from(v, next);
  }

  /// Each vertex is in one component; components that are led to precede those that lead to them.
  [[nodiscard]] std::size_t size() const { return first_.size() - 1; }
  /// Ascending.
  [[nodiscard]] std::span<const std::uint32_t> members(std::size_t component) const {
    return std::span{members_}.subspan(first_[component], first_[component + 1] - first_[component]);
  }
  [[nodiscard]] std::uint32_t component_of(std::uint32_t vertex) const { return component_[vertex]; }

 private:
  struct Visit {
    std::uint32_t order{0};  ///< of the first visit, from 1; 0: not visited
    std::uint32_t low{0};    ///< the earliest vertex that it leads back to
    bool open{false};        ///< its component is not complete yet
  };

  template <class Next>
  void visit_from(std::uint32_t root, const Next& next) {
    come_to(root);
    while (!trail_.empty()) {
      const auto [v, at] = trail_.back();
      const auto& edges = next(v);
      if (at < std::size(edges)) {
        ++trail_.back().second;
        const std::uint32_t to = edges[at];
        if (visits_[to].order == 0)
          come_to(to);
        else if (visits_[to].open)
          visits_[v].low = std::min(visits_[v].low, visits_[to].order);
        continue;
      }
      trail_.pop_back();
      if (!trail_.empty()) {
        Visit& from = visits_[trail_.back().first];
        from.low = std::min(from.low, visits_[v].low);
      }
      if (visits_[v].low == visits_[v].order) close(v);
    }
  }

  void come_to(std::uint32_t v) {
    ++visited_;
    visits_[v] = {visited_, visited_, true};
    open_.push_back(v);
    trail_.emplace_back(v, 0);
  }

  void close(std::uint32_t root) {
    const auto component = static_cast<std::uint32_t>(size());
    for (std::uint32_t member = root + 1; member != root;) {
      member = open_.back();
      open_.pop_back();
      visits_[member].open = false;
      component_[member] = component;
      members_.push_back(member);
    }
    std::sort(members_.begin() + static_cast<std::ptrdiff_t>(first_.back()), members_.end());
    first_.push_back(members_.size());
  }

  std::vector<Visit> visits_;
  std::vector<std::uint32_t> open_;                           ///< visited, and not in a component yet
  std::vector<std::pair<std::uint32_t, std::size_t>> trail_;  ///< the search's explicit stack: vertex and index of the
                                                              ///< edge
  std::vector<std::uint32_t> component_;
  std::vector<std::uint32_t> members_;  ///< of all components, one after another
  std::vector<std::size_t> first_{0};   ///< of each component, and one behind the last
  std::uint32_t visited_{0};
};

}  // namespace cosiva
