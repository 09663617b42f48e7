#include "cosiva/aiv/localisation/persisted_position.h"

#include <cmath>

#include "cosiva/base/json_value.h"
#include "cosiva/base/json_writer.h"

namespace cosiva::aiv {
namespace {

/// Whole numbers of a double are exact up to here.
constexpr double whole_max = 9007199254740992.0;

void write(JsonWriter& json, std::string_view key, const std::optional<Pose2>& pose) {
  if (!pose) return;
  json.key(key)
      .begin_object()
      .field("x", pose->x_m)
      .field("y", pose->y_m)
      .field("theta", pose->heading_rad)
      .end_object();
}

std::optional<Pose2> pose_from(const JsonValue* json) {
  if (json == nullptr) return std::nullopt;
  const auto x = json->number("x");
  const auto y = json->number("y");
  const auto theta = json->number("theta");
  constexpr double m_max = 1e6;
  if (!x || !y || !theta || !(std::fabs(*x) <= m_max && std::fabs(*y) <= m_max && std::fabs(*theta) <= m_max))
    return std::nullopt;
  return Pose2{*x, *y, wrap_angle(*theta)};
}

void write(JsonWriter& json, const std::vector<wire::Load>& loads) {
  json.begin_array();
  for (const wire::Load& load : loads) {
    json.begin_object().field("id", load.load_id).field("type", load.load_type).field("position", load.load_position);
    if (load.weight_kg) json.field("weight_kg", *load.weight_kg);
    json.end_object();
  }
  json.end_array();
}

/// Damaged entries are left out.
std::vector<wire::Load> loads_from(const JsonValue* json) {
  std::vector<wire::Load> loads;
  if (json == nullptr || json->array() == nullptr) return loads;
  for (const JsonValue& each : *json->array()) {
    const auto position = each.text("position");
    if (!position) continue;
    loads.push_back(
        {each.text("id").value_or(""), each.text("type").value_or(""), *position, each.number("weight_kg")});
  }
  return loads;
}

}  // namespace

std::string to_json(const PersistedPosition& persisted) {
  JsonWriter json;
  json.begin_object().field("zone", persisted.zone).field("section", persisted.section).field("s", persisted.s_m);
  json.field("odometer_um", persisted.odometer_um).field("session", persisted.session);
  json.field("paused", persisted.paused);
  write(json, "pose", persisted.pose);
  if (persisted.off_path) json.field("off_path", true);
  write(json, "manoeuvre", persisted.manoeuvre);
  if (persisted.next) json.field("next", *persisted.next);
  if (!persisted.loads.empty()) write(json.key("loads"), persisted.loads);
  if (persisted.imposed) json.field("profile", to_string(*persisted.imposed));
  return json.end_object().take();
}

Result<PersistedPosition> persisted_position_from_json(std::string_view json) {
  // Sixteen loads, with names of up to a kilobyte that may be escaped.
  constexpr std::size_t bytes_max = 1U << 19U;
  const auto value = JsonValue::parse(json, bytes_max);
  if (!value) return tl::unexpected(value.error());
  const auto zone = value->text("zone");
  const auto section = value->text("section");
  const auto s_m = value->number("s");
  const auto odometer_um = value->number("odometer_um");
  const auto session = value->number("session");
  if (!zone || !section || !s_m || !odometer_um || !session)
    return fail("state.field", "a saved position has zone, section, s, odometer_um and session");
  const auto whole = [](double number, double low, double high) {
    return number >= low && number <= high && std::floor(number) == number;
  };
  if (!whole(*odometer_um, -whole_max, whole_max)) return fail("state.range", "no odometer reading", "odometer_um");
  if (!whole(*session, 0.0, 4294967295.0)) return fail("state.range", "no session number", "session");
  PersistedPosition persisted{*zone,
                              *section,
                              *s_m,
                              static_cast<std::int64_t>(*odometer_um),
                              static_cast<std::uint32_t>(*session),
                              value->flag("paused").value_or(false),
                              std::nullopt,
                              std::nullopt,
                              false,
                              std::nullopt,
                              std::nullopt,
                              loads_from(value->find("loads"))};
  persisted.pose = pose_from(value->find("pose"));
  persisted.off_path = value->flag("off_path").value_or(false) && persisted.pose;
  persisted.manoeuvre = pose_from(value->find("manoeuvre"));
  persisted.next = value->text("next");
  if (const auto profile = value->text("profile")) persisted.imposed = parse_profile(*profile);
  return persisted;
}

}  // namespace cosiva::aiv
