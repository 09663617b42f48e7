#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "cosiva/aiv/onboard/boards_link.h"
#include "cosiva/aiv/onboard/drive_cycle.h"
#include "cosiva/aiv/onboard/driving_context.h"
#include "cosiva/aiv/onboard/position_store.h"
#include "cosiva/aiv/onboard/state_reporter.h"
#include "cosiva/aiv/onboard/zone_selection.h"
#include "cosiva/aiv/order/instant_actions.h"
#include "cosiva/aiv/order/order_actions.h"
#include "cosiva/aiv/partners/server_proxy.h"
#include "cosiva/aiv/partners/server_selection.h"
#include "cosiva/base/archive_fwd.h"
#include "cosiva/wire/runtime/core.h"

namespace cosiva::aiv {

/// Performs instant actions (VDA 5050 2.1 §6.8) and records their states. What arrives before a zone is known waits,
/// and is performed in the same order then: a restart that is given while the program starts must not be lost.
///
/// A stopPause that was sent before the last startPause is refused: the network has delayed it, and a Stop outranks it.
/// Senders' clocks may step back; so one that is older by more than `delay_max` is performed.
///
/// Invariant: after end_waits() cancelOrder, joinLine, backUp, move and selfTest run only while they are still
/// performed. At most InstantActionBook::shown_max actions wait for a zone.
class ActionExecutor {
 public:
  static constexpr SimDuration delay_max{std::chrono::seconds{10}};
  /// The other parts of the vehicle that actions act upon. All outlive the executor.
  struct Parts {
    ServerProxy& server_proxy;
    StateReporter& reporter;
    PositionStore& positions;
    DriveCycle& drive_cycle;
    const ZoneSelection& zones;
    const ServerSelection& server;
    BoardsLink& boards;
    OrderActions& order_actions;
  };
  explicit ActionExecutor(const Parts& parts) : parts_{parts} {}

  /// One instantActions message.
  /// @param context  none before a zone is known
  void on_message(SimTime now, std::string_view payload, DrivingContext* context, wire::Effects& effects);
  void on_first_zone(SimTime now, DrivingContext& context, wire::Effects& effects);
  /// Ends actions that waited until the vehicle has stopped or arrived.
  void end_waits(const VehicleState& vehicle);
  void on_new_order() { book_.on_new_order(); }
  /// No action outlasts a zone switch.
  void on_zone_switched();
  [[nodiscard]] const InstantActionBook& book() const { return book_; }
  void archive(Archive& archive);  ///< the state, for a snapshot

 private:
  struct Call {
    SimTime now;
    SimTime sent;  ///< the time stamp of its message
    const wire::Action& action;
    DrivingContext& context;
    wire::Effects& effects;
  };
  struct Waiting {
    wire::Action action;
    SimTime sent;
  };
  using Handler = void (ActionExecutor::*)(const Call&);
  /// The table of action types; none: not supported.
  [[nodiscard]] static Handler handler_of(std::string_view action_type);

  void perform(const wire::Action& action, SimTime now, SimTime sent, DrivingContext* context, wire::Effects& effects);
  void set(const wire::Action& action, wire::ActionStatus status, std::string result = {});
  void fail(const wire::Action& action, std::string type, std::string why, wire::Effects& effects);
  void fail(const Call& call, std::string why);
  /// Ends an action that runs, as soon as the vehicle no longer performs it.
  void end_wait(std::string_view action_type, bool reached, std::string_view failure = {});

  void start_pause(const Call& call);
  void stop_pause(const Call& call);
  void cancel_order(const Call& call);
  void init_position(const Call& call);
  void set_speed_limit(const Call& call);
  void enable_map(const Call& call);
  void join_line(const Call& call);
  void back_up(const Call& call);
  void move(const Call& call);
  void self_test(const Call& call);
  void request_factsheet(const Call& call);
  /// startCharging, stopCharging and trigger.
  void act_as_order(const Call& call);

  Parts parts_;
  InstantActionBook book_;
  std::vector<Waiting> waiting_;      ///< for a zone
  std::optional<SimTime> stop_sent_;  ///< the latest time stamp of a startPause
};

}  // namespace cosiva::aiv
