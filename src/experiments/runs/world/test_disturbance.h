#pragma once

// Disturbances of a control area during a day, from a seed: vehicles are stopped and restarted, persons step in, some
// of them only virtual. For tests and long runs.

#include <algorithm>
#include <cmath>
#include <memory>
#include <string>
#include <vector>

#include "cosiva/base/json_value.h"
#include "cosiva/base/json_writer.h"
#include "cosiva/base/random.h"
#include "cosiva/experiments/runs/world/world.h"
#include "cosiva/zone/rtm/rtm.h"

namespace cosiva::experiments::testing {

class Disturbance {
 public:
  /// How often per second a disturbance begins, and its duration [s].
  struct Rates {
    double stop{0.03};
    double person{0.08};
    double virtual_person{0.05};
    double lasts_min_s{2.0};
    double lasts_max_s{12.0};
  };

  Disturbance(World& world, const zone::ZoneConfiguration& zone, std::uint64_t seed)
      : Disturbance{world, zone, seed, Rates{}} {}
  Disturbance(World& world, const zone::ZoneConfiguration& zone, std::uint64_t seed, Rates rates)
      : world_{world}, zone_{zone::Rtm::initialise(zone)->shared_zone()}, random_{seed, "unrest"}, rates_{rates} {}

  /// Runs one second of the world, with the disturbances that begin and end in it.
  void second() {
    end_what_is_due();
    if (random_.chance(rates_.stop)) stop_a_vehicle();
    if (random_.chance(rates_.person)) step_in(false);
    if (random_.chance(rates_.virtual_person)) step_in(true);
    world_.run_for(std::chrono::seconds{1});
  }
  /// Restarts all vehicles and removes all objects.
  void end() {
    for (const Trouble& trouble : troubles_) world_.command_server(trouble.end);
    troubles_.clear();
  }

 private:
  struct Trouble {
    SimTime until;
    std::string end;  ///< the command that ends it
  };

  void begin(std::string begins, std::string ends) {
    world_.command_server(std::move(begins));
    const double lasts_s = random_.uniform(rates_.lasts_min_s, rates_.lasts_max_s);
    troubles_.push_back({world_.now() + from_seconds(lasts_s), std::move(ends)});
  }

  void end_what_is_due() {
    for (const Trouble& trouble : troubles_)
      if (trouble.until <= world_.now()) world_.command_server(trouble.end);
    std::erase_if(troubles_, [&](const Trouble& trouble) { return trouble.until <= world_.now(); });
  }

  void stop_a_vehicle() {
    const auto vehicles = world_.plant().vehicles();
    const std::string name = "\"CoSiVA/AIV" + std::to_string(1 + random_.below(vehicles.size())) + "\"}";
    begin(R"({"command":"stop","vehicle":)" + name, R"({"command":"restart","vehicle":)" + name);
  }

  /// Adds a person on a vehicle's path, where the person is detected and does not walk into a vehicle.
  void step_in(bool only_virtual) {
    const auto vehicles = world_.plant().vehicles();
    const auto& before = vehicles[random_.below(vehicles.size())];
    if (!before.position) return;
    const zone::TrackPosition track_position = zone_->circuit.advance(*before.position, random_.uniform(0.6, 1.2));
    if (!is_detected_from_far(track_position)) return;
    const Pose2 X_MP = zone_->circuit.pose_at(track_position);
    const Point2 at = X_MP * Point2{0.0, random_.uniform(-0.08, 0.08)};
    constexpr double clear_m = 0.55;  // braking from the fast profile, half a vehicle, a board's and a cycle's delay
    if (std::ranges::any_of(vehicles, [&](const auto& v) { return distance(position(v.X_MB), at) < clear_m; })) return;
    const std::string id = "P" + std::to_string(++persons_);
    JsonWriter json;
    json.begin_object().field("command", only_virtual ? "add" : "plant").key(only_virtual ? "virtualObject" : "plant");
    if (!only_virtual) json.begin_object().key("addObstacle");
    json.begin_object().field("id", id);
    if (only_virtual) json.field("kind", "person");
    json.field("x", at.x_m).field("y", at.y_m).field("radius", 0.06).end_object();
    if (!only_virtual) json.end_object();
    json.end_object();
    begin(json.take(), only_virtual ? R"({"command":"remove","id":")" + id + "\"}"
                                    : R"({"command":"plant","plant":{"removeObstacle":")" + id + "\"}}");
  }

  /// In a tight bend the beams miss a person in the bend; no person steps in there.
  [[nodiscard]] bool is_detected_from_far(zone::TrackPosition track_position) const {
    constexpr double straight_m = 0.45;
    constexpr double straight_per_m = 0.5;
    for (double back_m = 0.0; back_m <= straight_m; back_m += 0.05) {
      const zone::TrackPosition before = zone_->circuit.advance(track_position, -back_m);
      if (std::fabs(zone_->circuit.section(before.section).curvature_at(before.s_m)) > straight_per_m) return false;
    }
    return true;
  }

  World& world_;
  std::shared_ptr<const zone::TrafficZone> zone_;
  Random random_;
  Rates rates_;
  std::vector<Trouble> troubles_;
  std::uint64_t persons_{0};
};

/// The server's metrics of its deadlocks.
struct DeadlockMetrics {
  double cycles{};
  double detected{};
  double resolved{};
  double open{};
  double longest_s{};
  double longest_wait_s{};
};
inline DeadlockMetrics deadlock_metrics(const World& world) {
  const auto summary = JsonValue::parse(world.server().summary_json(), std::size_t{1} << 24U);
  const JsonValue* d = summary ? summary->find("deadlocks") : nullptr;
  if (d == nullptr) return {.open = 1e9};
  const auto number = [&](std::string_view name) { return d->number(name).value_or(1e9); };
  return {number("cycles"), number("detected"),  number("resolved"),
          number("open"),   number("longest_s"), number("longest_wait_s")};
}

}  // namespace cosiva::experiments::testing
