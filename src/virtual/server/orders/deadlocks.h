#pragma once

#include <cstdint>
#include <deque>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "cosiva/base/digest.h"
#include "cosiva/base/json_writer.h"
#include "cosiva/virtual/server/messages/message_publisher.h"
#include "cosiva/virtual/server/messages/traces.h"
#include "cosiva/virtual/server/orders/order_manager.h"
#include "cosiva/virtual/server/orders/wait_graph.h"
#include "cosiva/virtual/server/registry/proxy.h"

namespace cosiva::virtual_side {

struct DeadlockRules {
  /// So long a ring of waits must last to be a deadlock: messages are under way, and what they tell may undo it.
  SimDuration grace{std::chrono::seconds{2}};
  /// With somebody beside the line in it: the places that it tries by itself come first.
  SimDuration off_path_grace{std::chrono::seconds{7}};
  SimDuration flicker{std::chrono::milliseconds{600}};  ///< a ring that is away for less has been there all the time
  SimDuration calm{std::chrono::seconds{2}};            ///< without a ring among its members it is over
  SimDuration works_within{std::chrono::seconds{3}};    ///< else the next means is tried
  SimDuration again_after{std::chrono::seconds{5}};     ///< when nothing has helped
};

/// A ring of vehicles that wait for each other, and what became of it.
struct Deadlock {
  enum class State : std::uint8_t {
    forming,     ///< the ring has closed; most open again by themselves
    reported,    ///< it has lasted
    yielding,    ///< somebody lets the others out
    unresolved,  ///< nobody can; tried again and again
    resolved,
  };
  std::uint64_t number{};  ///< from 1, of those that lasted; 0 while it forms
  State state{State::forming};
  std::vector<VehicleIndex> members;  ///< ascending
  SimTime since{};                    ///< the ring closed
  SimTime closed_since{};             ///< it is closed without a break, or since somebody began to give way
  SimTime detected_at{};              ///< closed
  std::string reason;                 ///< who waits for whom and why, one sentence with commas
  std::string how;                    ///< what was done, the last means last
  std::optional<SimTime> ended_at;
  std::vector<std::pair<VehicleIndex, Means>> tried;
  std::vector<VehicleIndex> yielded;
};
[[nodiscard]] std::string_view to_string(Deadlock::State state);

/// Finds deadlocks in the tick in which their ring closes, names them, and has them resolved by the stated rule: of the
/// members the one with the lowest priority gives way, by the cheapest means that will let the others out (Means); of
/// equals the one with the cheapest means, then the one that comes less far back, then the one registered last. Who
/// cannot give way is passed over. When the ring is still closed 3 s later, the next means is tried, then the next
/// member. When nothing is left, it is told loudly, and tried again 5 s later.
class Deadlocks {
 public:
  Deadlocks(Registry& registry, MessagePublisher& publisher, Traces& traces, OrderManager& orders)
      : registry_{registry}, publisher_{publisher}, traces_{traces}, orders_{orders} {}

  /// After the roller's tick.
  void tick();
  /// Another zone: everybody waits for something else.
  void forget();

  struct Counters {
    std::uint64_t cycles{0};    ///< closed, however briefly
    std::uint64_t detected{0};  ///< lasted
    std::uint64_t resolved{0};
    SimDuration longest{};  ///< from the ring's closing to its end, of those that lasted
  };
  [[nodiscard]] const Counters& counters() const { return counters_; }
  /// Those that last, and the last ones that are over; oldest first. Without those that form.
  [[nodiscard]] const std::deque<Deadlock>& list() const { return list_; }
  [[nodiscard]] std::size_t unresolved() const;  ///< that nobody could resolve so far
  [[nodiscard]] std::size_t open() const;        ///< that last
  /// {"rings","detected","resolved","open","unresolved","longest_s","longest_wait_s"}: figures alone.
  void write_counters(JsonWriter& json) const;
  /// The same, and "list": [{"number","since_ms","state","members","reason","how","ended_ms"}…].
  void write(JsonWriter& json) const;
  /// Grows with everything that a page shows of them.
  [[nodiscard]] std::uint64_t revision() const { return revision_; }
  void fold(Digest& digest) const;

 private:
  static constexpr std::size_t kept_max = 20;  ///< of those that are over
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
