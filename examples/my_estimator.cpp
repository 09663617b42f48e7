// A custom position estimator: derive from Algorithm, register it by name, qualify it against the existing ones.
#include <cstdio>
#include <memory>

#include "cosiva/aiv/estimation/planar.h"
#include "cosiva/aiv/estimation/registry.h"
#include "cosiva/experiments/positioning/metrology/qualification.h"
#include "cosiva/experiments/positioning/metrology/result_text.h"
#include "cosiva/experiments/positioning/metrology/simulate.h"

namespace {

using namespace cosiva;
using estimation::Algorithm;
using estimation::Setting;

/// Moves by half of the distance to the position that a reading gives.
class Halfway final : public Algorithm {
 public:
  explicit Halfway(const Setting& setting)
      : pose_{setting.start}, variance_m2_{setting.start_sigma_m * setting.start_sigma_m}, sensors_{setting.sensors} {}

  void predict(const estimation::Odometry& odometry) override {
    pose_ = estimation::moved(pose_, odometry);
    variance_m2_ += sensors_.distance_variance_per_m * odometry.distance_m;
  }
  estimation::Rectified rectify(const estimation::Reading& reading) override {
    const Point2 fiducial_M = pose_ * reading.detected_B;  // its estimated position
    pose_.x_m += 0.5 * (reading.fiducial_M.x_m - fiducial_M.x_m);
    pose_.y_m += 0.5 * (reading.fiducial_M.y_m - fiducial_M.y_m);
    variance_m2_ = 0.25 * (variance_m2_ + sensors_.fiducial_along_sigma_m * sensors_.fiducial_along_sigma_m);
    return {true, std::nullopt, 0};
  }
  estimation::Rectified rectify(const estimation::Range&) override { return {}; }
  [[nodiscard]] estimation::Estimate estimate() const override {
    return {pose_, estimation::Vector3(variance_m2_, variance_m2_, 0.01).asDiagonal(), std::nullopt};
  }

 private:
  Pose2 pose_;
  double variance_m2_;
  estimation::SensorModel sensors_;
};

/// A circular loop, 2 m in radius.
std::shared_ptr<const estimation::Track> circle() {
  auto section = zone::Section::make({0.0, -2.0, 0.0}, 4.0 * pi, 0.5);
  std::vector<zone::Circuit::Part> parts{{"round", std::move(*section), std::nullopt, {0}}};
  auto circuit = zone::Circuit::make("circle", std::move(parts));
  auto shared = std::make_shared<const zone::Circuit>(std::move(*circuit));
  return std::make_shared<const estimation::Track>(*estimation::Track::of_loop(shared));
}

}  // namespace

int main() {
  estimation::Registry registry;
  const auto added = registry.add({"half_way", "moves by half of the distance to every reading", false, false,
                                   [](const Setting& setting) { return std::make_unique<Halfway>(setting); }});
  if (!added) return 1;

  std::vector<experiments::Candidate> candidates;
  for (const std::string name : {"arc_kalman", "half_way"}) {
    const auto make = [&registry, name](const Setting& setting) { return registry.make(name, setting); };
    candidates.push_back({name, "", false, make});
  }
  experiments::Simulation simulation{circle()};
  simulation.distance_m = 30.0;
  simulation.odometry_hz = 20.0;
  const auto source = [&](std::size_t index, experiments::Trial& room) -> Result<const experiments::Trial*> {
    experiments::simulate(simulation, index + 1, room);
    return &room;
  };
  const auto result = experiments::qualify(candidates, 20, source, {});
  if (!result) return 1;
  std::printf("%s", to_text(*result).c_str());
  return 0;
}
