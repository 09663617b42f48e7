#pragma once

#include <vector>

#include "cosiva/aiv/estimation/algorithm.h"
#include "cosiva/base/random.h"

namespace cosiva::estimation {

/// Particles, each a position on the graph of sections: for a vehicle whose start is unknown, whose branches are not
/// given, or whose readings may be of the wrong fiducials. Sources: M. S. Arulampalam et al., A Tutorial on Particle
/// Filters, IEEE Trans. Signal Processing 50 (2002); of maps as graphs F. Gustafsson et al., Particle Filters for
/// Positioning, Navigation and Tracking, same volume. Invariant: the number of particles never changes.
class ParticleFilter final : public Algorithm {
 public:
  explicit ParticleFilter(Setting setting);
  void predict(const Odometry& odometry) override;
  Rectified rectify(const Reading& reading) override;
  Rectified rectify(const Range& range) override;
  /// Mean and covariance of all particles. `along_m` counts from a known start.
  [[nodiscard]] Estimate estimate() const override;

 private:
  struct Particle {
    zone::TrackPosition position;
    double along_m;  ///< travelled
    double weight;
  };
  template <typename Likelihood>
  void weigh(const Likelihood& likelihood);
  void resample();
  void spread_over_circuit();

  Setting setting_;
  Random random_;
  std::vector<Particle> particles_;
  std::vector<Particle> drawn_;
};

}  // namespace cosiva::estimation
