#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "aiv/agent.h"
#include "aiv/felt_world.h"
#include "aiv/intent.h"
#include "aiv/neighbours.h"
#include "aiv/onboard/boards_link.h"
#include "aiv/onboard/estimating.h"
#include "aiv/onboard/instant_actions.h"
#include "aiv/onboard/memory.h"
#include "aiv/onboard/onboard_core.h"
#include "aiv/onboard/report.h"
#include "aiv/onboard/session.h"
#include "aiv/onboard/supervision.h"
#include "aiv/onboard/warnings.h"
#include "aiv/sighting.h"
#include "wire/halls.h"
#include "wire/own_messages.h"

namespace cosiva::aiv {

inline constexpr SimDuration usual_cycle = std::chrono::milliseconds{20};
inline constexpr SimDuration beat_period = std::chrono::milliseconds{100};
inline constexpr SimDuration remember_period = std::chrono::milliseconds{100};
inline constexpr SimDuration display_period = std::chrono::milliseconds{500};
inline constexpr SimDuration boards_report_period = std::chrono::milliseconds{500};
/// Events that come together travel in one state (§6.10: not faster than the factsheet's minStateInterval).
inline constexpr SimDuration state_interval_min = std::chrono::milliseconds{50};
/// Longer than a board takes to answer, and than RALI takes between two readings.
inline constexpr SimDuration waking_max = std::chrono::milliseconds{700};

/// Says when something periodic is due; a clock that jumped does not bring a burst.
class Periodic {
 public:
  explicit Periodic(SimDuration period) : period_{period} {}
  [[nodiscard]] bool take(SimTime now) {
    if (next_ && now < *next_ && *next_ - now <= period_) return false;
    next_ = next_ && now - *next_ < period_ ? *next_ + period_ : now + period_;
    return true;
  }

 private:
  SimDuration period_;
  std::optional<SimTime> next_;
};

/// Everything behind OnboardCore: what it is told goes to agent and books, and what they decide goes out. Its functions
/// stand in onboard_core.cpp (inputs and own pace), broker_side.cpp (messages), zone_switch.cpp (which zone is in
/// force), feeling.cpp (what is only virtual, and what it sees), v2x.cpp (what it says to others, and hears of them),
/// hall.cpp (whose it is), place.cpp (where it stands) and estimation_side.cpp (algorithms that are qualified).
struct OnboardCore::Inside {
  explicit Inside(OnboardOptions o)
      : options{std::move(o)},
        boards{options.number},
        supervision{options.link_timeout},
        session{options.id, options.interface_name, options.as_values},
        beat{beat_period},
        visualize{options.visualization_period},
        remember{remember_period},
        display{display_period},
        report_boards{boards_report_period} {}

  // what it is told
  void on_configure(wire::Effects& effects);
  void on_recall(const wire::Input& input, wire::Effects& effects);
  void on_link(const wire::Input& input, wire::Effects& effects);
  void on_port(const wire::Input& input);
  void on_bytes(const wire::Input& input, wire::Effects& effects);
  void on_message(const wire::Input& input, wire::Effects& effects);

  // from the boards
  void on_board(const wire::Hello& hello);
  void on_board(const wire::Odometry& odometry);
  void on_board(const wire::TagRead& tag);
  void on_board(const wire::Ranges& reading);
  void on_board(const wire::Power& reading);
  void on_board(const wire::Heartbeat&) {}
  // A board does not speak these; whoever sends them is no danger.
  void on_board(const wire::Drive&) {}
  void on_board(const wire::Display&) {}

  // from the broker
  void on_server_connection(const wire::Input& input, wire::Effects& effects);
  void on_order(const wire::Input& input, wire::Effects& effects);
  void refuse(std::string type, std::string_view topic, std::string why, std::vector<wire::Reference> references,
              wire::Effects& effects);
  void on_instant_actions(const wire::Input& input, wire::Effects& effects);

  // whose it is
  void on_owner(const wire::Input& input, wire::Effects& effects);
  /// To all that it hears besides its subscriptions.
  void listen(wire::Effects& effects) const;

  // which zone is in force
  void on_zone(const wire::Input& input, wire::Effects& effects);
  void use_zone(zone::ZoneConfiguration configuration, wire::Effects& effects);
  void refuse_zone(const Error& error, char level, wire::Effects& effects);
  /// The same ways with other tags or beacons: in force at once, whatever it is doing.
  void take_over_marks(const zone::Rtm& edited, wire::Effects& effects);
  /// It brakes on the zone in force, and takes the other as soon as it stands.
  void begin_switch(zone::Rtm rtm, wire::Effects& effects);
  void call_off_switch(wire::Effects& effects);
  void end_switch(wire::Effects& effects);
  [[nodiscard]] std::unique_ptr<SpeedChooser> chooser_for(const zone::TrafficZone& in) const;
  void note_maps();
  void enable_map(const wire::Action& action, wire::Effects& effects);

  // what it feels and sees
  void on_ahead(const wire::Input& input, wire::Effects& effects);
  /// One line in the log per kind of fault: a server that errs does so ten times a second.
  void complain_of_ahead(std::string kind, std::string_view why, wire::Effects& effects);
  /// Decides on everything it knows now, and tells the motors.
  void drive(wire::Effects& effects);
  /// Says what the last Ahead did.
  void tell_felt(wire::Effects& effects);
  void tell_seen(wire::Effects& effects);

  // talk with those near
  void on_intent(const wire::Input& input, wire::Effects& effects);
  /// One line in the log per kind of fault.
  void complain_of_v2x(std::string kind, std::string_view topic, std::string_view why, wire::Effects& effects);
  void listen_around(wire::Effects& effects);
  [[nodiscard]] Others look_around();
  void tell_intent(wire::Effects& effects);

  // algorithms that somebody qualifies
  void on_estimate_request(const wire::Input& input, wire::Effects& effects);
  [[nodiscard]] std::optional<Estimating::Belief> belief() const;
  /// Odometry, to the agent and to them.
  void roll(const wire::Odometry& odometry);
  void tell_estimate(wire::Effects& effects);

  // instant actions
  void finish(const wire::Action& action, std::string result = {}) {
    actions.set(action.action_id, wire::ActionStatus::finished, std::move(result));
  }
  void give_up(const wire::Action& action, std::string type, std::string why, wire::Effects& effects);
  void perform(const wire::Action& action, wire::Effects& effects);
  void start_pause(const wire::Action& action);
  void stop_pause(const wire::Action& action);
  void cancel_order(const wire::Action& action, wire::Effects& effects);
  /// x, y and theta; says what is wrong where they are no numbers.
  [[nodiscard]] std::optional<Pose2> pose_told(const wire::Action& action, wire::Effects& effects);
  void join_line(const wire::Action& action, wire::Effects& effects);
  void back_up(const wire::Action& action, wire::Effects& effects);
  void init_position(const wire::Action& action, wire::Effects& effects);
  void set_speed_limit(const wire::Action& action, wire::Effects& effects);
  /// Actions that wait until the vehicle stands.
  void end_waits();

  // place
  /// Memory first, because a vehicle that ran is no longer where it was started; then the start it was told.
  void find_place();
  /// Where the memory says that it stands: false where that cannot be.
  [[nodiscard]] bool stand_as_remembered();
  [[nodiscard]] std::optional<zone::Place> remembered_place(double way_m) const;
  void remember_place(bool due, wire::Effects& effects);

  // its own pace
  void on_tick(wire::Effects& effects);
  void supervise();
  void show(wire::Effects& effects);
  /// Its boards answer a moment after it: told of at once, their silence would raise six false alarms.
  [[nodiscard]] bool waking() const;
  void publish_state_if_due(wire::Effects& effects);
  void publish_factsheet(SimTime at, wire::Effects& effects);
  [[nodiscard]] ReportSources sources() const;
  [[nodiscard]] std::uint32_t uptime_ms() const {
    return static_cast<std::uint32_t>((now - started) / std::chrono::milliseconds{1});
  }
  static void log(wire::Effects& effects, char level, std::string text) {
    effects.emplace_back(wire::Log{level, std::move(text)});
  }

  OnboardOptions options;
  BoardsLink boards;
  Supervision supervision;
  Session session;
  std::string hall;                                    ///< whose it is; empty: nobody's, or there is one server only
  wire::ServerTopics topics{wire::server_topics({})};  ///< of the server that it obeys
  InstantActionBook actions;
  Warnings warnings;
  /// Its own, because its tags and beacons may be edited while agent and feeling refer to it; the ways never are.
  std::shared_ptr<zone::TrafficZone> zone;
  zone::ZoneConfiguration configuration;  ///< that `zone` was made from
  std::optional<zone::Rtm> coming_zone;   ///< checked, and waits until the vehicle stands
  std::string zone_refused;               ///< why the last one that came is not used
  std::vector<wire::MapInfo> maps;        ///< in force, coming
  std::optional<Agent> agent;             ///< as soon as there is a zone
  std::optional<FeltWorld> felt;          ///< likewise
  FeltWorld::Contact contact;             ///< at the last decision
  wire::Felt told;                        ///< the last answer
  bool owes_answer{true};                 ///< to whoever speaks next: it does not know yet that this vehicle feels
  std::vector<std::string> ahead_complaints;
  std::optional<Neighbours> neighbours;  ///< likewise
  std::optional<Passages> passages;      ///< likewise
  std::optional<wire::Cell> cell;        ///< where it speaks and which it listens around
  std::string cell_map;
  wire::Intent said_intent;
  std::optional<SimTime> intent_sent;
  bool intent_due{false};
  std::uint64_t intents_refused{0};
  std::vector<std::string> v2x_complaints;
  Sighting sighting;
  Estimating estimating;
  BoardClock pils_clock;
  bool estimate_complained{false};
  std::optional<wire::Power> power;
  std::optional<wire::Ranges> ranges;  ///< the last
  bool looked{false};                  ///< ranges came in these bytes
  std::optional<std::uint32_t> pils_session;
  std::optional<Memory> kept;    ///< for whoever asks, where nobody is told (as_values)
  std::optional<Memory> memory;  ///< recalled and not used yet
  bool start_counts{true};       ///< the start that it was told is of the zone in force

  SimTime now{};
  SimTime started{};
  Periodic beat;
  Periodic visualize;
  Periodic remember;
  Periodic display;
  Periodic report_boards;
  std::optional<SimTime> state_sent;
  bool state_due{false};
  ReportFlags flags;
  std::optional<std::int64_t> remembered_um;
  std::optional<Pose2> remembered_manoeuvre;
  bool must_remember{false};
  bool was_standing{true};
  std::string shown;
};

}  // namespace cosiva::aiv
