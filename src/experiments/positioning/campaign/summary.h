#pragma once

#include <optional>
#include <string>
#include <vector>

#include "cosiva/base/workers.h"
#include "cosiva/experiments/positioning/campaign/plan.h"
#include "cosiva/experiments/positioning/campaign/vote.h"
#include "cosiva/experiments/positioning/campaign/work.h"
#include "cosiva/experiments/positioning/metrology/qualification.h"

/// What a campaign says once all its units are there. Nothing in it depends on how or in which order they were done.
namespace cosiva::experiments {

/// One algorithm in one environment.
struct CellMetrics {
  std::size_t environment{};
  std::size_t algorithm{};
  Figure rmse_m;  ///< with its interval over runs, as the other figures
  Figure p95_m;   ///< mean of the runs'
  double mean_m{};
  double max_m{};
  double precision{};
  double covered{};
  double nees{};
  double refused{};  ///< readings not taken, in all runs
  double limit_m{};
  double gap_percent{};
  bool leak{false};  ///< below the limit, at 1 % over all cells: it knows what it cannot know, or the limit is wrong
  FiducialsFound fiducials;
};

/// For each factor which of its values; nothing: all of them, each as often as the others.
using Selection = std::array<std::optional<std::size_t>, swept_count>;

/// How a figure changes along one factor.
struct Curve {
  std::size_t algorithm{};
  std::vector<double> x;
  std::vector<Figure> y;          ///< over what the selection leaves open and the runs; a run is a vote
  std::vector<double> limit;      ///< NaN where the figure has none
  std::vector<double> worst;      ///< the worst of the cells that lie together in a point
  std::vector<double> spacing_m;  ///< way per mark
};

/// Where a curve passes a tolerance.
struct Crossing {
  enum class Where { at, under, over };  ///< under: not even the first value meets it; over: all do
  Where where{Where::at};
  double x{};  ///< interpolated in logarithms; the first or the last value where it is beyond
};

/// The widest pitch that meets the tolerance, all narrower ones swept doing so, too.
struct PitchMet {
  Selection at;  ///< which values of the factors; pitch, origin and rotation are open
  std::size_t algorithm{};
  Crossing pitch;
  std::optional<Crossing> low, high;  ///< 95 %: of the figure's upper and lower end; none of one run
  Crossing worst;                     ///< with the worst origin and rotation
  std::optional<Crossing> limit;      ///< what the best possible algorithm needs
};

struct CampaignSummary {
  std::vector<CellMetrics> cells;     ///< environment by environment, algorithm fastest
  std::vector<PitchMet> pitches_met;  ///< none where only one pitch was asked for
  std::size_t leaks{};
  std::string digest;  ///< of every vote, in the order of the list
};

/// @param records  all units' (checked), in their order
[[nodiscard]] CampaignSummary sum_up(const CampaignWork& work, const std::vector<UnitRecord>& records,
                                     Workers& workers);

/// Along `factor`, of one algorithm.
[[nodiscard]] Curve curve_of(const CampaignWork& work, const std::vector<UnitRecord>& records, Swept factor,
                             std::size_t algorithm, const Selection& selection);
/// @param y  as many as x, which rises (checked)
[[nodiscard]] Crossing crossing_of(const std::vector<double>& x, const std::vector<double>& y, double tolerance);

/// The vote of an algorithm in a run of an environment.
class Votes {
 public:
  Votes(const CampaignWork& work, const std::vector<UnitRecord>& records) : work_{work}, records_{records} {}
  [[nodiscard]] const Vote& of(std::size_t environment, std::size_t run, std::size_t algorithm) const;
  [[nodiscard]] const FiducialsFound& fiducials(std::size_t environment) const;

 private:
  const CampaignWork& work_;
  const std::vector<UnitRecord>& records_;
};

}  // namespace cosiva::experiments
