#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "cosiva/base/result.h"

namespace cosiva::experiments {

/// The factors that can be swept besides the algorithm, in the order of the grid: the first changes slowest, the
/// algorithm fastest.
enum class Swept : std::size_t {
  speed,
  odometry_noise,
  reading_noise,
  missed,
  scale_error,
  survey_error,
  rotation,
  origin_x,
  origin_y,
  pitch,
};
inline constexpr std::size_t swept_count = 10;
/// One value of each factor: an environment.
using SweptValues = std::array<double, swept_count>;

struct SweptInfo {
  std::string_view key;    ///< in plans and tables, with its unit: "pitch_m"
  std::string_view label;  ///< for display: "pitch [m]"
  std::string_view must;   ///< the requirement for each value
  double low;
  double high;
  bool low_allowed;
  double usual;
};
[[nodiscard]] const SweptInfo& info_of(Swept swept);
[[nodiscard]] inline double value_of(const SweptValues& values, Swept swept) {
  return values[static_cast<std::size_t>(swept)];
}

/// Positions of beacons: one every pitch along the path, or in a square grid over the zone that the path crosses.
enum class Fiducials { line, grid };
/// The metric that has to stay within the tolerance.
enum class EvaluatedQuantity { rmse, p95 };

/// Largest number of runs in one campaign, over all algorithms: limited by a machine's memory and the size of a table.
inline constexpr std::size_t campaign_votes_max = 2'000'000;

/// The plan of a campaign, as written by its user.
struct CampaignPlan {
  std::string name;
  std::string zone;        ///< name of a ready zone, or a file; the vehicle drives along its first loop
  std::uint32_t runs{20};  ///< in each environment; run k has seed + k in all of them, so that they can be paired
  std::uint64_t seed{1};
  double distance_m{100.0};
  double rate_hz{20.0};
  Fiducials fiducials{Fiducials::line};
  double reach_m{0.02};  ///< of the reader, in a grid
  std::uint32_t particles{500};
  std::uint32_t horizon{4};
  double threshold_m{0.01};
  double tolerance_m{0.01};
  EvaluatedQuantity evaluated{EvaluatedQuantity::rmse};
  std::vector<std::string> algorithms;
  std::array<std::vector<double>, swept_count> values;  ///< at least one of each, rising

  [[nodiscard]] const std::vector<double>& of(Swept swept) const { return values[static_cast<std::size_t>(swept)]; }
  [[nodiscard]] std::size_t environments() const;
  [[nodiscard]] std::size_t cells() const { return environments() * algorithms.size(); }
  [[nodiscard]] std::size_t votes() const { return cells() * runs; }
  /// The index of each factor's value in an environment; `index` < environments().
  [[nodiscard]] std::array<std::size_t, swept_count> indices(std::size_t index) const;
  [[nodiscard]] SweptValues environment(std::size_t index) const;
  /// The factors with more than one value.
  [[nodiscard]] std::vector<Swept> swept() const;
};

/// Reads a plan of at most 1 MiB. Fails ("campaign.plan", "scenario.…") with file, line, key, the expected and the
/// actual value.
[[nodiscard]] Result<CampaignPlan> read_campaign_plan(std::string_view toml, const std::string& origin);

}  // namespace cosiva::experiments
