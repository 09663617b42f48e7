#include "cosiva/experiments/faults/persons.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "cosiva/base/expect.h"
#include "cosiva/base/json_writer.h"
#include "cosiva/base/random.h"
#include "cosiva/zone/layout/traffic_zone.h"

namespace cosiva::experiments {
namespace {

/// In a tight bend the beams miss a person in the bend; no person steps in there.
bool is_detected_from_far(const zone::Circuit& circuit, zone::TrackPosition position) {
  constexpr double straight_m = 0.45;
  constexpr double straight_per_m = 0.5;
  for (double back_m = 0.0; back_m <= straight_m; back_m += 0.05) {
    const zone::TrackPosition before = circuit.advance(position, -back_m);
    if (std::fabs(circuit.section(before.section).curvature_at(before.s_m)) > straight_per_m) return false;
  }
  return true;
}

}  // namespace

std::optional<Point2> Persons::point_in_path(std::uint32_t vehicle, std::uint64_t draw) const {
  const physical::PlantOptions& plant = world_.plant().options();
  // After a switch the vehicles' positions are those of another zone.
  if (plant.zone.text != plant.rtm->configuration().text) return std::nullopt;
  const zone::Circuit& circuit = plant.rtm->zone().circuit;
  const auto vehicles = world_.plant().vehicles();
  COSIVA_EXPECT(vehicle >= 1 && vehicle <= vehicles.size());
  const auto& from = vehicles[vehicle - 1].position;
  if (!from) return std::nullopt;
  Random random{draw, "person"};
  const zone::TrackPosition further = circuit.advance(*from, random.uniform(0.6, 1.2));
  const Point2 at = circuit.pose_at(further) * Point2{0.0, random.uniform(-0.08, 0.08)};
  const bool clear =
      std::ranges::none_of(vehicles, [&](const auto& v) { return distance(position(v.X_MB), at) < clear_m; });
  return clear && is_detected_from_far(circuit, further) ? std::optional{at} : std::nullopt;
}

void Persons::step_in(std::uint32_t vehicle, std::uint64_t draw, SimTime until) {
  const auto at = point_in_path(vehicle, draw);
  if (!at) return;
  persons_.push_back({"person-" + std::to_string(++count_), until});
  JsonWriter json;
  json.begin_object().key("addObstacle").begin_object().field("id", persons_.back().id);
  json.field("x", at->x_m).field("y", at->y_m).field("radius", radius_m).end_object().end_object();
  world_.command_plant(json.take());
}

std::string Persons::touching(Point2 person) const {
  const zone::VehicleShape& shape = world_.plant().options().rtm->zone().vehicle;
  for (const auto& vehicle : world_.plant().vehicles()) {
    const Point2 p = inverse(vehicle.X_MB) * person;
    const double along_m = std::max(0.0, std::fabs(p.x_m) - 0.5 * shape.length_m);
    const double aside_m = std::max(0.0, std::fabs(p.y_m) - 0.5 * shape.width_m);
    if (along_m * along_m + aside_m * aside_m < radius_m * radius_m) return "AIV" + std::to_string(vehicle.number);
  }
  return {};
}

void Persons::leave(SimTime now) {
  if (!world_.faults().running(plant_process)) return;
  for (const Person& person : persons_)
    if (person.until <= now) world_.command_plant(R"({"removeObstacle":")" + person.id + "\"}");
  std::erase_if(persons_, [now](const Person& person) { return person.until <= now; });
}

Finding Persons::check() {
  const auto& collisions = world_.plant().collisions();
  COSIVA_EXPECT(collisions.size() >= collisions_);
  if (std::exchange(collisions_, collisions.size()) == collisions.size()) return std::nullopt;
  return Violation{"safety", collisions.back().a + " touches " + collisions.back().b};
}

}  // namespace cosiva::experiments
