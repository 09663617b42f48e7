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

/// Topics on which a vehicle publishes.
enum class VehicleTopic : std::uint8_t { connection, state, visualization, factsheet, perceived, detected, boards };
inline constexpr std::size_t vehicle_topics = 7;
/// Parses the topics of VDA 5050; CoSiVA's own topics are not below the interface name.
[[nodiscard]] std::optional<VehicleTopic> parse_vehicle_topic(std::string_view name);
[[nodiscard]] std::string_view to_string(VehicleTopic topic);

/// The server's representation of a remote agent (A26): the content of its last messages, and what the next messages to
/// the agent must carry. All vehicles are treated alike, whatever their manufacturer.
struct AivProxy {
  wire::VehicleId id;
  std::string name;        ///< "manufacturer/serial"
  std::uint32_t number{};  ///< display number
  std::string order_topic;
  std::string actions_topic;
  std::string version;       ///< exactly as the vehicle writes it; empty until its first message
  bool augmented{false};     ///< added only virtually (A3): the bijection leaves it out
  bool retired{false};       ///< removed: in no table and no traffic; a vehicle of the same name may return
  std::int32_t priority{0};  ///< 0…999, higher goes first at a crossing

  std::optional<wire::ConnectionState> connection;  ///< nothing: never reported
  SimTime connection_at{};
  std::optional<SimTime> v2x_traced;  ///< when its V2X messages were last traced
  std::optional<wire::Factsheet> factsheet;
  bool factsheet_requested{false};
  SimTime first_received{};

  std::optional<wire::State> state;
  bool state_since_link{false};  ///< received since the server's own link came up
  bool state_in_session{false};  ///< received since the vehicle reported ONLINE
  ReportClock reports;           ///< of its states, and of positions newer than them
  SimTime reported_at{};  ///< reference for its age: the last report's time stamp, or the arrival if its clock is off
  std::optional<SimTime> state_stamp;     ///< time stamp of the last state, on its own clock
  std::optional<SimTime> position_stamp;  ///< time stamp of the last position, on its own clock
  std::optional<Pose2> reported;
  std::string map_id;  ///< map of the last reported position; empty: not reported
  bool position_known{false};
  std::optional<SimTime> position_lost_since;
  std::optional<SimTime> init_sent_at;
  double clock_off_s{0.0};  ///< 0: its clock is correct within 2 s

  std::optional<wire::BoardsReport> boards;
  std::optional<SimTime> boards_stamp;  ///< on its own clock
  std::optional<SimTime> detected_stamp;
  bool paused_for_body{false};  ///< by the server, since the vehicle cannot perceive the virtual object in front of it

  std::optional<std::size_t> twin;
  std::optional<zone::TrackPosition> base_end;  ///< as last reported
  std::size_t entity{};                         ///< in the monitor
  bool present{false};  ///< physically: reported its position while online, or reported for some time without ONLINE

  std::optional<aiv::Profile> imposed;
  std::optional<double> speed_mps_max;  ///< individual limit set by an operator
  std::optional<std::uint32_t> last_tag;
  double since_tag_m{};
  std::optional<std::uint32_t> tag_shown;
  bool no_orders{false};  ///< an operator cancelled the order; until restart
  /// The server has published that the vehicle belongs to another control area: nothing more is sent to the vehicle.
  struct HandedOver {
    SimTime first;
    SimTime last;  ///< published again until the server receives its own message back
  };
  std::optional<HandedOver> handed_over;

  std::array<std::optional<std::uint32_t>, vehicle_topics> last_header_id;
  std::uint64_t messages{0};
  std::uint64_t headers_missed{0};  ///< gaps in its header ids: messages lost in transit
  std::uint64_t refused{0};         ///< messages that could not be decoded or did not originate from this vehicle
  std::uint64_t outdated{0};
  std::uint32_t order_header_id{0};
  std::uint32_t actions_header_id{0};
  std::uint32_t diagnostics{0};  ///< bits of the diagnostics that were already logged

  /// A CoSiVA vehicle: takes the zone from its topic and drives onto the path by itself.
  [[nodiscard]] bool is_cosiva() const { return augmented || boards || id.manufacturer == wire::our_manufacturer; }
  /// Has a twin that is shown and that other vehicles take into account.
  [[nodiscard]] bool here() const { return twin.has_value() && !retired; }
  /// Is in the table and on the map. A vehicle that was handed over is not shown, so that no two control areas show the
  /// vehicle at once; the vehicle is shown again when the handover has not succeeded.
  [[nodiscard]] bool shown(SimTime now) const {
    return here() && (!handed_over || now - handed_over->first >= comes_back_within);
  }
  static constexpr SimDuration comes_back_within{std::chrono::seconds{1}};
  [[nodiscard]] bool online() const { return !connection || *connection == wire::ConnectionState::online; }
  /// No report for longer than `after`, or than three usual gaps of a vehicle that reports more slowly than that.
  [[nodiscard]] bool lost(SimTime now, SimDuration after) const { return reports.lost(now, after); }
  /// Nothing while the factsheet is unknown.
  [[nodiscard]] std::optional<bool> supports(std::string_view instant_action) const;
};

/// All proxies in the order of arrival; no proxy is ever removed.
class Registry {
 public:
  static constexpr std::size_t vehicles_max = 256;  ///< limits the memory that a flood of invented names can occupy

  explicit Registry(std::string interface_name) : interface_name_{std::move(interface_name)} {}

  struct Address {
    VehicleIndex vehicle;
    VehicleTopic topic;
  };
  /// The vehicle and the kind of a known topic.
  [[nodiscard]] std::optional<Address> find_topic(std::string_view topic) const;
  [[nodiscard]] std::optional<VehicleIndex> find(std::string_view name) const;
  /// Gives a vehicle its proxy and display number; nothing when there are too many vehicles.
  std::optional<VehicleIndex> add(const wire::VehicleId& id, SimTime now);
  /// Resets the proxy of a vehicle that returns: only name, display number, twin and counters are preserved.
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
