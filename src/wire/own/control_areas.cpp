#include "cosiva/wire/own/control_areas.h"

#include "cosiva/base/json_writer.h"
#include "cosiva/wire/messages/topics.h"
#include "cosiva/wire/own/own_fields.h"

namespace cosiva::wire {

bool valid_area_name(std::string_view name) {
  constexpr std::size_t bytes_max = 32;
  return name.size() <= bytes_max && valid_serial_number(name);
}

ServerTopics server_topics(std::string_view area) {
  if (area.empty())
    return {std::string(zone_topic_prefix), std::string(server_connection_topic), std::string(server_heartbeat_topic)};
  std::string stem{area_topic_prefix};
  stem += area;
  return {stem + "/zone/", stem + "/server/connection", stem + "/server/heartbeat"};
}

std::optional<AreaTopic> parse_area_topic(std::string_view topic) {
  if (!topic.starts_with(area_topic_prefix)) return std::nullopt;
  topic.remove_prefix(area_topic_prefix.size());
  const std::size_t slash = topic.find('/');
  if (slash == std::string_view::npos || slash + 1 == topic.size() || !valid_area_name(topic.substr(0, slash)))
    return std::nullopt;
  return AreaTopic{topic.substr(0, slash), topic.substr(slash + 1)};
}

std::string to_json(const Owner& owner) {
  JsonWriter json;
  json.begin_object()
      .field("area", owner.area)
      .field("sequence", owner.sequence)
      .field("timestamp", to_iso8601(owner.timestamp));
  if (owner.pose) {
    json.key("pose")
        .begin_object()
        .field("x", owner.pose->x_m)
        .field("y", owner.pose->y_m)
        .field("theta", owner.pose->heading_rad)
        .end_object();
  }
  if (owner.mission)
    json.key("mission")
        .begin_object()
        .field("kind", owner.mission->kind)
        .field("name", owner.mission->name)
        .end_object();
  return json.end_object().take();
}

Result<Owner> owner_from_json(std::string_view text) {
  using own::Fields;
  return own::read_message<Owner>(text, [](Fields& in, Owner& owner) {
    in.text("area", owner.area);
    if (!valid_area_name(owner.area))
      in.report_fault("area", "the name of a control area, of A-Z a-z 0-9 _ . : - only, 32 at most");
    in.whole("sequence", owner.sequence);
    in.time("timestamp", owner.timestamp);
    own::read_part(in, "pose", owner.pose, [](Fields& fields, Pose2& pose) {
      fields.number("x", -own::position_m_max, own::position_m_max, pose.x_m);
      fields.number("y", -own::position_m_max, own::position_m_max, pose.y_m);
      fields.number("theta", -own::heading_rad_max, own::heading_rad_max, pose.heading_rad);
    });
    own::read_part(in, "mission", owner.mission, [](Fields& fields, Owner::Mission& mission) {
      fields.text("kind", mission.kind);
      if (mission.kind != "go" && mission.kind != "circulate") fields.report_fault("kind", "go or circulate");
      fields.text("name", mission.name);
    });
  });
}

}  // namespace cosiva::wire
