#include "cosiva/experiments/faults/two_areas.h"

#include <algorithm>
#include <array>
#include <cstdint>
#include <string>
#include <string_view>

#include "cosiva/base/expect.h"

namespace cosiva::experiments {
namespace {

enum class In : std::uint8_t { a, b, both };

/// A path of the floor, in the zones of these control areas.
struct Path {
  std::string_view name;
  In in;
  std::string_view start;     ///< x, y and heading
  std::string_view geometry;  ///< length, or radius and angle
  std::array<std::string_view, 2> next;
};

constexpr std::string_view half_circle_left = "kind = \"arc\"\nradius_m = 0.6\nangle_deg = 180\n";
constexpr std::string_view half_circle_right = "kind = \"arc\"\nradius_m = 0.6\nangle_deg = -180\n";
constexpr std::string_view bend_left = "kind = \"arc\"\nradius_m = 0.5\nangle_deg = 90\n";
constexpr std::string_view bend_right = "kind = \"arc\"\nradius_m = 0.5\nangle_deg = -90\n";

/// Of a branch into the other control area both zones of the fork contain what PILS detects of it.
constexpr std::array paths{
    Path{"a_1", In::a, "x = 0.0, y = 1.2, heading_deg = 0", "kind = \"straight\"\nlength_m = 0.6\n", {"a_2", "ab_in"}},
    Path{"a_2", In::a, "x = 0.6, y = 1.2, heading_deg = 0", "kind = \"straight\"\nlength_m = 2.6\n", {"a_3"}},
    Path{"a_3", In::a, "x = 3.2, y = 1.2, heading_deg = 0", "kind = \"straight\"\nlength_m = 0.6\n", {"a_east"}},
    Path{"a_east", In::a, "x = 3.8, y = 1.2, heading_deg = 0", half_circle_left, {"a_far"}},
    Path{"a_far", In::a, "x = 3.8, y = 2.4, heading_deg = 180", "kind = \"straight\"\nlength_m = 3.8\n", {"a_west"}},
    Path{"a_west", In::a, "x = 0.0, y = 2.4, heading_deg = 180", half_circle_left, {"a_1"}},
    Path{"ab_in", In::a, "x = 0.6, y = 1.2, heading_deg = 0", bend_right, {"ab"}},
    Path{"ab", In::both, "x = 1.1, y = 0.7, heading_deg = -90", "kind = \"straight\"\nlength_m = 1.4\n", {"ab_out"}},
    Path{"ab_out", In::b, "x = 1.1, y = -0.7, heading_deg = -90", bend_left, {"b_2"}},
    Path{"b_1", In::b, "x = 0.0, y = -1.2, heading_deg = 0", "kind = \"straight\"\nlength_m = 1.6\n", {"b_2"}},
    Path{"b_2", In::b, "x = 1.6, y = -1.2, heading_deg = 0", "kind = \"straight\"\nlength_m = 0.6\n", {"b_3", "ba_in"}},
    Path{"b_3", In::b, "x = 2.2, y = -1.2, heading_deg = 0", "kind = \"straight\"\nlength_m = 1.6\n", {"b_east"}},
    Path{"b_east", In::b, "x = 3.8, y = -1.2, heading_deg = 0", half_circle_right, {"b_far"}},
    Path{"b_far", In::b, "x = 3.8, y = -2.4, heading_deg = 180", "kind = \"straight\"\nlength_m = 3.8\n", {"b_west"}},
    Path{"b_west", In::b, "x = 0.0, y = -2.4, heading_deg = 180", half_circle_right, {"b_1"}},
    Path{"ba_in", In::b, "x = 2.2, y = -1.2, heading_deg = 0", bend_left, {"ba"}},
    Path{"ba", In::both, "x = 2.7, y = -0.7, heading_deg = 90", "kind = \"straight\"\nlength_m = 1.4\n", {"ba_out"}},
    Path{"ba_out", In::a, "x = 2.7, y = 0.7, heading_deg = 90", bend_right, {"a_3"}},
};

constexpr std::string_view vehicle = R"(
[vehicle]
length_m = 0.20
width_m = 0.12

[profiles.slow]
speed_mps = 0.20
acceleration_mps2 = 0.4
braking_mps2 = 0.7

[profiles.medium]
speed_mps = 0.50
acceleration_mps2 = 0.8
braking_mps2 = 1.0

[profiles.fast]
speed_mps = 0.60
acceleration_mps2 = 0.8
braking_mps2 = 1.0
)";

/// A tag has one number in all zones.
struct Tag {
  int number;
  std::string_view section;
  std::string_view s_m;
};
constexpr std::array tags{Tag{11, "a_2", "1.0"},   Tag{12, "a_far", "2.0"}, Tag{21, "b_3", "1.0"},
                          Tag{22, "b_far", "2.0"}, Tag{13, "a_1", "0.3"},   Tag{23, "b_2", "0.3"},
                          Tag{1, "ab", "0.1"},     Tag{2, "ba", "0.1"}};

bool contains(In zone, In path) { return zone == In::both || path == In::both || zone == path; }

/// @param zone  `both`: the floor
bool contains(In zone, std::string_view section) {
  const auto path = std::ranges::find(paths, section, &Path::name);
  COSIVA_EXPECT(path != paths.end());
  return contains(zone, path->in);
}

std::string section_text(const Path& path, In zone) {
  std::string text = "\n[[section]]\nname = \"" + std::string(path.name) + "\"\n" + std::string(path.geometry) +
                     "start = { " + std::string(path.start) + " }\nnext = [";
  bool first = true;
  for (const std::string_view next : path.next) {
    if (next.empty() || !contains(zone, next)) continue;
    text += (first ? "\"" : ", \"") + std::string(next) + "\"";
    first = false;
  }
  return text + "]\n";
}

std::string at(std::string_view table, std::string_view section, std::string_view s_m) {
  return "\n[[" + std::string(table) + "]]\nsection = \"" + std::string(section) + "\"\ns_m = " + std::string(s_m) +
         "\n";
}

std::string station(std::string_view name, std::string_view section, std::string_view s_m) {
  return at("station", section, s_m) + "name = \"" + std::string(name) + "\"\n";
}

zone::ZoneConfiguration zone_of(std::string_view name, In zone, const std::string& rest) {
  std::string text = "name = \"" + std::string(name) + "\"\nformat_version = 1\n" + std::string(vehicle);
  for (const Path& path : paths)
    if (contains(zone, path.in)) text += section_text(path, zone);
  for (const Tag& tag : tags)
    if (contains(zone, tag.section))
      text += at("tag", tag.section, tag.s_m) + "number = " + std::to_string(tag.number) + "\n";
  return {"toml", std::string(name) + ".toml", text + rest};
}

std::string round(std::string_view sections) {
  return "\n[[loop]]\nname = \"round\"\nsections = [" + std::string(sections) + "]\n";
}

}  // namespace

TwoAreas two_areas() {
  return {zone_of("floor", In::both,
                  at("start", "a_far", "1.5") + at("start", "b_far", "1.5") + at("start", "a_far", "3.0") +
                      at("start", "b_far", "3.0")),
          zone_of("area_a", In::a,
                  round(R"("a_1", "a_2", "a_3", "a_east", "a_far", "a_west")") + station("to_b", "ab", "1.0") +
                      station("rack_a", "a_far", "0.8")),
          zone_of("area_b", In::b,
                  round(R"("b_1", "b_2", "b_3", "b_east", "b_far", "b_west")") + station("to_a", "ba", "1.0") +
                      station("rack_b", "b_far", "0.8"))};
}

}  // namespace cosiva::experiments
