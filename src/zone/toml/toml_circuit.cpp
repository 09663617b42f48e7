#include "cosiva/zone/toml/toml_circuit.h"

#include <algorithm>
#include <cmath>
#include <set>

#include "cosiva/base/expect.h"
#include "cosiva/zone/toml/toml_factory.h"
#include "cosiva/zone/toml/toml_node.h"
#include "cosiva/zone/toml/toml_tables.h"

namespace cosiva::zone {
namespace {

// The whole zone may turn this much: bounds the memory that a small file can request.
constexpr double turned_max_rad = 4e5;
constexpr double length_max_m = 1e6;
constexpr std::size_t circuits_max = 100;
// More branches than this at one position are no fork.
constexpr std::size_t successors_max = 64;

constexpr NumberRange turn_deg{"degrees to turn, positive to the left", -572957.0, 572957.0};
constexpr NumberRange curvature{"a curvature per metre within ±1000, positive to the left", -1000.0, 1000.0};
constexpr NumberRange shape_number{"a number within ±1e9", -1e9, 1e9};
constexpr NumberRange curvature_rate{"a change of curvature per metre within ±1e9", -1e9, 1e9};

Pose2 read_pose(const TomlFields& fields) {
  fields.expect_only({"x", "y", "heading_deg", "heading_rad"});
  const double heading_rad = fields.angle("heading", 360.0);
  return {fields.number("x", coordinate_m), fields.number("y", coordinate_m), wrap_angle(heading_rad)};
}

}  // namespace

std::optional<Circuit> TomlTracks::read() {
  read_circuits();
  if (!faults_.any()) read_sections();
  if (!faults_.any()) read_successors();
  if (!faults_.any()) check_vehicle_fits();
  // Joints are checked even where a bend is too tight, so that both faults are reported.
  const bool readable = !faults_.any() || faults_.first().code == "zone.vehicle";
  return readable ? join() : std::nullopt;
}

void TomlTracks::read_circuits() {
  const auto read = [this](const TomlFields& fields) {
    fields.expect_only({"name", "start", "closed"});
    TomlCircuit circuit{fields.optional_name("name").value_or(""), fields.flag("closed", false), {}};
    if (const auto start = fields.table("start")) circuit.follows = read_pose(*start);
    circuits_.push_back(std::move(circuit));
  };
  if (!root_.is_list("circuit")) {
    if (const auto one = root_.table("circuit")) read(*one);
    if (circuits_.empty()) circuits_.push_back({});
    return;
  }
  const auto entries = root_.tables("circuit");
  if (entries.empty() || entries.size() > circuits_max)
    return root_.fault("circuit", "zone.size", "expected 1 to " + std::to_string(circuits_max) + " circuits");
  std::set<std::string> names;
  for (const TomlFields& fields : entries) {
    (void)fields.name("name");
    read(fields);
    if (!faults_.any() && !names.insert(circuits_.back().name).second)
      fields.fault("name", "zone.duplicate", "two circuits have the name '" + circuits_.back().name + "'");
  }
}

void TomlTracks::read_sections() {
  entries_ = root_.tables("section");
  if (faults_.any()) return;
  if (entries_.empty()) return root_.fault("section", "circuit.empty", "expected at least one [[section]], found none");
  if (entries_.size() > toml_sections_max) {
    return root_.fault("section", "zone.size",
                       "expected at most " + std::to_string(toml_sections_max) + " sections, found " +
                           std::to_string(entries_.size()));
  }
  parts_.reserve(entries_.size());
  from_.reserve(entries_.size());
  for (const TomlFields& fields : entries_) {
    read_section(fields);
    if (faults_.any()) return;
  }
}

void TomlTracks::read_section(const TomlFields& fields) {
  const auto id = static_cast<SectionId>(parts_.size());
  const std::string name = fields.name("name");
  read_circuit_of(fields);
  if (faults_.any()) return;
  TomlCircuit& circuit = circuits_[here_];
  const Pose2 start = start_of(fields, circuit);
  const auto section = read_shape(fields, start);
  if (faults_.any() || !section) return;
  turned_rad_ += section->curvature_max_per_m() * section->length_m();
  length_m_ += section->length_m();
  if (turned_rad_ > turned_max_rad || length_m_ > length_max_m) {
    return fields.fault("", "zone.size",
                        "a zone's sections may be 1000 km long and turn 400000 rad in all; those up to here exceed it");
  }
  Circuit::Part part{name, *section, std::nullopt, {}};
  if (fields.has("speed_mps_max")) part.speed_mps_max = fields.number("speed_mps_max", speed_range);
  part.pivots = fields.flag("pivots", false);
  read_waypoint_ids(fields, id);
  parts_.push_back(std::move(part));
  by_name_.emplace(name, id);
  circuit.sections.push_back(id);
  circuit.follows = section->end();
}

/// Without a name the section has that of the section before it in the file.
void TomlTracks::read_circuit_of(const TomlFields& fields) {
  const auto name = fields.optional_name("circuit");
  if (!name || faults_.any()) return;
  const auto at =
      std::find_if(circuits_.begin(), circuits_.end(), [&](const TomlCircuit& c) { return c.name == *name; });
  if (at == circuits_.end())
    return fields.fault("circuit", "zone.reference",
                        "expected the name of a circuit, found \"" + name->substr(0, 64) + "\", which is none");
  here_ = static_cast<std::size_t>(at - circuits_.begin());
}

Pose2 TomlTracks::start_of(const TomlFields& fields, const TomlCircuit& circuit) {
  from_.push_back(no_section);
  const auto from = fields.optional_name("from");
  const auto start = fields.table("start");
  if (!from) return start ? read_pose(*start) : circuit.follows;
  if (start) fields.fault("from", "zone.field", "a section begins at 'start' or at the end of 'from', not at both");
  const auto at = by_name_.find(*from);
  if (at != by_name_.end()) {
    from_.back() = at->second;
    return parts_[at->second].section.end();
  }
  if (!faults_.any())
    fields.fault("from", "zone.reference",
                 "expected the name of a section further up in the file, found \"" + from->substr(0, 64) + "\"");
  return {};
}

std::optional<Section> TomlTracks::read_shape(const TomlFields& fields, const Pose2& follows) const {
  const SectionKinds& kinds = SectionKinds::of_program();
  const std::vector<std::string> names = kinds.names();
  const std::string kind = fields.one_of("kind", std::vector<std::string_view>{names.begin(), names.end()});
  const auto made = [&](Result<Section> section) -> std::optional<Section> {
    if (faults_.any()) return std::nullopt;
    if (section) return std::move(*section);
    fields.fault("", section.error().code, section.error().message);
    return std::nullopt;
  };
  if (const ShapedKind* const shaped = kinds.find(kind)) return made(read_shaped(fields, *shaped, follows));
  double length_m = 0.0;
  double curvature_per_m = 0.0;
  double rate_per_m2 = 0.0;
  if (kind == "straight") {
    fields.expect_only({"name", "kind", "length_m", "speed_mps_max", "start", "next", "from", "circuit", "pivots",
                        "start_node", "end_node"});
    length_m = fields.number("length_m", positive_m);
  } else if (kind == "arc") {
    fields.expect_only({"name", "kind", "radius_m", "angle_deg", "length_m", "curvature_per_m", "speed_mps_max",
                        "start", "next", "from", "circuit", "pivots", "start_node", "end_node"});
    if (fields.has("curvature_per_m") || fields.has("length_m")) {
      length_m = fields.number("length_m", positive_m);
      curvature_per_m = fields.number("curvature_per_m", curvature);
      for (const std::string_view other : {"radius_m", "angle_deg"})
        if (fields.has(other))
          fields.fault(other, "zone.field",
                       "give an arc either radius_m and angle_deg or length_m and curvature_per_m");
    } else {
      const double radius_m = fields.number("radius_m", positive_m);
      const double angle_rad = fields.number("angle_deg", turn_deg) * rad_per_deg;
      length_m = radius_m * std::fabs(angle_rad);
      curvature_per_m = (angle_rad < 0.0 ? -1.0 : 1.0) / radius_m;
      if (angle_rad == 0.0 && !faults_.any())
        fields.fault("angle_deg", "zone.field", "expected degrees to turn, positive to the left, found 0");
    }
  } else if (kind == "clothoid") {
    fields.expect_only({"name", "kind", "length_m", "curvature_start_per_m", "curvature_end_per_m",
                        "curvature_rate_per_m2", "speed_mps_max", "start", "next", "from", "circuit", "pivots",
                        "start_node", "end_node"});
    length_m = fields.number("length_m", positive_m);
    curvature_per_m = fields.number("curvature_start_per_m", curvature);
    if (fields.has("curvature_rate_per_m2") && !fields.has("curvature_end_per_m"))
      rate_per_m2 = fields.number("curvature_rate_per_m2", curvature_rate);
    else
      rate_per_m2 = (fields.number("curvature_end_per_m", curvature) - curvature_per_m) / length_m;
    if (fields.has("curvature_rate_per_m2") && fields.has("curvature_end_per_m"))
      fields.fault("curvature_rate_per_m2", "zone.field",
                   "give a clothoid's curvature at its end or its rate, not both");
  }
  if (faults_.any()) return std::nullopt;
  return made(Section::make(follows, length_m, curvature_per_m, rate_per_m2));
}

Result<Section> TomlTracks::read_shaped(const TomlFields& fields, const ShapedKind& kind, const Pose2& follows) const {
  std::vector<std::string_view> keys{"name", "kind",    "speed_mps_max", "start",      "next",
                                     "from", "circuit", "pivots",        "start_node", "end_node"};
  keys.insert(keys.end(), kind.fields.begin(), kind.fields.end());
  fields.expect_only(keys);
  std::vector<double> values;
  for (const std::string& key : kind.fields) values.push_back(fields.number(key, shape_number));
  if (faults_.any()) return fail("zone.field", "an entry with faults has no shape");
  auto shape = kind.make(values);
  if (!shape) return tl::unexpected(std::move(shape).error());
  return Section::make(follows, std::move(*shape));
}

void TomlTracks::read_waypoint_ids(const TomlFields& fields, SectionId id) {
  const auto read = [&](std::string_view key, std::vector<std::string>& ids) {
    const auto name = fields.optional_name(key);
    if (!name) return;
    if (ids.empty()) ids.resize(entries_.size());
    ids[id] = *name;
  };
  read("start_node", rules_.start_ids);
  read("end_node", rules_.end_ids);
}

void TomlTracks::add_successor(SectionId id, std::string_view name, std::string_view key, SectionId said_by) {
  auto& next = parts_[id].next;
  const auto at = by_name_.find(name);
  if (at == by_name_.end())
    return entries_[said_by].fault(
        key, "zone.reference",
        "expected names of sections, found \"" + std::string(name.substr(0, 64)) + "\", which is none");
  if (std::find(next.begin(), next.end(), at->second) != next.end())
    return entries_[said_by].fault(key, "zone.duplicate", "\"" + std::string(name) + "\" occurs here twice");
  if (next.size() >= successors_max)
    return entries_[said_by].fault(key, "zone.size",
                                   "expected at most " + std::to_string(successors_max) + " sections after one");
  next.push_back(at->second);
}

void TomlTracks::read_successors() {
  for (const TomlCircuit& circuit : circuits_) {
    for (std::size_t i = 0; i < circuit.sections.size(); ++i) {
      const SectionId id = circuit.sections[i];
      const bool last = i + 1 == circuit.sections.size();
      if (const auto names = entries_[id].names("next")) {
        for (const std::string& name : *names) {
          if (faults_.any()) return;
          add_successor(id, name, "next", id);
        }
      } else if (!last && from_[circuit.sections[i + 1]] == no_section) {
        parts_[id].next.push_back(circuit.sections[i + 1]);
      } else if (last && circuit.closed) {
        parts_[id].next.push_back(circuit.sections.front());
      }
    }
  }
  // Branches come after a section's own successor, which stays the default.
  for (SectionId id = 0; id < parts_.size() && !faults_.any(); ++id)
    if (from_[id] != no_section) add_successor(from_[id], parts_[id].name, "from", id);
}

void TomlTracks::check_vehicle_fits() const {
  for (SectionId id = 0; id < parts_.size(); ++id) {
    const double bend = parts_[id].section.curvature_max_per_m();
    if (0.5 * vehicle_.width_m * bend < 1.0) continue;
    const auto vehicle = root_.table("vehicle");
    const std::string message = "expected less than " + toml_number(2.0 / bend) + " m, because section '" +
                                parts_[id].name + "' bends with a radius of " + toml_number(1.0 / bend) + " m, found " +
                                toml_number(vehicle_.width_m);
    if (vehicle)
      vehicle->fault("width_m", "zone.vehicle", message);
    else
      root_.fault("vehicle", "zone.vehicle", message);
  }
}

std::optional<Circuit> TomlTracks::join() {
  std::vector<std::string> names;
  for (const auto& part : parts_) names.push_back(part.name);
  auto circuit = Circuit::make(name_, parts_);
  if (circuit) return faults_.any() ? std::nullopt : std::optional{std::move(*circuit)};
  const Error& error = circuit.error();
  if (error.code != "circuit.duplicate") {
    list_bad_joints();
    COSIVA_EXPECT(faults_.any());
    return std::nullopt;
  }
  // The circuit reports the section at fault by name; the last of that name is the duplicate.
  const auto found = std::find(names.rbegin(), names.rend(), error.location);
  const auto index = found == names.rend() ? std::size_t{0} : static_cast<std::size_t>(names.rend() - found) - 1;
  entries_[index].fault("name", error.code, error.message);
  return std::nullopt;
}

/// Checks the circuit joint by joint, because Circuit::make stops at the first bad one.
void TomlTracks::list_bad_joints() const {
  for (SectionId id = 0; id < parts_.size(); ++id) {
    for (const SectionId after : parts_[id].next) {
      std::vector<Circuit::Part> pair{parts_[id]};
      pair[0].next = {after == id ? SectionId{0} : SectionId{1}};
      if (after != id) {
        pair.push_back(parts_[after]);
        pair[1].next.clear();
      }
      const auto joined = Circuit::make(name_, std::move(pair));
      if (joined) continue;
      const std::string_view key = from_[after] == id ? "from" : "next";
      entries_[from_[after] == id ? after : id].fault(key, joined.error().code, joined.error().message);
    }
  }
}

std::vector<Loop> TomlTracks::loops(const Circuit& circuit) const {
  std::vector<Loop> found;
  for (const TomlCircuit& round : circuits_) {
    if (round.name.empty() || !round.closed || round.sections.empty()) continue;
    Loop loop{round.name, {}};
    std::vector<bool> passed(circuit.size());
    for (SectionId here = round.sections.front();;) {
      loop.sections.push_back(here);
      passed[here] = true;
      const auto next = circuit.next(here);
      if (!next.empty() && next.front() == round.sections.front()) break;
      if (next.empty() || passed[next.front()]) {
        faults_.add({"zone.loop",
                     "the circuit '" + round.name + "' is closed, but the path from its section '" +
                         circuit.part(round.sections.front()).name +
                         "' along the first of each 'next' does not come "
                         "back there",
                     entries_[round.sections.front()].location()});
        break;
      }
      here = next.front();
    }
    found.push_back(std::move(loop));
  }
  return found;
}

}  // namespace cosiva::zone
