#pragma once

#include <algorithm>
#include <cmath>
#include <fstream>
#include <memory>
#include <set>
#include <sstream>
#include <string>
#include <utility>
#include <vector>

#include "cosiva/aiv/motion/motion.h"
#include "cosiva/aiv/order/order_book.h"
#include "cosiva/base/math.h"
#include "cosiva/base/test_paths.h"
#include "cosiva/wire/messages/topics.h"
#include "cosiva/wire/runtime/core.h"
#include "cosiva/wire/vda5050/codec.h"
#include "cosiva/zone/circuit/path_snap.h"
#include "cosiva/zone/rtm/rtm.h"

/// For tests: zones, and vehicles that obey VDA 5050 strictly (every order goes through aiv::OrderBook) and drive at
/// constant speed.
namespace cosiva::virtual_side::fixture {

using namespace std::chrono_literals;
namespace vda = wire::vda5050;

inline zone::ZoneConfiguration zone_file(const std::string& name) {
  std::ifstream file{source_dir() + "/zones/" + name};
  std::stringstream text;
  text << file.rdbuf();
  return {name.substr(name.rfind('.') + 1), name, text.str()};
}

/// A ring without crossings: two straights of 2 m joined by half circles of radius 0.5 m, 7.14 m round.
inline zone::ZoneConfiguration oval() {
  return {"toml", "oval", R"(
name = "oval"
format_version = 1
[vehicle]
length_m = 0.20
width_m = 0.12
[circuit]
start = { x = 0.0, y = 0.0, heading_deg = 0 }
closed = true
[[section]]
name = "south"
kind = "straight"
length_m = 2.0
[[section]]
name = "east"
kind = "arc"
radius_m = 0.5
angle_deg = 180
[[section]]
name = "north"
kind = "straight"
length_m = 2.0
[[section]]
name = "west"
kind = "arc"
radius_m = 0.5
angle_deg = 180
)"};
}

/// A ring with a bypass on the right of its south side, 0.29 m beside it: "south" or "bypass1" to "bypass5" between
/// "entry" and "east". Stations: dock on the bypass, gate on the north side. 2.41 m between fork and merge.
inline std::string fork_text(const std::string& more = "") {
  std::string text = R"(
name = "fork"
format_version = 1
[vehicle]
length_m = 0.20
width_m = 0.12
[circuit]
start = { x = 0.0, y = 0.0, heading_deg = 0 }
)";
  const auto section = [&text](const std::string& name, const std::string& shape, const std::string& next) {
    text += "[[section]]\nname = \"" + name + "\"\n" + shape + "next = [" + next + "]\n";
  };
  const auto straight = [](const std::string& m) { return "kind = \"straight\"\nlength_m = " + m + "\n"; };
  const auto arc = [](const std::string& r, const std::string& deg) {
    return "kind = \"arc\"\nradius_m = " + r + "\nangle_deg = " + deg + "\n";
  };
  section("entry", straight("1.0"), R"("south", "bypass1")");
  section("south", straight("2.41421356"), R"("east")");
  section("east", arc("0.6", "180"), R"("north")");
  section("north", straight("3.41421356"), R"("west")");
  section("west", arc("0.6", "180"), R"("entry")");
  section("bypass1", arc("0.5", "-45") + "start = { x = 1.0, y = 0.0, heading_deg = 0 }\n", R"("bypass2")");
  section("bypass2", arc("0.5", "45"), R"("bypass3")");
  section("bypass3", straight("1.0"), R"("bypass4")");
  section("bypass4", arc("0.5", "45"), R"("bypass5")");
  section("bypass5", arc("0.5", "-45"), R"("east")");
  return text + R"(
[[station]]
name = "dock"
section = "bypass3"
s_m = 0.5
[[station]]
name = "gate"
section = "north"
s_m = 1.5
)" + more;
}
inline zone::ZoneConfiguration fork(const std::string& more = "") { return {"toml", "fork", fork_text(more)}; }

class FixtureVehicle {
 public:
  FixtureVehicle(std::shared_ptr<const zone::TrafficZone> zone, wire::VehicleId vehicle, zone::TrackPosition start)
      : id{std::move(vehicle)},
        map_id{zone->name},
        zone_{std::move(zone)},
        book{*zone_},
        motion{zone_->circuit, start} {}

  wire::VehicleId id;
  std::string version{"2.1.0"};
  std::string map_id;

 private:
  std::shared_ptr<const zone::TrafficZone> zone_;
  std::shared_ptr<const zone::TrafficZone> next_zone_;
  SimDuration brakes_for_{};

 public:
  std::optional<aiv::OrderBook> book;
  aiv::AivMotion motion;
  double cruise_mps{0.3};
  double speed_mps{0.0};
  double driven_m{0.0};
  bool alive{true};
  bool paused{false};
  bool position_known{true};
  bool visualizes{true};
  bool blocked{false};           ///< something stands in its way
  double rolls_on_m{0.0};        ///< past the end of its base, the next time that it comes there
  std::string hangs_on{"none"};  ///< an order that it does not drive, and says nothing
  double charge{90.0};
  std::string profile{"normal"};
  std::set<std::string> deaf_to;  ///< instant actions it never hears
  std::set<std::string> fakes;    ///< instant actions it answers with FINISHED, and does nothing
  std::set<std::string> refuses;  ///< instant actions it answers with FAILED
  bool refuse_next_order{false};
  bool takes_zones{true};         ///< from their topic, as ours do; else only when it is told by initPosition
  std::optional<Pose2> off_path;  ///< it stands beside the circuit, and goes onto it when it is sent off
  std::vector<wire::MapInfo> maps;
  std::vector<std::shared_ptr<const zone::TrafficZone>> downloads;  ///< what its master control has for it
  SimDuration clock_ahead{};
  std::vector<wire::ActionState> action_states;
  std::vector<wire::VehicleError> errors;
  std::vector<wire::Information> information;
  std::vector<wire::Order> orders;            ///< every one received
  std::vector<wire::InstantActions> actions;  ///< every one received
  std::vector<std::string> refusals;          ///< of orders, by its own rules
  bool state_due{true};

  [[nodiscard]] zone::TrackPosition track_position() const { return motion.track_position(zone_->circuit); }
  [[nodiscard]] Pose2 pose() const { return off_path ? *off_path : motion.pose(zone_->circuit); }
  [[nodiscard]] const zone::TrafficZone& zone() const { return *zone_; }
  /// Carried to where no way leads, or anywhere else.
  void put(const Pose2& X_MB) {
    off_path = X_MB;
    if (const auto entry_point = zone::snap_to_path(zone_->circuit, X_MB))
      motion = {zone_->circuit, entry_point->position};
    book.emplace(*zone_);
    state_due = true;
  }
  void take(std::shared_ptr<const zone::TrafficZone> zone) {
    const Pose2 X_MB = pose();
    book.reset();
    zone_ = std::move(zone);
    map_id = zone_->name;
    put(X_MB);
  }

  void receive(const wire::Publish& message) {
    const auto topic = wire::parse_vda_topic(message.topic);
    const std::string_view on{message.topic};
    if (alive && takes_zones && on.starts_with(wire::zone_topic_prefix) && !message.payload.empty()) {
      const auto rtm = zone::Rtm::initialise(
          zone::from_payload(std::string(on.substr(wire::zone_topic_prefix.size())), message.topic, message.payload));
      if (rtm && (next_zone_ != nullptr || rtm->zone().name != zone_->name)) {
        next_zone_ = rtm->shared_zone();
        brakes_for_ = 300ms;
      }
      return;
    }
    if (!topic || topic->vehicle != id || !alive) return;
    if (topic->name == "order") on_order(*vda::decode_order(message.payload));
    if (topic->name == "instantActions") on_actions(*vda::decode_instant_actions(message.payload));
  }

  void step(SimDuration dt) {
    if (next_zone_ != nullptr) {
      if (brakes_for_ > SimDuration::zero()) {
        brakes_for_ -= dt;
      } else if (speed_mps == 0.0) {
        take(std::exchange(next_zone_, nullptr));
      }
    }
    const bool brakes = next_zone_ != nullptr && brakes_for_ <= SimDuration::zero();
    const double left_m = book->distance_to_base_end_m();
    const double target_m = paused || blocked || brakes || hangs_on == book->ids().order_id
                                ? 0.0
                                : std::min(left_m, cruise_mps * to_seconds(dt));
    const double moved_m = backs_m > 0.0 ? -back(dt) : off_path ? 0.0 : drive(target_m);
    driven_m += std::max(0.0, moved_m);
    const double speed = off_path && (target_m > 0.0 || !joins.empty()) ? seek(dt) : moved_m / to_seconds(dt);
    if ((speed != 0.0) != (speed_mps != 0.0)) state_due = true;
    speed_mps = speed;
    if (moved_m > 0.0 && !book->travelled(moved_m).empty()) state_due = true;
    if (moved_m > 0.0 && book->distance_to_base_end_m() == 0.0)
      motion.shift(zone_->circuit, std::exchange(rolls_on_m, 0.0));
  }

  [[nodiscard]] wire::State state(SimTime now) {
    wire::State s;
    s.header = header(now, state_header_id++);
    s.order_id = book->ids().order_id;
    s.order_update_id = book->ids().order_update_id;
    s.last_node_id = book->last_node().node_id;
    s.last_node_sequence_id = book->last_node().sequence_id;
    s.driving = speed_mps != 0.0;
    s.paused = paused;
    s.node_states = book->node_states();
    s.edge_states = book->edge_states();
    s.action_states = action_states;
    s.errors = errors;
    s.information = information;
    s.battery.charge_percent = charge;
    s.field_violation = blocked;
    s.maps = maps;
    s.position = position();
    s.velocity = wire::Velocity{speed_mps, 0.0, 0.0};
    return s;
  }
  [[nodiscard]] wire::Visualization visualization(SimTime now) {
    return {header(now, visualization_header_id++), position(), wire::Velocity{speed_mps, 0.0, 0.0}};
  }
  [[nodiscard]] wire::Connection connection(SimTime now, wire::ConnectionState state) {
    return {header(now, connection_header_id++), state};
  }
  [[nodiscard]] wire::Header header(SimTime now, std::uint32_t number) const {
    return {number, now + clock_ahead, version, id.manufacturer, id.serial_number};
  }
  [[nodiscard]] std::string topic(std::string_view name) const { return wire::vda_topic(id, name); }

  std::string joins;    ///< the joinLine that it follows
  double backs_m{0.0};  ///< that it has still to back up
  std::string backs;    ///< the backUp that it follows
  std::uint32_t state_header_id{0};
  std::uint32_t visualization_header_id{0};
  std::uint32_t connection_header_id{0};

 private:
  [[nodiscard]] wire::AgvPosition position() const {
    return {pose(), map_id, position_known, std::nullopt, std::nullopt};
  }

  double drive(double target_m) {
    if (target_m == 0.0) return 0.0;
    const zone::Course course = book->course_from(track_position());
    return motion.shift(zone_->circuit, target_m, course.remaining());
  }

  /// At 0.1 m/s; gives how far.
  double back(SimDuration dt) {
    const double step_m = std::min(backs_m, 0.1 * to_seconds(dt));
    motion.shift(zone_->circuit, -step_m);
    backs_m -= step_m;
    if (backs_m > 0.0) return step_m;
    state_due = true;
    const auto backed = std::ranges::find(action_states, std::exchange(backs, {}), &wire::ActionState::action_id);
    if (backed != action_states.end()) backed->status = wire::ActionStatus::finished;
    return step_m;
  }

  /// Straight to its place on the line at 0.2 m/s; gives its speed.
  double seek(SimDuration dt) {
    const Pose2 there = motion.pose(zone_->circuit);
    const double step_m = 0.2 * to_seconds(dt);
    const double left_m = distance(*off_path, there);
    if (left_m <= step_m) {
      off_path.reset();
      state_due = true;
      const auto joined = std::ranges::find(action_states, std::exchange(joins, {}), &wire::ActionState::action_id);
      if (joined != action_states.end()) joined->status = wire::ActionStatus::finished;
      return 0.0;
    }
    off_path->x_m += (there.x_m - off_path->x_m) * step_m / left_m;
    off_path->y_m += (there.y_m - off_path->y_m) * step_m / left_m;
    return 0.2;
  }

  void on_map_action(const wire::Action& action) {
    const std::string wanted = action.text("mapId").value_or("");
    const auto map = std::ranges::find(maps, wanted, &wire::MapInfo::map_id);
    if (action.action_type == "downloadMap" && map == maps.end())
      maps.push_back({wanted, action.text("mapVersion").value_or(""), "", false});
    if (action.action_type == "enableMap" && map != maps.end()) map->enabled = true;
    if (action.action_type != "initPosition") return;
    position_known = true;
    const auto zone = std::ranges::find(downloads, wanted, [](const auto& one) { return one->name; });
    if (zone != downloads.end() && wanted != map_id) take(*zone);
  }

  void on_order(wire::Order order) {
    orders.push_back(order);
    state_due = true;
    if (refuse_next_order) {
      refuse_next_order = false;
      errors = {{"orderError",
                 wire::ErrorLevel::warning,
                 "not today",
                 {{"orderId", order.order_id}, {"orderUpdateId", std::to_string(order.order_update_id)}}}};
      return;
    }
    const auto verdict = book->offer(order, {track_position(), position_known});
    if (!verdict)
      refusals.push_back(to_string(verdict.error()));
    else if (*verdict == aiv::OrderBook::Verdict::accepted_new)
      errors.clear();
  }

  void on_actions(wire::InstantActions message) {
    actions.push_back(message);
    for (const wire::Action& action : message.actions) {
      if (deaf_to.contains(action.action_type)) continue;
      const auto known = std::ranges::find(action_states, action.action_id, &wire::ActionState::action_id);
      if (known != action_states.end()) continue;
      state_due = true;
      if (refuses.contains(action.action_type)) {
        action_states.push_back({action.action_id, action.action_type, wire::ActionStatus::failed, "not supported"});
        continue;
      }
      if (fakes.contains(action.action_type)) {
        action_states.push_back({action.action_id, action.action_type, wire::ActionStatus::finished, ""});
        continue;
      }
      if (action.action_type == "startPause") paused = true;
      if (action.action_type == "stopPause") paused = false;
      if (action.action_type == "cancelOrder") book->cancel();
      on_map_action(action);
      if (action.action_type == "joinLine" && off_path) {
        const Point2 there{action.number("x").value_or(0.0), action.number("y").value_or(0.0)};
        motion = {zone_->circuit, zone_->circuit.locate(there, action.number("theta")).position};
        joins = action.action_id;
        action_states.push_back({action.action_id, action.action_type, wire::ActionStatus::running, ""});
        continue;
      }
      if (action.action_type == "backUp" && book->node_states().empty() &&
          action.number("distance").value_or(0.0) > 0.0) {
        backs_m = *action.number("distance");
        backs = action.action_id;
        action_states.push_back({action.action_id, action.action_type, wire::ActionStatus::running, ""});
        continue;
      }
      if (action.action_type == "setSpeedLimit") {
        profile = action.text("profile").value_or("normal");
        cruise_mps = action.number("maxSpeed") ? std::min(0.3, *action.number("maxSpeed"))
                     : profile == "slow"       ? 0.15
                     : profile == "fast"       ? 0.5
                                               : 0.3;
      }
      action_states.push_back({action.action_id, action.action_type, wire::ActionStatus::finished,
                               action.action_type == "setSpeedLimit" ? profile : ""});
    }
  }
};

/// Bodies that touch, found from the poses themselves and not from crossings: two rectangles by their separating axes.
inline bool touch(const Pose2& a, const Pose2& b, const zone::VehicleShape& shape) {
  const auto apart_along = [&](const Pose2& axis, const Pose2& other, bool across) {
    const SinCos turn = sincos(axis.heading_rad);
    const double dx = other.x_m - axis.x_m;
    const double dy = other.y_m - axis.y_m;
    const double d = across ? -turn.sin * dx + turn.cos * dy : turn.cos * dx + turn.sin * dy;
    const SinCos rel = sincos(other.heading_rad - axis.heading_rad);
    const double own = 0.5 * (across ? shape.width_m : shape.length_m);
    const double reach = across ? 0.5 * (shape.length_m * std::fabs(rel.sin) + shape.width_m * std::fabs(rel.cos))
                                : 0.5 * (shape.length_m * std::fabs(rel.cos) + shape.width_m * std::fabs(rel.sin));
    return std::fabs(d) > own + reach;
  };
  return !(apart_along(a, b, false) || apart_along(a, b, true) || apart_along(b, a, false) || apart_along(b, a, true));
}

}  // namespace cosiva::virtual_side::fixture
