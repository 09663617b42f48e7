#include "cosiva/wire/own/v2x.h"

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <utility>

#include "cosiva/base/json_writer.h"
#include "cosiva/base/math.h"
#include "cosiva/wire/own/own_fields.h"

namespace cosiva::wire {
namespace {

using namespace own;

constexpr double duration_s_max = 3600.0;
constexpr std::size_t map_level_bytes_max = 64;
constexpr std::uint32_t priority_max = 999;

void read_crossing(Fields& in, CrossingIntent& crossing) {
  in.text("name", crossing.name);
  in.number("entry", 0.0, position_m_max, crossing.entry_m);
  in.number("exit", 0.0, position_m_max, crossing.exit_m);
  in.number("arrival", 0.0, duration_s_max, crossing.arrival_s);
  in.number("departure", 0.0, duration_s_max, crossing.departure_s);
  in.flag("mayEnter", crossing.may_enter);
  if (crossing.exit_m < crossing.entry_m) in.report_fault("exit", "no less than entry");
  if (crossing.departure_s < crossing.arrival_s) in.report_fault("departure", "no less than arrival");
}

void read_identity(Fields& in, VehicleId& vehicle) {
  in.text("manufacturer", vehicle.manufacturer);
  in.text("serialNumber", vehicle.serial_number);
  if (!valid_serial_number(vehicle.manufacturer)) in.report_fault("manufacturer", "A-Z a-z 0-9 _ . : -");
  if (!valid_serial_number(vehicle.serial_number)) in.report_fault("serialNumber", "A-Z a-z 0-9 _ . : -");
}

std::string map_level(std::string_view map_id) {
  std::string level{map_id.substr(0, map_level_bytes_max)};
  for (char& c : level) {
    const bool plain =
        (c >= 'A' && c <= 'Z') || (c >= 'a' && c <= 'z') || (c >= '0' && c <= '9') || c == '.' || c == '-' || c == '_';
    if (!plain) c = '_';
  }
  return level.empty() ? "_" : level;
}

std::string cell_level(Cell cell) { return std::to_string(cell.x) + "_" + std::to_string(cell.y); }

std::optional<std::int32_t> parse_index(std::string_view text) {
  std::int32_t index = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), index);
  if (error != std::errc{} || end != text.data() + text.size()) return std::nullopt;
  return index;
}

std::optional<Cell> parse_cell(std::string_view text) {
  const std::size_t centre = text.find('_');
  if (centre == std::string_view::npos) return std::nullopt;
  const auto x = parse_index(text.substr(0, centre));
  const auto y = parse_index(text.substr(centre + 1));
  if (!x || !y) return std::nullopt;
  return Cell{*x, *y};
}

}  // namespace

std::string to_json(const Intent& intent) {
  JsonWriter json;
  json.begin_object()
      .field("headerId", intent.header_id)
      .field("timestamp", to_iso8601(intent.timestamp))
      .field("mapId", intent.map_id)
      .field("manufacturer", intent.vehicle.manufacturer)
      .field("serialNumber", intent.vehicle.serial_number)
      .field("x", intent.pose.x_m)
      .field("y", intent.pose.y_m)
      .field("heading", intent.pose.heading_rad)
      .field("speed", intent.speed_mps)
      .field("braking", intent.braking)
      .field("priority", intent.priority);
  if (intent.position) {
    json.key("position")
        .begin_object()
        .field("section", intent.position->section)
        .field("s", intent.position->s_m)
        .end_object();
  }
  json.key("crossings").begin_array();
  for (const CrossingIntent& crossing : intent.crossings) {
    json.begin_object()
        .field("name", crossing.name)
        .field("entry", crossing.entry_m)
        .field("exit", crossing.exit_m)
        .field("arrival", crossing.arrival_s)
        .field("departure", crossing.departure_s)
        .field("mayEnter", crossing.may_enter)
        .end_object();
  }
  json.end_array().key("route").begin_array();
  for (const std::string& section : intent.route) json.value(section);
  return json.end_array().end_object().take();
}

Result<Intent> intent_from_json(std::string_view text) {
  return read_message<Intent>(text, [](Fields& in, Intent& intent) {
    in.whole("headerId", intent.header_id);
    in.time("timestamp", intent.timestamp);
    in.text("mapId", intent.map_id);
    read_identity(in, intent.vehicle);
    in.number("x", -position_m_max, position_m_max, intent.pose.x_m);
    in.number("y", -position_m_max, position_m_max, intent.pose.y_m);
    in.number("heading", -heading_rad_max, heading_rad_max, intent.pose.heading_rad);
    intent.pose.heading_rad = wrap_angle(intent.pose.heading_rad);
    in.number("speed", -speed_mps_max, speed_mps_max, intent.speed_mps);
    in.flag("braking", intent.braking);
    in.whole("priority", intent.priority);
    if (intent.priority > priority_max) in.report_fault("priority", "a whole number from 0 to 999");
    read_part(in, "position", intent.position, [](Fields& fields, Intent::OnLine& position) {
      fields.text("section", position.section);
      fields.number("s", 0.0, position_m_max, position.s_m);
    });
    in.list("crossings", Intent::crossings_max, [&](const JsonValue& item, const std::string& name) {
      Fields fields{item, name + "."};
      read_crossing(fields, intent.crossings.emplace_back());
      in.take_over(fields.error());
    });
    in.list("route", Intent::route_max, [&](const JsonValue& item, const std::string& name) {
      const std::string* section = item.text();
      if (section == nullptr || section->size() > text_bytes_max)
        return in.report_fault(name, "a section's name of at most " + std::to_string(text_bytes_max) + " bytes");
      intent.route.push_back(*section);
    });
  });
}

Cell cell_of(Point2 p) {
  const auto index = [](double m) {
    return static_cast<std::int32_t>(std::floor(std::clamp(m, -position_m_max, position_m_max) / v2x_cell_m));
  };
  return {index(p.x_m), index(p.y_m)};
}

double outside_cell_m(Cell cell, Point2 p) {
  const auto outside = [](std::int32_t index, double m) {
    const double from_m = index * v2x_cell_m;
    return std::max({0.0, from_m - m, m - from_m - v2x_cell_m});
  };
  return std::max(outside(cell.x, p.x_m), outside(cell.y, p.y_m));
}

std::string v2x_topic(std::string_view map_id, Cell cell, const VehicleId& vehicle) {
  std::string prefix{v2x_topic_prefix};
  prefix.append(map_level(map_id)).append("/").append(cell_level(cell)).append("/");
  return own_topic(prefix, vehicle);
}

std::vector<std::string> v2x_filters(std::string_view map_id, Cell cell) {
  const std::string level = map_level(map_id);
  std::vector<std::string> filters;
  for (std::int32_t y = cell.y - 1; y <= cell.y + 1; ++y) {
    for (std::int32_t x = cell.x - 1; x <= cell.x + 1; ++x) {
      std::string prefix{v2x_topic_prefix};
      prefix.append(level).append("/").append(cell_level({x, y})).append("/");
      filters.push_back(topics_below(prefix, 2));
    }
  }
  return filters;
}

std::optional<V2xTopic> parse_v2x_topic(std::string_view topic) {
  if (!topic.starts_with(v2x_topic_prefix)) return std::nullopt;
  topic.remove_prefix(v2x_topic_prefix.size());
  const std::size_t after_map = topic.find('/');
  if (after_map == std::string_view::npos || after_map == 0) return std::nullopt;
  const std::size_t after_cell = topic.find('/', after_map + 1);
  if (after_cell == std::string_view::npos) return std::nullopt;
  const auto cell = parse_cell(topic.substr(after_map + 1, after_cell - after_map - 1));
  const auto vehicle = parse_own_topic(topic.substr(0, after_cell + 1), topic);
  if (!cell || !vehicle) return std::nullopt;
  return V2xTopic{std::string(topic.substr(0, after_map)), *cell, *vehicle};
}

}  // namespace cosiva::wire
