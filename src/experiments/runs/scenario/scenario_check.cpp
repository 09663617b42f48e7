#include "cosiva/experiments/runs/scenario/scenario_check.h"

#include <algorithm>
#include <charconv>
#include <map>
#include <memory>
#include <set>

#include "cosiva/base/json_value.h"
#include "cosiva/base/json_writer.h"
#include "cosiva/experiments/runs/scenario/toml_entry.h"
#include "cosiva/wire/messages/topics.h"
#include "cosiva/zone/drawing/draw.h"
#include "cosiva/zone/rtm/rtm.h"
#include "cosiva/zone/toml/toml_node.h"
#include "cosiva/zone/toml/toml_table.h"

namespace cosiva::experiments {
namespace {

using zone::in_quotes;
using zone::nearest;
using zone::toml_number;

/// A virtual AIV is added on the nearest path; a larger distance is an error.
constexpr double off_path_m_max = 0.30;
/// As in the server: the greatest distance of an object beyond the drawing's bounds.
constexpr double margin_m = 0.5;
/// A zone's file of 16 MiB with every byte escaped.
constexpr std::size_t command_bytes_max = std::size_t{128} << 20U;

struct VirtualObject {
  std::string kind;  ///< "aiv", "person", "obstacle", "physical obstacle"
  std::uint32_t line;
};

std::string at_seconds(SimDuration at) { return "at " + toml_number(to_seconds(at)) + " s"; }

std::vector<std::string_view> crossing_names(const zone::TrafficZone& zone) {
  std::vector<std::string_view> names;
  for (const zone::Crossing& crossing : zone.crossings) names.push_back(crossing.name);
  return names;
}

class Checker {
 public:
  Checker(const Scenario& scenario, const zone::TrafficZone& zone, const std::string& origin)
      : scenario_{scenario}, faults_{origin, Entry::family} {
    enter(zone);
    for (const Scenario::Step& step : scenario.steps) record_arrival(step);
  }

  Result<void> run() {
    if (const std::size_t room = zone_->start_positions(scenario_.aivs).size(); room < scenario_.aivs) {
      faults_.add("scenario.aivs", 1, "aivs",
                  zone_->name + " has room for " + std::to_string(room) + " AIVs to start, not " +
                      std::to_string(scenario_.aivs));
    }
    for (const std::string& crossing : scenario_.crossing_units)
      if (const auto known = crossing_names(*zone_);
          crossing != "all" && std::ranges::find(known, crossing) == known.end())
        faults_.add("scenario.crossing", 1, "crossing_units", zone_->name + " has no crossing " + in_quotes(crossing));
    for (const Scenario::Step& step : scenario_.steps) {
      if (faults_.any()) break;
      step_ = &step;
      if (scenario_.duration_s && step.at > from_seconds(*scenario_.duration_s)) {
        fault("t_s", "scenario.never",
              at_seconds(step.at) + " the scenario is over: it lasts " + toml_number(*scenario_.duration_s) +
                  " s (duration_s)");
      }
      const auto command = JsonValue::parse(step.command, command_bytes_max);
      if (command) evaluate(*command);
    }
    if (faults_.any()) return tl::unexpected(faults_.first());
    return {};
  }

 private:
  void fault(std::string_view field, std::string code, std::string message) {
    faults_.add(std::move(code), step_->line, field, std::move(message));
  }

  /// Records when each virtual AIV is added, to distinguish "not yet" from "never".
  void record_arrival(const Scenario::Step& step) {
    const auto command = JsonValue::parse(step.command);
    const JsonValue* virtual_object = command ? command->find("virtualObject") : nullptr;
    if (virtual_object != nullptr && command->text("command") == "add" && virtual_object->text("kind") == "aiv")
      arrivals_.emplace(virtual_object->text("id").value_or(""), step.at);
  }

  /// Sets the zone in force from here on.
  void enter(const zone::TrafficZone& zone) {
    zone_ = &zone;
    bounds_ = zone::bounds(zone::draw(zone));
    closed_.clear();
    for (const zone::SectionId section : zone.closed) closed_.insert(zone.circuit.part(section).name);
  }

  void evaluate(const JsonValue& command) {
    const std::string what = command.text("command").value_or("");
    if (what == "switch") return evaluate_switch(command);
    if (what == "close" || what == "open") return evaluate_closing(command.text("section").value_or(""), what);
    if (what == "go") evaluate_goal(command.text("to").value_or(""));
    if (what == "circulate") evaluate_loop(command.text("loop"));
    if (what == "add") return evaluate_add(*command.find("virtualObject"));
    if (what == "move") return evaluate_move(*command.find("virtualObject"));
    if (what == "remove") return evaluate_remove(command.text("id").value_or(""), false);
    if (what == "plant") return evaluate_plant(*command.find("plant"));
    if (what == "radio") return evaluate_radio(command);
    if (what == "edit") {
      for (const auto& [id, priority] : *command.find("edit")->find("priorities")->object())
        evaluate_vehicle(id, "priority");
      return;
    }
    evaluate_vehicle(command.text("vehicle").value_or(""), "vehicle");
  }

  // --- the zone -----------------------------------------------------------------------------------------------------

  void evaluate_switch(const JsonValue& command) {
    const JsonValue* given = command.find("zone");
    auto configuration = given == nullptr
                             ? Result<zone::ZoneConfiguration>{fail("scenario.zone", "this zone was not resolved")}
                             : zone::zone_configuration_from_json(*given);
    auto rtm = configuration ? zone::Rtm::initialise(std::move(*configuration))
                             : Result<zone::Rtm>{tl::unexpected(configuration.error())};
    if (!rtm) return fault("switch", rtm.error().code, to_string(rtm.error()));
    switched_to_ = rtm->shared_zone();
    enter(*switched_to_);
  }

  void fault_name(std::string_view field, std::string code, const std::string& what, const std::string& name,
                  const std::vector<std::string_view>& known) {
    const std::string_view near = nearest(name, known);
    fault(field, std::move(code),
          zone_->name + " has no " + what + " " + in_quotes(name) +
              (near.empty() ? "" : "; did you mean " + in_quotes(near) + "?"));
  }

  [[nodiscard]] std::vector<std::string_view> section_names() const {
    std::vector<std::string_view> names;
    for (zone::SectionId id = 0; id < zone_->circuit.size(); ++id) names.push_back(zone_->circuit.part(id).name);
    return names;
  }

  void evaluate_closing(const std::string& section, const std::string& what) {
    if (!zone_->circuit.find(section)) return fault_name(what, "scenario.section", "section", section, section_names());
    const bool changes = what == "close" ? closed_.insert(section).second : closed_.erase(section) > 0;
    if (!changes)
      fault(what, "scenario.section",
            section + (what == "close" ? " is closed already " : " is not closed ") + at_seconds(step_->at));
  }

  void evaluate_goal(const std::string& to) {
    if (zone_->find_station(to) != nullptr || zone_->find_waypoint(to) != nullptr) return;
    std::vector<std::string_view> known;
    for (const zone::Station& station : zone_->stations) known.push_back(station.name);
    for (const zone::Waypoint& waypoint : zone_->waypoints) known.push_back(waypoint.id);
    fault_name("go.to", "scenario.goal", "station or waypoint", to, known);
  }

  void evaluate_loop(const std::optional<std::string>& loop) {
    if (!loop || zone_->find_loop(*loop) != nullptr) return;
    std::vector<std::string_view> known;
    for (const zone::Loop& one : zone_->loops) known.push_back(one.name);
    fault_name("circulate.loop", "scenario.loop", "loop", *loop, known);
  }

  // --- vehicles -----------------------------------------------------------------------------------------------------

  void evaluate_vehicle(const std::string& id, std::string_view field) {
    if (id == "*") return;
    const std::size_t slash = id.find('/');
    const std::string manufacturer = id.substr(0, slash);
    const std::string serial = slash == std::string::npos ? "" : id.substr(slash + 1);
    if (manufacturer == wire::virtual_manufacturer) return evaluate_virtual_vehicle(serial, field);
    if (manufacturer == wire::our_manufacturer && number_of(serial)) return;
    const std::vector<std::string> there = vehicles_now();
    const std::string_view near = nearest(serial, {there.begin(), there.end()});
    fault(field, "scenario.vehicle",
          "there is no vehicle " + in_quotes(manufacturer == wire::our_manufacturer ? serial : id) +
              "; this scenario has " + (scenario_.aivs == 1 ? "AIV1" : "AIV1 to AIV" + std::to_string(scenario_.aivs)) +
              (near.empty() ? "" : ", did you mean " + in_quotes(near) + "?"));
  }

  void evaluate_virtual_vehicle(const std::string& serial, std::string_view field) {
    const auto virtual_object = virtual_objects_.find(serial);
    if (virtual_object != virtual_objects_.end() && virtual_object->second.kind == "aiv") return;
    const auto arrival = arrivals_.find(serial);
    std::string why = "no virtual_aiv of this name is ever added";
    if (arrival != arrivals_.end())
      why = arrival->second > step_->at ? "it is only added " + at_seconds(arrival->second) : "it was removed before";
    fault(field, "scenario.vehicle",
          "there is no virtual AIV " + in_quotes(serial) + " " + at_seconds(step_->at) + ": " + why);
  }

  /// "AIV3" of a fleet of at least three.
  [[nodiscard]] bool number_of(std::string_view serial) const {
    if (!serial.starts_with("AIV") || serial.size() < 4 || serial[3] == '0') return false;
    std::uint32_t number = 0;
    const char* end = serial.data() + serial.size();
    const auto [stop, error] = std::from_chars(serial.data() + 3, end, number);
    return error == std::errc{} && stop == end && number >= 1 && number <= scenario_.aivs;
  }

  [[nodiscard]] std::vector<std::string> vehicles_now() const {
    std::vector<std::string> names;
    for (std::uint32_t number = 1; number <= scenario_.aivs; ++number) names.push_back("AIV" + std::to_string(number));
    for (const auto& [id, virtual_object] : virtual_objects_) {
      if (virtual_object.kind == "aiv") names.push_back(id);
    }
    return names;
  }

  void evaluate_radio(const JsonValue& command) {
    const std::string id = command.text("vehicle").value_or("");
    if (id.starts_with(std::string(wire::virtual_manufacturer) + "/"))
      return fault("radio.vehicle", "scenario.radio", "a virtual AIV runs in the server and has no radio");
    evaluate_vehicle(id, "radio.vehicle");
    const bool begins = command.number("loss").value_or(0.0) > 0.0;
    for (const auto& [other, line] : lossy_) {
      // The loss that ends first would end the other loss as well.
      if (begins && (other == id || other == "*" || id == "*")) {
        return fault("radio", "scenario.radio",
                     "the loss of line " + std::to_string(line) + " is not over yet " + at_seconds(step_->at) +
                         "; let it end first (for_s)");
      }
    }
    if (begins)
      lossy_.insert_or_assign(id, step_->line);
    else if (id == "*")
      lossy_.clear();
    else
      lossy_.erase(id);
  }

  // --- virtual and physical objects ---------------------------------------------------------------------------------

  void evaluate_new(const std::string& id, std::string kind) {
    const auto [known, is_new] = virtual_objects_.emplace(id, VirtualObject{std::move(kind), step_->line});
    if (!is_new) {
      fault("id", "scenario.id",
            "there is a " + known->second.kind + " " + in_quotes(id) + " already, since line " +
                std::to_string(known->second.line) + "; remove it first, or choose another id");
    }
  }

  void evaluate_point(double x_m, double y_m, std::string_view field) {
    if (x_m >= bounds_.low.x_m - margin_m && x_m <= bounds_.high.x_m + margin_m && y_m >= bounds_.low.y_m - margin_m &&
        y_m <= bounds_.high.y_m + margin_m)
      return;
    fault(field, "scenario.position",
          "(" + toml_number(x_m) + ", " + toml_number(y_m) + ") is off the zone " + zone_->name +
              ", which extends from (" + toml_number(bounds_.low.x_m) + ", " + toml_number(bounds_.low.y_m) + ") to (" +
              toml_number(bounds_.high.x_m) + ", " + toml_number(bounds_.high.y_m) + ") m");
  }

  void evaluate_route(const JsonValue& virtual_object) {
    if (const JsonValue* path = virtual_object.find("path"); path != nullptr && path->array() != nullptr) {
      for (const JsonValue& p : *path->array())
        evaluate_point(*p.array()->at(0).number(), *p.array()->at(1).number(), "path");
    } else if (virtual_object.number("x") && virtual_object.number("y")) {
      evaluate_point(*virtual_object.number("x"), *virtual_object.number("y"), "at");
    }
  }

  void evaluate_add(const JsonValue& virtual_object) {
    const std::string kind = virtual_object.text("kind").value_or("");
    evaluate_new(virtual_object.text("id").value_or(""), kind);
    if (kind == "aiv")
      evaluate_aiv_position(virtual_object);
    else
      evaluate_route(virtual_object);
  }

  void evaluate_aiv_position(const JsonValue& virtual_object) {
    std::optional<zone::TrackPosition> location;
    if (const auto name = virtual_object.text("section")) {
      const auto section = zone_->circuit.find(*name);
      if (!section) return fault_name("virtual_aiv.section", "scenario.section", "section", *name, section_names());
      const double length_m = zone_->circuit.section(*section).length_m();
      location = zone::TrackPosition{*section, virtual_object.number("s").value_or(0.0)};
      if (location->s_m > length_m) {
        return fault("virtual_aiv.s_m", "scenario.position",
                     *name + " is " + toml_number(length_m) + " m long, so s_m must be from 0 to that");
      }
    } else if (virtual_object.number("x") && virtual_object.number("y")) {
      const Point2 at{*virtual_object.number("x"), *virtual_object.number("y")};
      const auto located = zone_->circuit.locate(at);
      if (located.distance_m > off_path_m_max) {
        return fault("virtual_aiv.at", "scenario.position",
                     "the nearest path of " + zone_->name + " is " + toml_number(located.distance_m) +
                         " m away; add it within " + toml_number(off_path_m_max) + " m of a path");
      }
      location = located.position;
    }
    if (!location || zone_->may_stop(*location)) return;
    const zone::Crossing* crossing = zone_->crossing_at(*location);
    fault("virtual_aiv", "scenario.position",
          "no vehicle may stop " +
              (crossing == nullptr ? std::string("between crossings this close together")
                                   : "in crossing " + crossing->name) +
              "; choose a position before or behind it");
  }

  void evaluate_move(const JsonValue& virtual_object) {
    const std::string id = virtual_object.text("id").value_or("");
    const auto known = virtual_objects_.find(id);
    if (known == virtual_objects_.end()) return fault_unknown(id, "move.id");
    if (known->second.kind == "aiv")
      return fault("move.id", "scenario.id",
                   in_quotes(id) + " is a virtual AIV: it drives by itself, and is not moved");
    if (known->second.kind != "person" && virtual_object.find("path") != nullptr)
      return fault("move.path", "scenario.field", in_quotes(id) + " is an obstacle and does not walk; move it with at");
    evaluate_route(virtual_object);
  }

  void evaluate_remove(const std::string& id, bool physical) {
    if (id == "*") {
      std::erase_if(virtual_objects_, [](const auto& entry) { return entry.second.kind != "physical obstacle"; });
      return;
    }
    const auto known = virtual_objects_.find(id);
    if (known == virtual_objects_.end() || (known->second.kind == "physical obstacle") != physical)
      return fault_unknown(id, "remove");
    virtual_objects_.erase(known);
  }

  void evaluate_plant(const JsonValue& plant) {
    if (const JsonValue* given = plant.find("setFault")) {
      const std::string id = given->text("vehicle").value_or("");
      if (id.starts_with(std::string(wire::our_manufacturer) + "/AIV")) return evaluate_vehicle(id, "fault.vehicle");
      return fault("fault.vehicle", "scenario.fault",
                   "only vehicles of the emulated world have faults: AIV1 to AIV" + std::to_string(scenario_.aivs));
    }
    if (const JsonValue* unit = plant.find("setUnit")) {
      const std::string crossing = unit->text("crossing").value_or("");
      const std::vector<std::string_view> known = crossing_names(*zone_);
      if (std::ranges::find(known, crossing) == known.end())
        fault_name("unit.crossing", "scenario.crossing", "crossing", crossing, known);
      return;
    }
    const JsonValue* added = plant.find("addObstacle");
    if (added == nullptr) return evaluate_remove(plant.text("removeObstacle").value_or(""), true);
    const std::string id = added->text("id").value_or("");
    const auto known = virtual_objects_.find(id);
    // The reader has ensured that a second object of this id is the first one moved.
    const bool moved = known != virtual_objects_.end() && known->second.kind == "physical obstacle";
    if (!moved) evaluate_new(id, "physical obstacle");
    evaluate_route(*added);
  }

  void fault_unknown(const std::string& id, std::string_view field) {
    std::vector<std::string_view> there;
    for (const auto& [name, virtual_object] : virtual_objects_) there.push_back(name);
    const std::string_view near = nearest(id, there);
    fault(field, "scenario.id",
          "there is no object " + in_quotes(id) + " " + at_seconds(step_->at) +
              (near.empty() ? "" : "; did you mean " + in_quotes(near) + "?"));
  }

  const Scenario& scenario_;
  const zone::TrafficZone* zone_{};                       ///< in force at this step
  std::shared_ptr<const zone::TrafficZone> switched_to_;  ///< owns the zone, when a step has switched to it
  zone::Bounds bounds_{};
  std::set<std::string> closed_;
  zone::TomlFaults faults_;
  const Scenario::Step* step_{};
  std::map<std::string, SimDuration> arrivals_;           ///< of virtual AIVs: when each is added first
  std::map<std::string, VirtualObject> virtual_objects_;  ///< present at this step
  std::map<std::string, std::uint32_t> lossy_;            ///< vehicles with message loss, and the line of its step
};

}  // namespace

Result<void> resolve_zones(Scenario& scenario, const LoadZone& load, const std::string& origin) {
  for (Scenario::Step& step : scenario.steps) {
    if (step.zone.empty()) continue;
    const auto configuration = load(step.zone);
    if (!configuration) {
      zone::TomlFaults faults{origin, Entry::family};
      faults.add(configuration.error().code, step.line, "switch", to_string(configuration.error()));
      return tl::unexpected(faults.first());
    }
    JsonWriter json;
    zone::write_json(json.begin_object().field("command", "switch").key("zone"), *configuration);
    json.end_object();
    step.command = json.take();
  }
  return {};
}

Result<void> check(const Scenario& scenario, const zone::TrafficZone& zone, const std::string& origin) {
  return Checker{scenario, zone, origin}.run();
}

}  // namespace cosiva::experiments
