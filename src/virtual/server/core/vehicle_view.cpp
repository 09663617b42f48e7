#include "cosiva/virtual/server/core/vehicle_view.h"

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>

#include "cosiva/wire/messages/charge.h"
#include "cosiva/wire/vda5050/codec.h"

namespace cosiva::virtual_side {
namespace {

constexpr double reserved_step_m = 0.1;
constexpr double strange_base_m_max = 8.0;        ///< of an order that this server did not send
constexpr std::size_t reserved_points_max = 400;  ///< a base longer than 40 m is drawn with a larger step

/// Rounds to a tenth of a millimetre, which is finer than the display resolves.
double drawn(double m) { return std::nearbyint(m * 1e4) / 1e4; }

void write_pose(JsonWriter& json, const Pose2& pose) {
  json.field("x", pose.x_m).field("y", pose.y_m).field("heading", pose.heading_rad);
}

void write_point(JsonWriter& json, Point2 p) { json.begin_array().value(drawn(p.x_m)).value(drawn(p.y_m)).end_array(); }

void text_or_null(JsonWriter& json, std::string_view name, std::string_view text) {
  json.key(name);
  if (text.empty())
    json.null();
  else
    json.value(text);
}

std::string hex(std::uint32_t value) {
  std::array<char, 8> digits{};
  digits.fill('0');
  std::array<char, 8> written{};
  const auto end = std::to_chars(written.data(), written.data() + written.size(), value, 16).ptr;
  std::copy_backward(written.data(), end, digits.data() + digits.size());
  return {digits.data(), digits.size()};
}

void write_proxies(JsonWriter& json, const std::vector<wire::ProxyCounts>& proxies) {
  json.key("proxies").begin_array();
  for (const wire::ProxyCounts& proxy : proxies)
    json.begin_object()
        .field("agent", proxy.agent)
        .field("sent", proxy.sent)
        .field("delivered", proxy.delivered)
        .end_object();
  json.end_array();
}

void write_boards(JsonWriter& json, const wire::BoardsReport& report) {
  json.key("boards").begin_array();
  for (const wire::BoardsReport::Line& line : report.boards) {
    json.begin_object()
        .field("board", wire::to_string(line.board))
        .field("health", line.health)
        .field("firmware", hex(line.firmware_hash))
        .field("uptime_ms", line.uptime_ms)
        .field("frames", line.frames)
        .field("framesBad", line.frames_bad)
        .field("framesMissed", line.frames_missed)
        .field("selfTest", line.self_test);
    if (line.self_test != 0) json.field("fault", wire::fault_text(line.self_test));
    if (!line.parts.empty()) {
      json.key("parts").begin_object();
      for (const wire::PartFinding& part : line.parts) json.field(to_string(part.part), to_string(part.finding));
      json.end_object();
    }
    json.end_object();
  }
  json.end_array();
  if (report.pils) wire::write_pils(json.key("pils"), *report.pils);
  if (!report.affi.empty()) json.field("affi", report.affi);
  if (!report.proxies.empty()) write_proxies(json, report.proxies);
  if (report.power) {
    json.key("power")
        .begin_object()
        .field("voltage_v", report.power->voltage_mv / 1000.0)
        .field("current_a", report.power->current_ma / 1000.0)
        .field("temperature_c", report.power->temperature_01C / 10.0)
        .end_object();
  }
  if (report.ranges) {
    json.key("ranges")
        .begin_object()
        .field("first", report.ranges->first_bearing_crad / 100.0)
        .field("width", report.ranges->beam_width_crad / 100.0);
    json.key("m").begin_array();
    for (const std::uint16_t mm : report.ranges->range_mm) {
      if (mm == wire::no_echo)
        json.null();
      else
        json.value(mm / 1000.0);
    }
    json.end_array().end_object();
  }
}

}  // namespace

void VehicleView::write(JsonWriter& json, VehicleIndex vehicle) const {
  const AivProxy& proxy = context_.registry[vehicle];
  const Twin::Image image = context_.simulator.image(*proxy.twin(), context_.now);
  const wire::ConnectionState connection = proxy.connection.shown();
  const bool lost =
      proxy.lost(context_.now, context_.options.lost_after) || connection == wire::ConnectionState::connection_broken;
  const double speed_mps = lost ? 0.0 : image.speed_mps;

  json.begin_object()
      .field("id", proxy.name())
      .field("handle", vehicle)
      .field("number", proxy.identity.number())
      .field("augmented", proxy.augmented())
      .field("connection", wire::vda5050::to_string(connection))
      .field("lost", lost)
      .field("status", aiv::to_string(aiv::status_of(speed_mps, proxy.reported_state.imposed())));
  write_pose_and_mission(json, vehicle, image, speed_mps);
  json.field("age_ms", std::max(0.0, to_milliseconds_scaled(context_.now - proxy.reports.reported_at())))
      .field("divergence_m", context_.simulator.last_divergence_m(*proxy.twin()));
  json.field("dropped", proxy.counters.dropped())
      .key("proxy")
      .begin_object()
      .field("sent", proxy.messages_sent())
      .field("delivered", proxy.messages_delivered())
      .end_object();
  write_agent(json, vehicle, lost);
  write_reserved(json, vehicle);
  if (proxy.on_board.boards()) write_boards(json, *proxy.on_board.boards());
  write_contract(json, proxy);
  json.field("excluded", proxy.settings.excluded());
  text_or_null(json, "absent",
               proxy.augmented() ? "" : context_.simulator.monitor().held(proxy.twin_link.entity()).absence);
  json.end_object();
}

void VehicleView::write_pose_and_mission(JsonWriter& json, VehicleIndex vehicle, const Twin::Image& image,
                                         double speed_mps) const {
  const AivProxy& proxy = context_.registry[vehicle];
  const auto& zone = context_.simulator.zone();
  const auto in_body_frame = [&](const Pose2& X_MT) { return zone ? zone::body_pose(*zone, X_MT) : X_MT; };
  write_pose(json, in_body_frame(image.X_MB));
  json.field("speed", speed_mps).key("section");
  if (image.position && context_.simulator.circuit() != nullptr)
    json.value(context_.simulator.circuit()->part(image.position->section).name).key("s").value(image.position->s_m);
  else
    json.null().key("s").null();
  json.field("priority", proxy.settings.priority()).key("speedLimit");
  if (proxy.settings.speed_mps_max())
    json.value(*proxy.settings.speed_mps_max());
  else
    json.null();
  text_or_null(json, "map", proxy.position.map_id());
  const std::string why_off_route = zones_.change().off_route(vehicle);
  text_or_null(json, "offRoute", why_off_route);
  master_.missions.write(json.key("mission"), vehicle, master_.orders.waits().blocker_at_goal(vehicle));
  write_pose(json.key("reported").begin_object(),
             in_body_frame(context_.simulator.twin(*proxy.twin()).last_report().X_MB));
  json.end_object();
}

void VehicleView::write_contract(JsonWriter& json, const AivProxy& proxy) const {
  // The twin of a virtual AIV has no physical vehicle to differ from.
  const auto held = proxy.augmented() ? BijectionMonitor::Held{true, true, true, true}
                                      : context_.simulator.monitor().held(proxy.twin_link.entity());
  json.key("contract")
      .begin_object()
      .field("matched", held.matched)
      .field("divergence", held.divergence)
      .field("age", held.age)
      .field("actual", held.actual)
      .end_object();
}

void VehicleView::write_agent(JsonWriter& json, VehicleIndex vehicle, bool lost) const {
  const AivProxy& proxy = context_.registry[vehicle];
  json.key("battery");
  if (proxy.state() && wire::charge_unknown(*proxy.state()))
    json.null();
  else
    json.value(proxy.state() ? proxy.state()->battery.charge_percent : 0.0);
  json.key("lastTag");
  if (proxy.reported_state.last_tag())
    json.value(*proxy.reported_state.last_tag());
  else
    json.null();
  const wire::State none;
  const wire::State& state = proxy.state() ? *proxy.state() : none;
  json.field("sinceTag_m", proxy.reported_state.since_tag_m())
      .field("lastNode", state.last_node_id)
      .field("orderId", state.order_id)
      .field("orderUpdateId", state.order_update_id)
      .field("driving", state.driving)
      .field("paused", state.paused)
      .field("fieldViolation", state.field_violation);
  text_or_null(json, "waitsFor", master_.orders.waits().waits_for(vehicle));
  text_or_null(json, "brakingFor",
               lost ? std::string_view{} : std::string_view{augmented_.virtual_obstacles.perceives(vehicle)});
  json.key("errors").begin_array();
  for (const wire::VehicleError& error : state.errors)
    json.value(error.description.empty() ? error.type : error.type + ": " + error.description);
  if (proxy.clock.is_off()) json.value("clock: off by " + std::to_string(proxy.clock.off_s()) + " s");
  if (proxy.counters.rate().flooding(context_.now))
    json.value(
        "flood: more than " +
        std::to_string(std::lround(proxy.counters.rate().limit_per_s(context_.options.vehicle_messages_per_s_max))) +
        " messages per second; the excess is dropped");
  if (const std::string why = zones_.change().off_route(vehicle); !why.empty()) json.value("off-route: it " + why);
  json.end_array();
}

void VehicleView::write_reserved(JsonWriter& json, VehicleIndex vehicle) const {
  json.key("reserved").begin_array();
  const AivProxy& proxy = context_.registry[vehicle];
  const auto track_position = context_.simulator.image(*proxy.twin(), context_.now).position;
  if (track_position && zones_.map()) {
    const zone::Circuit& circuit = zones_.map()->zone().circuit;
    std::optional<double> left_m;
    const auto remaining = context_.simulator.twin(*proxy.twin()).remaining(track_position->section);
    if (master_.traffic.base_end(vehicle) != no_waypoint)
      left_m =
          zones_.map()->base_left(*track_position, master_.traffic.base_end(vehicle),
                                  master_.traffic.base_m_max(vehicle), remaining, master_.traffic.base_passed(vehicle));
    else if (proxy.twin_link.base_end())
      left_m = circuit.distance_ahead(*track_position, *proxy.twin_link.base_end(), strange_base_m_max, remaining);
    const auto at = [&](double d_m) {
      return position(circuit.pose_at(circuit.advance(*track_position, d_m, remaining)));
    };
    if (left_m && *left_m > 0.0) {
      const double step_m = std::max(reserved_step_m, *left_m / static_cast<double>(reserved_points_max));
      for (double i = 0.0; i * step_m < *left_m; i += 1.0) write_point(json, at(i * step_m));
      write_point(json, at(*left_m));
    }
  }
  json.end_array();
}

}  // namespace cosiva::virtual_side
