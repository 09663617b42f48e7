#pragma once

#include <optional>
#include <string>
#include <vector>

#include "cosiva/base/workers.h"
#include "cosiva/experiments/positioning/campaign/plan.h"
#include "cosiva/experiments/positioning/campaign/vote.h"
#include "cosiva/experiments/positioning/campaign/work.h"
#include "cosiva/experiments/positioning/metrology/qualification.h"

/// The results of a campaign with all units done. They do not depend on how or in which order the units were done.
namespace cosiva::experiments {

/// The metrics of one algorithm in one environment.
struct CellMetrics {
  std::size_t environment{};
  std::size_t algorithm{};
  Figure rmse_m;  ///< with its interval over runs, as for the other metrics
  Figure p95_m;   ///< mean over the runs
  double mean_m{};
  double max_m{};
  double precision{};
  double covered{};
  double nees{};
  double refused{};  ///< rejected readings, in all runs
  double limit_m{};
  double gap_percent{};
  bool leak{false};  ///< below the limit, at 1 % over all cells: the algorithm uses information that it cannot have, or
                     ///< the limit is wrong
  FiducialsFound fiducials;
};

/// For each factor the index of its value; nothing: all values with equal weight.
using Selection = std::array<std::optional<std::size_t>, swept_count>;

/// A metric along one factor.
struct Curve {
  std::size_t algorithm{};
  std::vector<double> x;
  std::vector<Figure> y;          ///< over the open factors of the selection, and the runs; a run is a vote
  std::vector<double> limit;      ///< NaN for a metric without a limit
  std::vector<double> worst;      ///< the worst of the cells that are combined in a point
  std::vector<double> spacing_m;  ///< distance per fiducial
};

/// Where a curve passes a tolerance.
struct Crossing {
  enum class Where { at, under, over };  ///< under: not even the first value meets the tolerance; over: all do
  Where where{Where::at};
  double x{};  ///< interpolated in logarithms; the first or the last value where the crossing is beyond
};

/// The widest pitch that meets the tolerance together with all narrower swept pitches.
struct PitchMet {
  Selection at;  ///< values of the factors; pitch, origin and rotation are open
  std::size_t algorithm{};
  Crossing pitch;
  std::optional<Crossing> low, high;  ///< 95 %: crossings of the metric's upper and lower bound; none for one run
  Crossing worst;                     ///< with the worst origin and rotation
  std::optional<Crossing> limit;      ///< the pitch that the best possible algorithm needs
};

struct CampaignSummary {
  std::vector<CellMetrics> cells;     ///< environment by environment, algorithm fastest
  std::vector<PitchMet> pitches_met;  ///< empty where only one pitch was requested
  std::size_t leaks{};
  std::string digest;  ///< of every vote, in the order of the list
};

/// @param records  of all units (checked), in order
[[nodiscard]] CampaignSummary sum_up(const CampaignWork& work, const std::vector<UnitRecord>& records,
                                     Workers& workers);

/// The curve of one algorithm along `factor`.
[[nodiscard]] Curve curve_of(const CampaignWork& work, const std::vector<UnitRecord>& records, Swept factor,
                             std::size_t algorithm, const Selection& selection);
/// @param y  as many as x, which must rise (checked)
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
