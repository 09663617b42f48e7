// An edit as the page sends it (docs/protocols/hmi-api.md).
#include "cosiva/zone/edit/edit_json.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "cosiva/zone/layout/rounding.h"

namespace cosiva::zone {
namespace {

// Further from every section no antenna would ever read the tag: the click meant something else.
constexpr double off_path_m_max = 0.30;

std::optional<TagNumber> tag_number(const JsonValue& json) {
  const double* number = json.number();
  if (number == nullptr || !(*number >= 1.0 && *number <= tag_number_max) || *number != std::floor(*number))
    return std::nullopt;
  return static_cast<TagNumber>(*number);
}

class Reader {
 public:
  Reader(const JsonValue& json, const TrafficZone& zone) : json_{json}, zone_{zone} {}

  Result<ZoneEdit> read() {
    if (json_.object() == nullptr) return fail("edit.syntax", R"(an edit is an object, such as {"removeTags":[3]})");
    check_keys();
    read_tags("addTags", false);
    read_tags("moveTags", true);
    read_removals();
    read_pitch();
    read_beacons();
    read_priorities();
    if (error_) return tl::unexpected(std::move(*error_));
    if (const auto zone = with_edit(zone_, edit_); !zone) return tl::unexpected(zone.error());
    return std::move(edit_);
  }

 private:
  static constexpr std::array<std::string_view, 6> known{"addTags",     "moveTags", "removeTags",
                                                         "beaconPitch", "beacons",  "priorities"};

  /// The first fault stays.
  void fault(std::string code, std::string message, std::string position) {
    if (!error_) error_ = Error{std::move(code), std::move(message), std::move(position)};
  }

  void check_keys() {
    if (json_.object()->empty())
      fault("edit.empty", "this edit changes nothing; name a tag, the beacons or a priority", "");
    for (const auto& [key, value] : *json_.object()) {
      if (std::find(known.begin(), known.end(), key) == known.end())
        fault("edit.field",
              "an edit knows addTags, moveTags, removeTags, beacons, beaconPitch and priorities; this is none",
              key.substr(0, 64));
    }
  }

  [[nodiscard]] const JsonValue::Array* list(std::string_view key) {
    const JsonValue* given = json_.find(key);
    if (given == nullptr) return nullptr;
    if (given->array() == nullptr) fault("edit.field", "this must be a list", std::string(key));
    return given->array();
  }

  void read_tags(std::string_view key, bool moved) {
    const auto* given = list(key);
    if (given == nullptr) return;
    for (const JsonValue& tag : *given) {
      const JsonValue* number_json = tag.find("number");
      const auto number = number_json == nullptr ? std::nullopt : tag_number(*number_json);
      if (!number)
        return fault("edit.number", "give each tag a 'number', whole, from 1 to 4000000000", std::string(key));
      const bool there = zone_.find_tag(*number) != nullptr;
      const std::string name = "tag " + std::to_string(*number);
      if (moved && !there) return fault("edit.tag", "there is no " + name + " to move; add it", name);
      if (!moved && there)
        return fault("edit.tag", name + " is already there; move it, or choose another number", name);
      if (const auto position = read_position(tag, name)) edit_.set_tags.push_back({*number, *position});
    }
  }

  [[nodiscard]] std::optional<TrackPosition> read_position(const JsonValue& tag, const std::string& name) {
    const auto section = tag.text("section");
    const auto s_m = tag.number("s");
    const auto x_m = tag.number("x");
    const auto y_m = tag.number("y");
    if (section && s_m) {
      const auto id = zone_.circuit.find(*section);
      if (id) return TrackPosition{*id, *s_m};
      fault("edit.section", "the zone has no section '" + section->substr(0, 64) + "'; use one of its names", name);
    } else if (x_m && y_m && std::isfinite(*x_m) && std::isfinite(*y_m)) {
      const auto located = zone_.circuit.locate({*x_m, *y_m});
      if (located.distance_m <= off_path_m_max) return located.position;
      fault("edit.position",
            "this is " + metres_text(located.distance_m) +
                " m from the nearest section; put the tag within 0.30 m of one",
            name);
    } else {
      fault("edit.position", "give the position: 'x' and 'y' in metres, or 'section' and 's'", name);
    }
    return std::nullopt;
  }

  void read_removals() {
    const auto* given = list("removeTags");
    if (given == nullptr) return;
    for (const JsonValue& one : *given) {
      const auto number = tag_number(one);
      if (!number) return fault("edit.number", "name the tags to take away by their numbers", "removeTags");
      edit_.remove_tags.push_back(*number);
    }
  }

  void read_pitch() {
    const JsonValue* given = json_.find("beaconPitch");
    if (given == nullptr) return;
    if (given->number() == nullptr || !std::isfinite(*given->number()))
      return fault("edit.pitch", "give the beacons' pitch as a number of metres", "beaconPitch");
    edit_.beacon_pitch_m = *given->number();
  }

  void read_beacons() {
    const JsonValue* given = json_.find("beacons");
    if (given == nullptr) return;
    if (given->object() == nullptr || given->object()->empty())
      return fault("edit.field", R"(give the beacons' position, such as {"pitch":0.3,"origin":[0,0],"rotation":0})",
                   "beacons");
    for (const auto& [key, value] : *given->object()) {
      if (key == "pitch")
        read_number(value, edit_.beacon_pitch_m, "edit.pitch", "give the beacons' pitch as a number of metres");
      else if (key == "rotation")
        read_number(value, edit_.beacon_rotation_rad, "edit.rotation", "give the rotation as a number of radians");
      else if (key == "origin")
        read_origin(value);
      else
        fault("edit.field", "beacons have a pitch, an origin and a rotation; this is none", key.substr(0, 64));
    }
    if (json_.find("beaconPitch") != nullptr && given->find("pitch") != nullptr)
      fault("edit.twice", "the beacons' pitch occurs in this edit twice", "beacons");
  }

  void read_number(const JsonValue& value, std::optional<double>& out, std::string code, std::string message) {
    if (value.number() == nullptr || !std::isfinite(*value.number()))
      return fault(std::move(code), std::move(message), "beacons");
    out = *value.number();
  }

  void read_origin(const JsonValue& value) {
    const auto* xy = value.array();
    const bool good = xy != nullptr && xy->size() == 2 && (*xy)[0].number() != nullptr && (*xy)[1].number() != nullptr;
    if (!good) return fault("edit.origin", "give the beacons' origin as [x, y] in metres", "beacons");
    edit_.beacon_origin = Point2{*(*xy)[0].number(), *(*xy)[1].number()};
  }

  void read_priorities() {
    const JsonValue* given = json_.find("priorities");
    if (given == nullptr) return;
    if (given->object() == nullptr)
      return fault("edit.priority", R"(give priorities as an object, such as {"CoSiVA/AIV1":3})", "priorities");
    for (const auto& [vehicle, value] : *given->object()) {
      const double* priority = value.number();
      if (priority == nullptr || !(*priority >= 0.0 && *priority <= priority_max) || *priority != std::floor(*priority))
        return fault("edit.priority", "a priority is a whole number from 0 to 999", vehicle.substr(0, 64));
      edit_.set_priorities.emplace_back(vehicle, static_cast<std::int32_t>(*priority));
    }
  }

  const JsonValue& json_;
  const TrafficZone& zone_;
  ZoneEdit edit_;
  std::optional<Error> error_;
};

}  // namespace

Result<ZoneEdit> zone_edit_from_json(const JsonValue& json, const TrafficZone& zone) {
  return Reader{json, zone}.read();
}

}  // namespace cosiva::zone
