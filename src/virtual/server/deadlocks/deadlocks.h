#pragma once

#include <cstdint>
#include <deque>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "cosiva/base/archive_fwd.h"
#include "cosiva/base/digest.h"
#include "cosiva/base/json_writer.h"
#include "cosiva/virtual/server/exchange/traces.h"
#include "cosiva/virtual/server/messages/message_publisher.h"
#include "cosiva/virtual/server/orders/order_manager.h"
#include "cosiva/virtual/server/orders/wait_graph.h"
#include "cosiva/virtual/server/registry/registry.h"

namespace cosiva::virtual_side {

struct DeadlockRules {
  /// Time that a cycle of waits must last to be a deadlock: pending messages may dissolve the cycle.
  SimDuration grace{std::chrono::seconds{2}};
  /// The same for a cycle with an off-path vehicle: the vehicle first tries other positions by itself.
  SimDuration off_path_grace{std::chrono::seconds{7}};
  SimDuration flicker{std::chrono::milliseconds{600}};  ///< a cycle that is open for less counts as closed throughout
  SimDuration calm{std::chrono::seconds{2}};  ///< without a cycle among its members for this time it is resolved
  SimDuration works_within{std::chrono::seconds{3}};  ///< otherwise the next means is tried
  SimDuration again_after{std::chrono::seconds{5}};   ///< when no means has helped
};

/// A cycle of vehicles that wait for each other, and its resolution.
struct Deadlock {
  enum class State : std::uint8_t {
    forming,     ///< the cycle has closed; most cycles dissolve by themselves
    reported,    ///< the cycle has lasted
    yielding,    ///< a vehicle yields to the others
    unresolved,  ///< no vehicle can yield; retried periodically
    resolved,
  };
  std::uint64_t number{};  ///< from 1, counting those that lasted; 0 while forming
  State state{State::forming};
  std::vector<VehicleIndex> members;  ///< ascending
  SimTime since{};                    ///< when the cycle closed
  SimTime closed_since{};             ///< closed without a break since then, or since a vehicle began to yield
  SimTime detected_at{};              ///< when the cycle was last closed
  std::string reason;                 ///< which vehicle waits for which and why, one sentence with commas
  std::string how;                    ///< the means that was applied last
  std::optional<SimTime> ended_at;
  std::vector<std::pair<VehicleIndex, Means>> tried;
  std::vector<VehicleIndex> yielded;
};
[[nodiscard]] std::string_view to_string(Deadlock::State state);

/// Detects deadlocks in the tick in which their cycle closes, describes them, and resolves them by this rule: the
/// member with the lowest priority yields, by the cheapest means that lets the others out (Means); of equal priorities
/// the vehicle with the cheapest means, then the vehicle that backs up the least, then the vehicle registered last. A
/// vehicle that cannot yield is skipped. When the cycle is still closed 3 s later, the next means is tried, then the
/// next member. When no means is left, the deadlock is logged as an error, and resolution is retried 5 s later.
///
/// Invariant: only cycles that lasted have a number and are listed; of these each ends once. No more deadlocks are
/// resolved than detected, and no more detected than cycles have closed.
class Deadlocks {
 public:
  Deadlocks(Registry& registry, MessagePublisher& publisher, Traces& traces, OrderManager& orders)
      : registry_{registry}, publisher_{publisher}, traces_{traces}, orders_{orders} {}

  /// To be called after OrderManager::tick().
  void tick();
  /// The zone was switched: all waits are void.
  void forget();

  struct Counters {
    std::uint64_t cycles{0};    ///< cycles that closed, however briefly
    std::uint64_t detected{0};  ///< cycles that lasted
    std::uint64_t resolved{0};
    SimDuration longest{};  ///< from the closing of the cycle to its end, of those that lasted
  };
  [[nodiscard]] const Counters& counters() const { return counters_; }
  /// The open deadlocks and the latest resolved ones, oldest first; without those that are forming.
  [[nodiscard]] const std::deque<Deadlock>& list() const { return list_; }
  [[nodiscard]] std::size_t unresolved() const;  ///< that no vehicle could resolve so far
  [[nodiscard]] std::size_t open() const;        ///< detected and not resolved
  /// {"cycles","detected","resolved","open","unresolved","longest_s","longest_wait_s"}: metrics only.
  void write_counters(JsonWriter& json) const;
  /// The same, and "list": [{"number","since_ms","state","members","reason","how","ended_ms"}…].
  void write(JsonWriter& json) const;
  /// Increases with every change that the HMI shows.
  [[nodiscard]] std::uint64_t revision() const { return revision_; }
  void fold(Digest& digest) const;
  void archive(Archive& archive);  ///< the state, for a snapshot

 private:
  static constexpr std::size_t kept_max = 20;  ///< of resolved deadlocks
  void record(const Knot& knot);
  [[nodiscard]] Deadlock* find(const std::vector<VehicleIndex>& members);
  [[nodiscard]] std::string describe(const Knot& knot) const;
  void follow(Deadlock& deadlock);
  void begin(Deadlock& deadlock);
  void resolve(Deadlock& deadlock);
  bool let_yield(Deadlock& deadlock, std::int32_t priority);
  void give_up(Deadlock& deadlock);
  void end(Deadlock& deadlock);
  void send(char level, const std::string& text);
  [[nodiscard]] std::vector<Wait> waits_for(const Deadlock& deadlock, VehicleIndex vehicle) const;
  [[nodiscard]] bool has_vehicle_off_path(const Deadlock& deadlock) const;

  Registry& registry_;
  MessagePublisher& publisher_;
  Traces& traces_;
  OrderManager& orders_;
  DeadlockRules rules_;
  WaitGraph graph_;
  std::deque<Deadlock> forming_;
  std::deque<Deadlock> list_;
  Counters counters_;
  std::uint64_t revision_{0};
};

}  // namespace cosiva::virtual_side
