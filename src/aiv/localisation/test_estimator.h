// An estimator on a graph, and the reports of PILS that it is fed with.
#pragma once

#include <cmath>
#include <cstdint>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "cosiva/aiv/localisation/estimator.h"
#include "cosiva/aiv/testing/test_graphs.h"

namespace cosiva::aiv::test {

/// No latency and no antenna field: the fix is exactly the tag's position.
inline constexpr EstimatorModel ideal{.antenna_range_m = 0.0, .reading_latency_s = 0.0};

/// Reports of PILS, and the resulting estimate.
struct GraphEstimator : PositionEstimator {
  const zone::TrafficZone& zone;
  wire::Odometry odometry;

  explicit GraphEstimator(const zone::TrafficZone& z) : PositionEstimator{z, ideal}, zone{z} { on_odometry(odometry); }
  GraphEstimator& stopped_at(std::string_view section, double s_m) {
    position_at(at(zone, section, s_m));
    return *this;
  }
  GraphEstimator& along(const std::vector<std::string>& names) {
    std::vector<zone::SectionId> sections;
    for (const auto& name : names) sections.push_back(zone.circuit.find(name).value());
    follow(zone::Course{std::move(sections)});
    return *this;
  }
  double drive(double distance_m) {
    double moved_m = 0.0;
    for (int i = 0; i < 100; ++i) {
      odometry.distance_um += std::llround(1e4 * distance_m);
      moved_m += on_odometry(odometry).step_m;
    }
    return moved_m;
  }
  EstimateStep turn(double turned_rad) {
    odometry.manoeuvre = wire::Manoeuvre{0, 0, static_cast<std::int16_t>(std::lround(1e3 * turned_rad))};
    return on_odometry(odometry);
  }
  EstimateStep end() {
    odometry.manoeuvre.reset();
    return on_odometry(odometry);
  }
  std::string section() const { return zone.circuit.part(track_position().section).name; }
};

}  // namespace cosiva::aiv::test
