#pragma once

#include <cstddef>
#include <optional>
#include <span>
#include <vector>

namespace cosiva::statistics {

/// One measured value of a crossed design: unit (a battery) on carrier (a vehicle), with the index of its run.
struct Trial {
  std::size_t unit;
  std::size_t carrier;
  double run;
  double value;
};
struct Factor {
  double degrees;
  double f;
  double p;
  double sd;     ///< of its true effects, by the method of moments
  double ratio;  ///< of the joint variance of the factors and the noise
};
/// value = mean + unit + carrier + slope · run + noise, by least squares. A factor is tested by what it explains beyond
/// all others; where a factor explains nothing of its own (each unit stayed on its carrier), `confounded` is set and
/// the results are those of both factors together.
struct Crossed {
  Factor unit;
  Factor carrier;
  Factor run;
  double slope;  ///< per run
  double noise_sd;
  double noise_ratio;
  double noise_degrees;
  bool confounded;
  std::vector<double> unit_effects;  ///< about their mean; empty where confounded
  std::vector<double> carrier_effects;
};
/// Nothing where there are not more trials than unknowns of the model.
[[nodiscard]] std::optional<Crossed> crossed(std::span<const Trial> trials);

}  // namespace cosiva::statistics
