#include "cosiva/experiments/agents/fleet_run.h"

#include <algorithm>
#include <cmath>
#include <string>
#include <utility>
#include <vector>

#include "cosiva/base/expect.h"
#include "cosiva/base/json_writer.h"
#include "cosiva/base/random.h"
#include "cosiva/experiments/runs/world/world.h"
#include "cosiva/zone/layout/traffic_zone.h"

namespace cosiva::experiments {
namespace {

/// The plant's batteries are updated as often: their loads are then constant from sample to sample.
constexpr SimDuration sample_period = std::chrono::milliseconds{100};
constexpr double moving_mps = 0.05;
constexpr double stopped_mps = 0.01;

/// Sections at half of whose length a person crosses the path: away from crossings, where a vehicle that stops for the
/// person blocks its own path only.
std::vector<zone::SectionId> sections_to_walk_across(const zone::TrafficZone& zone) {
  constexpr double length_m_min = 1.0;
  std::vector<zone::SectionId> sections;
  for (zone::SectionId id = 0; id < zone.circuit.size(); ++id) {
    const bool crosses = std::ranges::any_of(zone.crossings, [id](const zone::Crossing& crossing) {
      return std::ranges::any_of(crossing.spans, [id](const zone::CrossingSpan& span) { return span.section == id; });
    });
    if (!crosses && zone.circuit.section(id).length_m() >= length_m_min) sections.push_back(id);
  }
  return sections;
}

/// A virtual person that walks to and fro across the path, perpendicular to it.
std::string person_command(const zone::TrafficZone& zone, zone::SectionId section, std::uint32_t number) {
  constexpr double aside_m = 0.45;
  const Pose2 X_MP = zone.circuit.pose_at({section, 0.5 * zone.circuit.section(section).length_m()});
  JsonWriter json;
  json.begin_object().field("command", "add").key("virtualObject").begin_object();
  json.field("kind", "person").field("id", "P" + std::to_string(number)).key("path").begin_array();
  for (const double left_m : {-aside_m, aside_m}) {
    const Point2 end = X_MP * Point2{0.0, left_m};
    json.begin_array().value(end.x_m).value(end.y_m).end_array();
  }
  // Two persons do not walk in step.
  json.end_array().field("speed", number % 2 == 1 ? 0.2 : 0.15).field("repeat", "back and forth");
  json.end_object().end_object();
  return json.take();
}

/// Adds the persons once the fleet is complete and drives, at times that follow from the seed.
Result<void> add_persons(World& world, const FleetRunOptions& options) {
  if (options.persons == 0) return {};
  const zone::TrafficZone& zone = options.rtm->zone();
  const auto sections = sections_to_walk_across(zone);
  if (sections.size() < options.persons)
    return fail("agents.persons", "zone '" + zone.name + "' has " + std::to_string(sections.size()) +
                                      " sections without a crossing for " + std::to_string(options.persons) +
                                      " persons");
  Random random{options.seed, "persons"};
  world.run_for(std::chrono::seconds{10});
  for (std::uint32_t i = 0; i < options.persons; ++i) {
    world.run_for(from_seconds(random.uniform(1.0, 6.0)));
    world.command_server(person_command(zone, sections[i * sections.size() / options.persons], i + 1));
  }
  return {};
}

/// Adds up what the fleet does, sample by sample.
///
/// Invariant: each vehicle's stops are counted once per standstill.
class FleetCounter {
 public:
  explicit FleetCounter(std::size_t vehicles) : moved_(vehicles, false) {}

  void sample(const physical::PlantCore& plant, FleetRun& run) {
    const auto vehicles = plant.vehicles();
    COSIVA_EXPECT(vehicles.size() == moved_.size());
    const double period_s = to_seconds(sample_period);
    for (std::size_t i = 0; i < vehicles.size(); ++i) {
      const double speed_mps = std::fabs(vehicles[i].speed_mps);
      run.energy_kj += 0.001 * vehicles[i].power.load_w * period_s;
      if (speed_mps < stopped_mps) {
        run.stopped_s += period_s;
        if (std::exchange(moved_[i], false)) ++run.stops;
      } else if (speed_mps >= moving_mps) {
        moved_[i] = true;
      } else {
        run.creeping_s += period_s;
      }
    }
  }

 private:
  std::vector<char> moved_;  ///< since its last stop
};

}  // namespace

Result<FleetRun> run_fleet(const FleetRunOptions& options) {
  COSIVA_EXPECT(options.rtm);
  WorldOptions world_options;
  world_options.zone = options.rtm->configuration();
  world_options.rtm = options.rtm;
  world_options.aivs = options.vehicles;
  world_options.seed = options.seed;
  world_options.rules = options.rules;
  world_options.as_values = true;
  world_options.ground_truth = false;
  auto world = World::make(std::move(world_options));
  if (!world) return tl::unexpected<Error>(world.error());

  const SimTime end = (*world)->now() + options.duration;
  if (auto added = add_persons(**world, options); !added) return tl::unexpected<Error>(added.error());

  FleetRun run;
  FleetCounter counter{options.vehicles};
  while ((*world)->now() < end) {
    (*world)->run_for(sample_period);
    counter.sample((*world)->plant(), run);
  }
  for (const auto& vehicle : (*world)->plant().vehicles()) run.distance_m += vehicle.distance_m;
  run.laps = run.distance_m / options.rtm->zone().circuit.total_length_m();
  run.collisions = (*world)->plant().collisions().size();
  run.digest = (*world)->digest().hex();
  return run;
}

}  // namespace cosiva::experiments
