#include "cosiva/virtual/server/core/persisted_state.h"

#include <charconv>
#include <cmath>
#include <utility>

#include "cosiva/base/archive.h"
#include "cosiva/base/expect.h"

namespace cosiva::virtual_side {
namespace {

constexpr SimDuration persist_period{std::chrono::seconds{1}};
/// The state of a large fleet is persisted less often for the crossings that vehicles hold: at most 1 MB/s.
constexpr SimDuration time_for_byte{std::chrono::microseconds{1}};
constexpr double position_m_max = 1e5;

/// Nanoseconds do not fit a JSON number.
std::string ns_text(SimTime time) { return std::to_string(time.time_since_epoch().count()); }

std::optional<SimTime> read_ns(const JsonValue& json, std::string_view field) {
  const auto text = json.text(field);
  if (!text) return std::nullopt;
  std::int64_t ns = 0;
  const auto read = std::from_chars(text->data(), text->data() + text->size(), ns);
  if (read.ec != std::errc{} || read.ptr != text->data() + text->size() || ns < 0) return std::nullopt;
  return SimTime{SimDuration{ns}};
}

bool in(const std::optional<double>& value, double low, double high) {
  return value && *value >= low && *value <= high;
}

void write_virtual_object(JsonWriter& json, const VirtualObject& virtual_object) {
  json.begin_object()
      .field("id", virtual_object.id)
      .field("kind", to_string(virtual_object.kind))
      .field("radius", virtual_object.radius_m)
      .field("speed", virtual_object.walk.speed_mps())
      .field("repeat", to_string(virtual_object.walk.repeat()))
      .field("since", ns_text(virtual_object.since))
      .field("started", ns_text(virtual_object.started));
  json.key("path").begin_array();
  for (const Point2 p : virtual_object.walk.path()) json.begin_array().value(p.x_m).value(p.y_m).end_array();
  json.end_array().end_object();
}

std::optional<std::vector<Point2>> read_path(const JsonValue* json) {
  const JsonValue::Array* points = json == nullptr ? nullptr : json->array();
  if (points == nullptr || points->empty() || points->size() > Walk::points_max) return std::nullopt;
  std::vector<Point2> path;
  for (const JsonValue& point : *points) {
    const JsonValue::Array* pair = point.array();
    if (pair == nullptr || pair->size() != 2) return std::nullopt;
    const double* x = (*pair)[0].number();
    const double* y = (*pair)[1].number();
    if (x == nullptr || y == nullptr || !(std::fabs(*x) <= position_m_max) || !(std::fabs(*y) <= position_m_max))
      return std::nullopt;
    path.push_back({*x, *y});
  }
  return path;
}

std::optional<VirtualObject> read_virtual_object(const JsonValue& json) {
  const auto id = json.text("id");
  const auto kind = parse_virtual_object_kind(json.text("kind").value_or(""));
  const auto repeat = parse_repeat(json.text("repeat").value_or(""));
  const auto since = read_ns(json, "since");
  const auto started = read_ns(json, "started");
  auto path = read_path(json.find("path"));
  if (!id || id->empty() || id->size() > 64 || !kind || !repeat || !since || !started || !path) return std::nullopt;
  if (!in(json.number("radius"), VirtualObjectCommands::radius_m_min, VirtualObjectCommands::radius_m_max) ||
      !in(json.number("speed"), 0.0, VirtualObjectCommands::speed_mps_max))
    return std::nullopt;
  return VirtualObject{
      *id, *kind, 0, *json.number("radius"), Walk(std::move(*path), *json.number("speed"), *repeat), *since, *started};
}

}  // namespace

std::string PersistedState::to_json() const {
  JsonWriter json;
  json.begin_object().field("version", 1).key("virtualObjects").begin_array();
  for (const VirtualObject& virtual_object : context_.simulator.augmented().virtual_objects())
    write_virtual_object(json, virtual_object);
  json.end_array();
  world_.write_state(json);
  json.key("paused").begin_array();
  for (const AivProxy& proxy : context_.registry)
    if (proxy.settings.paused_for_body()) json.value(proxy.name());
  json.end_array();
  master_.awaited.write(json);
  zones_.write_state(json);
  if (!master_.intentions.empty()) master_.intentions.write(json.key("intentions"));
  if (!master_.command_ids.empty()) master_.command_ids.write(json.key("commandIds"));
  if (master_.persisted_missions.worth_remembering()) master_.persisted_missions.write(json.key("traffic"));
  json.end_object();
  return json.take();
}

void PersistedState::persist_if_stale() {
  const bool moves = !augmented_.hosted.empty() && context_.now >= due_at_;
  const bool holds = master_.traffic.holds() != holds_ && context_.now >= holds_due_at_;
  if (!context_.state_stale && !moves && !holds) return;
  // Until a zone is in force, only the state file contains its edits.
  if (zones_.awaits_zone_to_restore()) return;
  context_.state_stale = false;
  due_at_ = context_.now + persist_period;
  holds_ = master_.traffic.holds();
  std::string bytes = to_json();
  holds_due_at_ = context_.now + time_for_byte * static_cast<std::int64_t>(bytes.size());
  if (bytes == persisted_) return;
  COSIVA_EXPECT(!bytes.empty());
  persisted_ = bytes;
  context_.publisher.persist(std::move(bytes));
}

void PersistedState::restore(std::string_view bytes) {
  master_.command_ids.begin_series(context_.now);
  const auto state = JsonValue::parse(bytes);
  if (!state || state->number("version") != std::optional{1.0}) {
    context_.publisher.log('w', "the persisted state of the virtual world cannot be read; it starts empty" +
                                    (state ? std::string{} : ": " + state.error().message));
    return;
  }
  restore_world(*state);
  if (const JsonValue* intentions = state->find("intentions");
      intentions != nullptr && !master_.intentions.restore(*intentions))
    context_.publisher.log('w', "some persisted intentions of operators cannot be read; they are skipped");
  if (const JsonValue* ids = state->find("commandIds"); ids != nullptr && !master_.command_ids.restore(*ids))
    context_.publisher.log('w', "some persisted ids of commands cannot be read; they are skipped");
  if (const JsonValue* names = state->find("vehicles")) {
    master_.awaited.restore(*names, state->find("held"));
    for (const std::string& name : master_.awaited.holders())
      if (const auto id = wire::parse_own_topic("", name)) vehicles_.register_awaited(*id);
  }
  if (const JsonValue* traffic_state = state->find("traffic")) master_.persisted_missions.restore(*traffic_state);
  std::optional<zone::ZoneConfiguration> given_zone;
  if (const JsonValue* given = state->find("given")) {
    auto configuration = zone::zone_configuration_from_json(*given);
    if (configuration) given_zone = std::move(*configuration);
  }
  const JsonValue* zone = state->find("zone");
  zones_.restore(zone == nullptr ? std::nullopt : std::optional{*zone}, std::move(given_zone));
  context_.publisher.log('i', "restored " + std::to_string(context_.simulator.augmented().virtual_objects().size()) +
                                  " virtual objects and " + std::to_string(augmented_.restored.aivs().size()) +
                                  " virtual AIVs");
}

void PersistedState::restore_world(const JsonValue& state) {
  const auto each = [&state](std::string_view list, std::size_t max, const auto& take) {
    const JsonValue* found = state.find(list);
    if (found == nullptr || found->array() == nullptr) return;
    for (std::size_t i = 0; i < found->array()->size() && i < max; ++i) take((*found->array())[i]);
  };
  each("virtualObjects", Augmented::virtual_objects_max, [&](const JsonValue& json) {
    auto virtual_object = read_virtual_object(json);
    if (virtual_object && context_.simulator.augmented().find(virtual_object->id) == nullptr)
      context_.simulator.augmented().add(std::move(*virtual_object));
    else
      context_.publisher.log('w', "a persisted virtual object cannot be read; it is skipped");
  });
  each("aivs", Augmented::virtual_objects_max, [&](const JsonValue& json) {
    const auto id = json.text("id");
    const auto section = json.text("section");
    if (id && section && wire::valid_serial_number(*id) && in(json.number("s"), 0.0, position_m_max))
      augmented_.restored.add({*id, *section, *json.number("s")});
    else
      context_.publisher.log('w', "a persisted virtual AIV cannot be read; it is skipped");
  });
  each("paused", context_.registry.vehicles_max(), [&](const JsonValue& json) {
    if (json.text() != nullptr) vehicles_.restore_pause(*json.text());
  });
}

void PersistedState::archive(Archive& archive) { archive(persisted_, due_at_, holds_, holds_due_at_); }

}  // namespace cosiva::virtual_side
