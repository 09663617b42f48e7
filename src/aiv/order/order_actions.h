#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "cosiva/aiv/order/action_catalogue.h"
#include "cosiva/aiv/order/load_bay.h"
#include "cosiva/base/archive_fwd.h"
#include "cosiva/base/time.h"
#include "cosiva/wire/messages/messages.h"

namespace cosiva::aiv {

/// The actions of the order at its nodes and on its edges, from the order's acceptance to the next order: when each is
/// triggered (VDA 5050 2.1 §6.10.2), which run at the same time (§6.12), their states (§6.11), and their effects on
/// loads and battery. The actions themselves take their time and no more.
///
/// Invariant: actions are in the order of nodes and edges; while a HARD action is performed, no other action is.
class OrderActions {
 public:
  /// Ended states beyond this number are left out, oldest first: an order that is extended for ever stays bounded.
  static constexpr std::size_t shown_max = 256;

  /// An action that failed by itself, for the state's errors.
  struct Failure {
    wire::Action action;
    std::string node_or_edge_id;
    bool on_edge{};
    std::string why;
  };
  /// What the vehicle does at present.
  struct Conditions {
    SimTime now;
    bool stopped;
    bool paused;         ///< by startPause
    double travelled_m;  ///< by the vehicle's odometer
  };

  explicit OrderActions(ActionCatalogue catalogue);

  // The order. OrderBook has accepted it: the vehicle supports all actions.
  void on_new_order(const wire::Order& order);
  /// The actions of the horizon are replaced, those of the base and of the stitching node stay.
  void on_update(const wire::Order& order);
  /// The vehicle has traversed this node: leaves the edge before it, and triggers the node's actions.
  void on_traversed(std::uint32_t sequence_id);
  /// The order is cancelled or dropped: no action is continued or begun any more.
  void cancel(std::string_view why);

  /// Lets the time pass since the last call, and begins what may begin now.
  void update(const Conditions& conditions);
  /// The trigger of waitForTrigger. False: no action waits for it.
  /// @param type  as parameter triggerType; empty: every type
  [[nodiscard]] bool trigger(std::string_view type);
  void set_charging(bool charging);
  /// What was on board before the program restarted.
  void restore_loads(const std::vector<wire::Load>& loads) { loads_.restore(loads); }

  /// Some action has not ended.
  [[nodiscard]] bool left() const;
  /// A SOFT or HARD action is performed: the vehicle must not move.
  [[nodiscard]] bool holds_vehicle() const;
  /// A SOFT or HARD action is triggered and has not ended: the vehicle goes no further than here.
  [[nodiscard]] bool keep_here() const;
  [[nodiscard]] bool charging() const { return charging_; }
  [[nodiscard]] const LoadBay& loads() const { return loads_; }
  [[nodiscard]] std::vector<wire::ActionState> states() const;
  /// Whether a state, the loads or the charging has changed since the last call.
  [[nodiscard]] bool take_changed();
  [[nodiscard]] std::vector<Failure> take_failures();
  void archive(Archive& archive);  ///< the state, for a snapshot

 private:
  struct Entry {
    wire::Action action;
    std::string node_or_edge_id;
    std::uint32_t sequence_id{};  ///< nodes have even ones
    bool released{};
    wire::ActionStatus status{wire::ActionStatus::waiting};
    bool preparing{};    ///< INITIALIZING, or paused in it
    SimDuration left{};  ///< of the preparation or of the action
    std::string result{};
  };

  void append(const wire::Order& order, std::size_t first_node);
  [[nodiscard]] bool triggered(const Entry& entry) const;
  void pass_time(Entry& entry, SimDuration step, bool paused);
  void begin_next(const Conditions& conditions);
  void begin_running(Entry& entry);
  void complete(Entry& entry);
  void fail(Entry& entry, std::string why);
  void set(Entry& entry, wire::ActionStatus status, std::string result = {});

  ActionCatalogue catalogue_;
  LoadBay loads_;
  std::vector<Entry> entries_;
  std::optional<std::uint32_t> reached_;  ///< sequence number of the node traversed last; nothing: no order
  std::optional<SimTime> updated_at_;
  bool charging_{false};
  std::optional<double> charged_at_m_;  ///< on the odometer, where it began; nothing before update()
  bool changed_{false};
  std::vector<Failure> failures_;  ///< not taken yet
};

}  // namespace cosiva::aiv
