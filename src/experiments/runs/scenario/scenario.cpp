#include "cosiva/experiments/runs/scenario/scenario.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <map>
#include <utility>

#include "cosiva/base/json_writer.h"
#include "cosiva/experiments/runs/scenario/toml_entry.h"
#include "cosiva/wire/messages/topics.h"
#include "cosiva/zone/toml/toml_node.h"
#include "cosiva/zone/toml/toml_table.h"

namespace cosiva::experiments {
namespace {

using zone::in_quotes;
using zone::NumberRange;
using zone::toml_number;

constexpr std::size_t bytes_max = 1U << 20U;
constexpr std::size_t entries_max = 10'000;
constexpr std::size_t path_points_max = 64;
constexpr std::int64_t aivs_max = 200;
constexpr std::size_t units_max = 64;

constexpr NumberRange time_s{"seconds since the fleet was complete, from 0 to 1000000", 0.0, 1e6};
constexpr NumberRange duration_range_s{"seconds over 0, at most 1000000", 0.0, 1e6, false};
constexpr NumberRange radius_range_m{"a radius from 0.02 to 1 m", 0.02, 1.0};
constexpr NumberRange walk_mps{"a speed over 0 m/s, at most 3 m/s", 0.0, 3.0, false};
constexpr NumberRange section_s_m{"metres along the section, from 0", 0.0, 1e5};
constexpr NumberRange ratio{"a ratio from 0 to 1, such as 0.3", 0.0, 1.0};

constexpr double virtual_object_radius_m = 0.05;

const std::vector<std::string_view> actions{"command",
                                            "go",
                                            "circulate",
                                            "person",
                                            "virtual_aiv",
                                            "virtual_obstacle",
                                            "physical_obstacle",
                                            "move",
                                            "remove",
                                            "close",
                                            "open",
                                            "switch",
                                            "radio",
                                            "priority",
                                            "fault",
                                            "unit"};
const std::vector<std::string_view> vehicle_commands{"stop",   "slow",    "medium",  "fast",   "restart",
                                                     "cancel", "exclude", "include", "retire", "self-test"};
const std::vector<std::string_view> module_faults{"stuck_sensor", "dead_motor", "failed_reader", "brown_out", "none"};
const std::vector<std::string_view> repeats{"once", "back and forth", "loop"};

std::string at_text(Point2 p) { return "(" + toml_number(p.x_m) + ", " + toml_number(p.y_m) + ")"; }

double length_m(const std::vector<Point2>& path) {
  double sum_m = 0.0;
  for (std::size_t i = 1; i < path.size(); ++i) sum_m += distance(path[i - 1], path[i]);
  return sum_m;
}

/// Rounded to centimetres: a path's exact length is irrelevant.
std::string rounded(double metres) { return toml_number(std::round(metres * 100.0) / 100.0); }

/// Begins {"command":"add","virtualObject":{…}}.
void begin_virtual_object(JsonWriter& json, std::string_view id, std::string_view kind) {
  json.begin_object().field("command", "add").key("virtualObject").begin_object();
  json.field("id", id).field("kind", kind);
}

/// The command of a fault of a vehicle's modules, and its text for display.
struct FaultStep {
  std::string command;
  std::string what;
};
FaultStep fault_step(const Entry& fields, const std::string& vehicle) {
  fields.expect_only({"vehicle", "kind", "for_s", "sensor", "reading", "motor"});
  const std::string name = vehicle.substr(vehicle.find('/') + 1);
  const std::string kind = fields.one_of("kind", module_faults);
  JsonWriter json;
  json.begin_object().field("command", "plant").key("plant").begin_object().key("setFault").begin_object();
  json.field("vehicle", vehicle).field("fault", kind);
  std::string what = name + (kind == "none" ? " has no fault any more" : ": " + kind);
  const auto only_for = [&](const char* field, std::string_view of) {
    if (fields.has(field) && kind != of)
      fields.fault(field, "scenario.field", "this field belongs to " + std::string(of));
    return fields.has(field) && kind == of;
  };
  if (only_for("sensor", "stuck_sensor")) json.field("sensor", fields.whole("sensor", 0, 7));
  if (only_for("reading", "stuck_sensor")) json.field("reading", fields.whole("reading", 0, 255));
  if (only_for("motor", "dead_motor")) json.field("motor", fields.one_of("motor", {"left", "right"}));
  if (fields.has("for_s") || kind == "brown_out") {
    constexpr NumberRange brown_out_s{"seconds over 0, at most 10", 0.0, 10.0, false};
    const double for_s = fields.number("for_s", kind == "brown_out" ? brown_out_s : duration_range_s);
    json.field("for_s", for_s);
    what += " for " + toml_number(for_s) + " s";
  }
  json.end_object().end_object().end_object();
  return {json.take(), std::move(what)};
}

/// Likewise of the switch of a crossing unit.
struct UnitStep {
  std::string crossing;
  std::string command;
  std::string what;
};
UnitStep unit_step(const Entry& fields) {
  fields.expect_only({"crossing", "on"});
  std::string crossing = fields.text("crossing", 64);
  if (!fields.has("on")) fields.fault("on", "scenario.field", "expected on = true or on = false");
  const bool on = fields.flag("on", false);
  JsonWriter json;
  json.begin_object().field("command", "plant").key("plant").begin_object().key("setUnit").begin_object();
  json.field("crossing", crossing).field("on", on).end_object().end_object().end_object();
  std::string what = "the unit of crossing " + crossing + " is switched " + (on ? "on" : "off");
  return {std::move(crossing), json.take(), std::move(what)};
}

/// Reads one file. Entries are read in time order, because `move` and `remove` refer to the objects present at their
/// time.
class Reader {
 public:
  Reader(zone::TomlFaults& faults, const toml::table& root) : root_{faults, root, ""} {}

  Scenario read() {
    read_head();
    struct Timed {
      SimDuration at;
      Entry entry;
    };
    std::vector<Timed> timed;
    for (const Entry& entry : root_.tables("at", entries_max)) {
      timed.push_back({from_seconds(entry.number("t_s", time_s)), entry});
      record_virtual_aiv(entry);
    }
    std::ranges::stable_sort(timed, {}, &Timed::at);
    for (const Timed& t : timed) {
      now_ = t.at;
      line_ = t.entry.line();
      read_action(t.entry);
    }
    // A loss ends before the next one begins at the same moment, whatever their order in the file.
    std::ranges::stable_sort(steps_, [](const Planned& a, const Planned& b) {
      return a.step.at != b.step.at ? a.step.at < b.step.at : a.ends && !b.ends;
    });
    for (Planned& planned : steps_) scenario_.steps.push_back(std::move(planned.step));
    return std::move(scenario_);
  }

 private:
  struct Planned {
    Scenario::Step step;
    bool ends{false};
  };
  struct VirtualObject {
    bool physical;
    double radius_m;
    std::uint32_t line;
  };

  void read_head() {
    root_.expect_only({"name", "description", "zone", "aivs", "seed", "duration_s", "crossing_units", "at"});
    scenario_.name = root_.text("name", 64);
    scenario_.description = root_.text("description", 2000, "");
    scenario_.zone = root_.text("zone", 1000, scenario_.zone);
    scenario_.aivs = static_cast<std::uint32_t>(root_.whole("aivs", 1, aivs_max, scenario_.aivs));
    scenario_.seed = static_cast<std::uint64_t>(root_.whole("seed", 0, INT64_MAX, 1));
    if (root_.has("crossing_units")) scenario_.crossing_units = root_.texts("crossing_units", units_max);
    if (root_.has("duration_s")) scenario_.duration_s = root_.number("duration_s", duration_range_s);
  }

  /// Commands may refer to a virtual AIV as "V1", so these names are needed before the first command is read.
  void record_virtual_aiv(const Entry& entry) {
    if (auto id = entry.peek("virtual_aiv", "id")) virtual_aivs_.push_back(std::move(*id));
  }

  void plan(std::string command, std::string what, SimDuration at, bool ends = false) {
    steps_.push_back({{at, std::move(command), std::move(what), line_}, ends});
  }
  void plan(JsonWriter& command, std::string what) { plan(command.take(), std::move(what), now_); }

  void read_action(const Entry& entry) {
    std::vector<std::string> found;
    for (const std::string_view action : actions) {
      if (entry.has(action)) found.emplace_back(action);
    }
    std::vector<std::string_view> known{"t_s"};
    if (entry.has("command")) known.insert(known.end(), {"vehicle", "vehicles"});
    known.insert(known.end(), actions.begin(), actions.end());
    entry.expect_only(known);
    if (found.size() != 1) {
      std::string list;
      for (const std::string_view action : actions) list.append(list.empty() ? "" : ", ").append(action);
      return entry.fault(found.empty() ? "" : found[1], "scenario.action",
                         found.empty() ? "expected exactly one action, found none. There are: " + list
                                       : "expected exactly one action, found " + in_quotes(found[0]) + " and " +
                                             in_quotes(found[1]) + "; give each its own [[at]]");
    }
    const std::string& action = found.front();
    if (action == "command") return read_command(entry);
    if (action == "remove") return read_remove(entry);
    if (action == "close" || action == "open") return read_closing(entry, action);
    if (action == "switch") return read_switch(entry);
    const auto fields = entry.table(action);
    if (!fields) return;
    if (action == "go") return read_go(*fields);
    if (action == "circulate") return read_circulate(*fields);
    if (action == "person") return read_person(*fields);
    if (action == "virtual_aiv") return read_virtual_aiv(*fields);
    if (action == "virtual_obstacle") return read_virtual_obstacle(*fields);
    if (action == "physical_obstacle") return read_physical_obstacle(*fields);
    if (action == "move") return read_move(*fields);
    if (action == "radio") return read_radio(*fields);
    if (action == "unit") {
      UnitStep step = unit_step(*fields);
      auto& switched = scenario_.switched_units;
      if (std::ranges::find(switched, step.crossing) == switched.end()) switched.push_back(step.crossing);
      return plan(std::move(step.command), std::move(step.what), now_);
    }
    if (action == "fault") {
      FaultStep step = fault_step(*fields, vehicle_id(*fields, "vehicle", fields->text("vehicle", 130)));
      return plan(std::move(step.command), std::move(step.what), now_);
    }
    return read_priority(*fields);
  }

  // --- vehicles -----------------------------------------------------------------------------------------------------

  /// "AIV2" and "V1" get their manufacturers; names with a manufacturer, and "*", are unchanged.
  [[nodiscard]] std::string vehicle_id(const Entry& fields, std::string_view key, const std::string& name) const {
    if (name == "*") return name;
    const std::size_t slash = name.find('/');
    const std::string serial = slash == std::string::npos ? name : name.substr(slash + 1);
    if (!name.empty() && (slash == 0 || !wire::valid_serial_number(serial))) {
      fields.fault(key, "scenario.vehicle",
                   "expected a vehicle, such as \"AIV1\", \"V1\" or \"CoSiVA/AIV1\", found " + in_quotes(name));
    }
    if (slash != std::string::npos) return name;
    const bool is_virtual = std::ranges::find(virtual_aivs_, name) != virtual_aivs_.end();
    return std::string(is_virtual ? wire::virtual_manufacturer : wire::our_manufacturer) + "/" + name;
  }

  void read_command(const Entry& entry) {
    const std::string command = entry.one_of("command", vehicle_commands);
    if (entry.has("vehicle") == entry.has("vehicles"))
      return entry.fault("command", "scenario.vehicle",
                         R"(expected vehicle = "AIV1", vehicle = "*" or vehicles = ["AIV1", "AIV2"])");
    const std::string_view key = entry.has("vehicle") ? "vehicle" : "vehicles";
    std::vector<std::string> names;
    if (key == "vehicle")
      names.push_back(entry.text(key, 130));
    else
      names = entry.texts(key, aivs_max);
    for (const std::string& name : names) {
      JsonWriter json;
      json.begin_object().field("command", command).field("vehicle", vehicle_id(entry, key, name)).end_object();
      plan(json, (name == "*" ? "all AIVs" : name) + ": " + command);
    }
  }

  void read_go(const Entry& fields) {
    fields.expect_only({"vehicle", "to"});
    const std::string name = fields.text("vehicle", 130);
    const std::string to = fields.text("to", 200);
    if (name == "*")
      return fields.fault("vehicle", "scenario.vehicle", "one vehicle at a time can go to a goal; name the vehicle");
    JsonWriter json;
    json.begin_object().field("command", "go").field("vehicle", vehicle_id(fields, "vehicle", name)).field("to", to);
    json.end_object();
    plan(json, name + " goes to " + to);
  }

  void read_circulate(const Entry& fields) {
    fields.expect_only({"vehicle", "loop"});
    const std::string name = fields.text("vehicle", 130, "*");
    const std::string loop = fields.text("loop", 200, "");
    JsonWriter json;
    json.begin_object().field("command", "circulate").field("vehicle", vehicle_id(fields, "vehicle", name));
    if (!loop.empty()) json.field("loop", loop);
    json.end_object();
    plan(json, (name == "*" ? "all AIVs circulate" : name + " circulates") + (loop.empty() ? "" : " on " + loop));
  }

  void read_priority(const Entry& fields) {
    JsonWriter json;
    json.begin_object().field("command", "edit").key("edit").begin_object().key("priorities").begin_object();
    std::string what;
    for (const std::string& name : fields.keys()) {
      const std::int64_t priority = fields.whole(name, 0, 999);
      json.field(vehicle_id(fields, "", name), priority);
      what += (what.empty() ? "" : ", ") + name + " " + std::to_string(priority);
    }
    json.end_object().end_object().end_object();
    if (what.empty()) return fields.fault("", "scenario.field", "expected vehicles and numbers, such as { AIV1 = 3 }");
    plan(json, "priority: " + what);
  }

  void read_radio(const Entry& fields) {
    fields.expect_only({"vehicle", "loss", "for_s"});
    const std::string name = fields.text("vehicle", 130);
    const std::string vehicle = vehicle_id(fields, "vehicle", name);
    const double loss = fields.number("loss", ratio);
    const auto command = [&](double part) {
      JsonWriter json;
      json.begin_object().field("command", "radio").field("vehicle", vehicle).field("loss", part).end_object();
      return json.take();
    };
    const std::string owner_name = name == "*" ? "every vehicle" : name;
    std::string what = loss > 0.0 ? owner_name + " loses " + toml_number(loss * 100.0) + " % of its messages"
                                  : owner_name + " receives and sends again";
    if (!fields.has("for_s")) return plan(command(loss), std::move(what), now_);
    const double for_s = fields.number("for_s", duration_range_s);
    what += " for " + toml_number(for_s) + " s";
    plan(command(loss), std::move(what), now_);
    plan(command(0.0), owner_name + " receives and sends again", now_ + from_seconds(for_s), true);
  }

  // --- the zone -----------------------------------------------------------------------------------------------------

  void read_closing(const Entry& entry, const std::string& action) {
    const std::string section = entry.text(action, 200);
    JsonWriter json;
    json.begin_object().field("command", action).field("section", section).end_object();
    plan(json, section + (action == "close" ? " is closed" : " is open again"));
  }

  void read_switch(const Entry& entry) {
    std::string zone = entry.text("switch", 1000);
    JsonWriter json;
    json.begin_object().field("command", "switch").end_object();
    plan(json, "the zone is switched to " + zone);
    steps_.back().step.zone = std::move(zone);
  }

  // --- virtual and physical objects ---------------------------------------------------------------------------------

  [[nodiscard]] std::string read_id(const Entry& fields) const {
    std::string id = fields.text("id", 32);
    // A virtual AIV's id is its serial number; one rule for all ids is simpler.
    if (!id.empty() && !wire::valid_serial_number(id))
      fields.fault("id", "scenario.field", "expected an id of A-Z a-z 0-9 _ . : - only, found " + in_quotes(id));
    const auto is_digit = [](char c) { return c >= '0' && c <= '9'; };
    if (id.size() > 1 && id.front() == 'S' && std::all_of(id.begin() + 1, id.end(), is_digit))
      fields.fault("id", "scenario.id", "S1, S2, … are the names of detected obstacles; choose another");
    return id;
  }

  /// Writes the end of {"command":…,"virtualObject":{…: the object's position, or its walk. Returns the description.
  [[nodiscard]] std::string write_motion(const Entry& fields, JsonWriter& json) const {
    if (fields.has("at") == fields.has("path")) {
      fields.fault(fields.has("at") ? "path" : "", "scenario.field",
                   "expected either at = [x, y] or path = [[x, y], [x, y]]");
      return {};
    }
    if (fields.has("at")) {
      for (const char* only_walking : {"speed_mps", "repeat"}) {
        if (fields.has(only_walking))
          fields.fault(only_walking, "scenario.field",
                       "a stationary object has none; give path instead of at to let it walk");
      }
      const Point2 at = fields.point("at");
      json.field("x", at.x_m).field("y", at.y_m);
      return at_text(at);
    }
    const std::vector<Point2> path = fields.points("path", path_points_max);
    json.key("path").begin_array();
    for (const Point2 p : path) json.begin_array().value(p.x_m).value(p.y_m).end_array();
    json.end_array();
    const double distance_m = length_m(path);
    if (!path.empty() && !(distance_m > 0.0))
      fields.fault("path", "scenario.field", "expected points apart from each other");
    std::string what = " walks " + rounded(distance_m) + " m from " + (path.empty() ? "" : at_text(path.front()));
    if (fields.has("speed_mps")) {
      const double speed_mps = fields.number("speed_mps", walk_mps);
      json.field("speed", speed_mps);
      what += " at " + toml_number(speed_mps) + " m/s";
    }
    const std::string repeat = fields.one_of("repeat", repeats, "once");
    json.field("repeat", repeat);
    return what + (repeat == "loop" ? ", round and round" : repeat == "once" ? "" : ", " + repeat);
  }

  void read_person(const Entry& fields) {
    fields.expect_only({"id", "at", "path", "speed_mps", "repeat", "radius_m"});
    const std::string id = read_id(fields);
    JsonWriter json;
    begin_virtual_object(json, id, "person");
    const std::string motion_text = write_motion(fields, json);
    if (fields.has("radius_m")) json.field("radius", fields.number("radius_m", radius_range_m));
    json.end_object().end_object();
    virtual_objects_.insert_or_assign(id, VirtualObject{false, 0.0, line_});
    plan(json, "person " + id + (fields.has("at") ? " is at " : "") + motion_text);
  }

  void read_virtual_aiv(const Entry& fields) {
    fields.expect_only({"id", "section", "s_m", "at"});
    const std::string id = read_id(fields);
    if (fields.has("at") && (fields.has("section") || fields.has("s_m")))
      fields.fault("at", "scenario.field", "expected either section and s_m, or at = [x, y], or no position at all");
    if (fields.has("section") != fields.has("s_m"))
      fields.fault("", "scenario.field", R"(section and s_m go together, as in section = "east", s_m = 0.5)");
    JsonWriter json;
    begin_virtual_object(json, id, "aiv");
    std::string where = " where there is room";
    if (fields.has("section")) {
      const std::string section = fields.text("section", 64);
      const double s_m = fields.number("s_m", section_s_m);
      json.field("section", section).field("s", s_m);
      where = " on " + section + " at " + toml_number(s_m) + " m";
    } else if (fields.has("at")) {
      const Point2 at = fields.point("at");
      json.field("x", at.x_m).field("y", at.y_m);
      where = " near " + at_text(at);
    }
    json.end_object().end_object();
    virtual_objects_.insert_or_assign(id, VirtualObject{false, 0.0, line_});
    plan(json, "virtual AIV " + id + " joins" + where);
  }

  void read_virtual_obstacle(const Entry& fields) {
    fields.expect_only({"id", "at", "radius_m"});
    const std::string id = read_id(fields);
    const Point2 at = fields.point("at");
    const double radius_m = fields.number("radius_m", radius_range_m, virtual_object_radius_m);
    JsonWriter json;
    begin_virtual_object(json, id, "obstacle");
    json.field("x", at.x_m).field("y", at.y_m).field("radius", radius_m).end_object().end_object();
    virtual_objects_.insert_or_assign(id, VirtualObject{false, radius_m, line_});
    plan(json, "virtual obstacle " + id + " at " + at_text(at));
  }

  void write_physical(const std::string& id, Point2 at, double radius_m, std::string what) {
    JsonWriter json;
    json.begin_object().field("command", "plant").key("plant").begin_object().key("addObstacle").begin_object();
    json.field("id", id).field("x", at.x_m).field("y", at.y_m).field("radius", radius_m);
    json.end_object().end_object().end_object();
    plan(json, std::move(what));
  }

  void read_physical_obstacle(const Entry& fields) {
    fields.expect_only({"id", "at", "radius_m"});
    const std::string id = read_id(fields);
    const Point2 at = fields.point("at");
    const double radius_m = fields.number("radius_m", radius_range_m, virtual_object_radius_m);
    if (const auto known = virtual_objects_.find(id); known != virtual_objects_.end() && known->second.physical) {
      return fields.fault("id", "scenario.id",
                          "there is a physical obstacle " + in_quotes(id) + " already, since line " +
                              std::to_string(known->second.line) + "; use move to change its position");
    }
    virtual_objects_.insert_or_assign(id, VirtualObject{true, radius_m, line_});
    write_physical(id, at, radius_m, "physical obstacle " + id + " at " + at_text(at));
  }

  void read_move(const Entry& fields) {
    fields.expect_only({"id", "at", "path", "speed_mps", "repeat"});
    const std::string id = read_id(fields);
    const auto known = virtual_objects_.find(id);
    if (known != virtual_objects_.end() && known->second.physical) {
      for (const char* only_walking : {"path", "speed_mps", "repeat"}) {
        if (fields.has(only_walking))
          return fields.fault(only_walking, "scenario.field", "a physical obstacle does not walk; move it with at");
      }
      const Point2 at = fields.point("at");
      // For the emulated world an obstacle of the same name is the old one at its new position.
      return write_physical(id, at, known->second.radius_m, id + " moves to " + at_text(at));
    }
    JsonWriter json;
    json.begin_object().field("command", "move").key("virtualObject").begin_object().field("id", id);
    const std::string motion_text = write_motion(fields, json);
    json.end_object().end_object();
    plan(json, id + (fields.has("at") ? " moves to " : "") + motion_text);
  }

  void remove_physical(const std::string& id) {
    JsonWriter json;
    json.begin_object().field("command", "plant").key("plant").begin_object().field("removeObstacle", id);
    json.end_object().end_object();
    plan(json, "physical obstacle " + id + " is removed");
  }

  void read_remove(const Entry& entry) {
    const std::string id = entry.text("remove", 64);
    const auto known = virtual_objects_.find(id);
    if (known != virtual_objects_.end() && known->second.physical) {
      remove_physical(id);
    } else {
      JsonWriter json;
      json.begin_object().field("command", "remove").field("id", id).end_object();
      plan(json, id == "*" ? "everything virtual is removed" : id + " is removed");
    }
    if (id != "*") {
      virtual_objects_.erase(id);
      return;
    }
    for (const auto& [name, virtual_object] : virtual_objects_) {
      if (virtual_object.physical) remove_physical(name);
    }
    virtual_objects_.clear();
  }

  Entry root_;
  Scenario scenario_;
  std::vector<Planned> steps_;
  std::vector<std::string> virtual_aivs_;
  std::map<std::string, VirtualObject> virtual_objects_;  ///< present at this point of the file
  SimDuration now_{};
  std::uint32_t line_{};
};

}  // namespace

Result<Scenario> scenario_from_toml(std::string_view text, const std::string& origin) {
  if (text.size() > bytes_max) {
    return fail("scenario.size", "expected at most 1 MiB, found " + std::to_string(text.size()) + " bytes", origin);
  }
  zone::TomlFaults faults{origin, Entry::family};
  try {
    const toml::table root = toml::parse(text);
    Scenario scenario = Reader{faults, root}.read();
    if (faults.any()) return tl::unexpected(faults.first());
    return scenario;
  } catch (const toml::parse_error& error) {
    faults.add("scenario.syntax", static_cast<std::uint32_t>(error.source().begin.line), "",
               std::string(error.description()));
    return tl::unexpected(faults.first());
  } catch (const std::exception& error) {
    return fail("scenario.syntax", std::string("cannot be read: ") + error.what(), origin);
  }
}

}  // namespace cosiva::experiments
