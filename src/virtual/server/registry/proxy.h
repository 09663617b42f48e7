#pragma once

#include <algorithm>
#include <array>
#include <cstdint>
#include <deque>
#include <map>
#include <optional>
#include <string>
#include <string_view>

#include "cosiva/aiv/motion/speed.h"
#include "cosiva/base/pose.h"
#include "cosiva/base/time.h"
#include "cosiva/virtual/server/registry/report_clock.h"
#include "cosiva/virtual/server/right_of_way/traffic.h"
#include "cosiva/wire/messages/messages.h"
#include "cosiva/wire/messages/topics.h"
#include "cosiva/wire/own/own_messages.h"

namespace cosiva::virtual_side {

/// Topics on which a vehicle speaks.
enum class VehicleTopic : std::uint8_t { connection, state, visualization, factsheet, perceived, detected, boards };
inline constexpr std::size_t vehicle_topics = 7;
/// Of the standard's topics; our own have no place under the interface.
[[nodiscard]] std::optional<VehicleTopic> parse_vehicle_topic(std::string_view name);
[[nodiscard]] std::string_view to_string(VehicleTopic topic);

/// The remote agent's place in the server (A26): what it said last, and what its next messages must carry. Every
/// vehicle is treated alike, whoever made it.
struct AivProxy {
  wire::VehicleId id;
  std::string name;        ///< "manufacturer/serial"
  std::uint32_t number{};  ///< its mark
  std::string order_topic;
  std::string actions_topic;
  std::string version;       ///< exactly as it writes it; empty until heard
  bool augmented{false};     ///< added only virtually (A3): the bijection leaves it out
  bool retired{false};       ///< taken away: in no table and no traffic; its name may come back
  std::int32_t priority{0};  ///< 0…999, higher goes first at a crossing

  std::optional<wire::ConnectionState> connection;  ///< nothing: it never said
  SimTime connection_at{};
  std::optional<SimTime> v2x_traced;  ///< when what it says to other vehicles was shown last
  std::optional<wire::Factsheet> factsheet;
  bool factsheet_requested{false};
  SimTime first_received{};

  std::optional<wire::State> state;
  bool state_since_link{false};  ///< heard since our own link came up
  bool state_in_session{false};  ///< heard since it said ONLINE
  ReportClock reports;           ///< of its states, and of positions newer than them
  SimTime reported_at{};         ///< what age counts from: the last report's time stamp, or arrival if its clock is off
  std::optional<SimTime> state_stamp;     ///< time stamp of the last state, on its own clock
  std::optional<SimTime> position_stamp;  ///< time stamp of the last position, on its own clock
  std::optional<Pose2> reported;
  std::string map_id;  ///< that it reported its place on last; empty: it does not say
  bool position_known{false};
  std::optional<SimTime> position_lost_since;
  std::optional<SimTime> init_sent_at;
  double clock_off_s{0.0};  ///< 0: its clock is right within 2 s

  std::optional<wire::BoardsReport> boards;
  std::optional<SimTime> boards_stamp;  ///< on its own clock
  std::optional<SimTime> detected_stamp;
  bool paused_for_body{false};  ///< by the server, since it cannot feel what stands before it

  std::optional<std::size_t> twin;
  std::optional<zone::TrackPosition> base_end;  ///< as it said last
  std::size_t entity{};                         ///< in the monitor
  bool present{false};  ///< physically: it was online and reported where it is, or reported for a while without

  std::optional<aiv::Profile> imposed;
  std::optional<double> speed_mps_max;  ///< its own limit, as an operator set it
  std::optional<std::uint32_t> last_tag;
  double since_tag_m{};
  std::optional<std::uint32_t> tag_shown;
  bool no_orders{false};  ///< an operator cancelled; until restart
  /// We have said that it is another control area's from now on: nothing more is sent to it.
  struct HandedOver {
    SimTime first;
    SimTime last;  ///< it is said again until we hear it come back
  };
  std::optional<HandedOver> handed_over;

  std::array<std::optional<std::uint32_t>, vehicle_topics> last_header_id;
  std::uint64_t messages{0};
  std::uint64_t headers_missed{0};  ///< gaps in its header ids: messages lost on the way
  std::uint64_t refused{0};         ///< messages that could not be understood or were not its own
  std::uint64_t outdated{0};
  std::uint32_t order_header_id{0};
  std::uint32_t actions_header_id{0};
  std::uint32_t diagnostics{0};  ///< bits of what was already logged once

  /// Runs our program: it takes the zone from its topic, and goes onto the line by itself.
  [[nodiscard]] bool is_cosiva() const { return augmented || boards || id.manufacturer == wire::our_manufacturer; }
  /// Has a twin that is shown and stands in the way of others.
  [[nodiscard]] bool here() const { return twin.has_value() && !retired; }
  /// Is in the table and on the map. One that we have handed over is not, so that no two control areas ever show it at
  /// once; it is again where nothing came of that.
  [[nodiscard]] bool shown(SimTime now) const {
    return here() && (!handed_over || now - handed_over->first >= comes_back_within);
  }
  static constexpr SimDuration comes_back_within{std::chrono::seconds{1}};
  [[nodiscard]] bool online() const { return !connection || *connection == wire::ConnectionState::online; }
  /// Silent for longer than `after`, or than three of its usual gaps where it reports more slowly than that.
  [[nodiscard]] bool lost(SimTime now, SimDuration after) const { return reports.lost(now, after); }
  /// Nothing when its factsheet is not known.
  [[nodiscard]] std::optional<bool> supports(std::string_view instant_action) const;
};

/// All proxies, by number of arrival; none is ever taken out.
class Registry {
 public:
  static constexpr std::size_t vehicles_max = 256;  ///< a flood of made-up names must not take the memory

  explicit Registry(std::string interface_name) : interface_name_{std::move(interface_name)} {}

  struct Address {
    VehicleIndex vehicle;
    VehicleTopic topic;
  };
  /// The vehicle and kind of a topic heard before.
  [[nodiscard]] std::optional<Address> find_topic(std::string_view topic) const;
  [[nodiscard]] std::optional<VehicleIndex> find(std::string_view name) const;
  /// Gives a vehicle its proxy and mark; nothing when there are too many.
  std::optional<VehicleIndex> add(const wire::VehicleId& id, SimTime now);
  /// Its next life begins: only its name, mark, twin and counters stay.
  void renew(VehicleIndex index, SimTime now);

  [[nodiscard]] std::size_t size() const { return proxies_.size(); }
  [[nodiscard]] AivProxy& operator[](VehicleIndex index) { return proxies_[index]; }
  [[nodiscard]] const AivProxy& operator[](VehicleIndex index) const { return proxies_[index]; }
  [[nodiscard]] auto begin() { return proxies_.begin(); }
  [[nodiscard]] auto end() { return proxies_.end(); }
  [[nodiscard]] auto begin() const { return proxies_.begin(); }
  [[nodiscard]] auto end() const { return proxies_.end(); }
  [[nodiscard]] const std::string& interface_name() const { return interface_name_; }

 private:
  [[nodiscard]] std::uint32_t display_number_for(std::string_view serial) const;

  std::string interface_name_;
  std::deque<AivProxy> proxies_;
  std::map<std::string, Address, std::less<>> topics_;
  std::map<std::string, VehicleIndex, std::less<>> names_;
};

}  // namespace cosiva::virtual_side
