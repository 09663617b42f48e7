#pragma once

#include <vector>

#include "cosiva/aiv/estimation/algorithm.h"
#include "cosiva/base/random.h"

namespace cosiva::estimation {

/// Many guesses, each a place on the graph of sections: for who does not know where it starts, takes branches that
/// nobody has told, or reads marks that are not what they seem. Sources: M. S. Arulampalam et al., A Tutorial on
/// Particle Filters, IEEE Trans. Signal Processing 50 (2002); of maps as graphs F. Gustafsson et al., Particle Filters
/// for Positioning, Navigation and Tracking, same volume.
class ParticleFilter final : public Algorithm {
 public:
  explicit ParticleFilter(Setting setting);
  void predict(const Odometry& odometry) override;
  Rectified rectify(const Reading& reading) override;
  Rectified rectify(const Range& range) override;
  /// Mean and covariance of all guesses. `along_m` counts from the start, for who knew it.
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
