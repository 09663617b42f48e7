#include "cosiva/experiments/positioning/campaign/plan.h"

#include <algorithm>
#include <exception>

#include "cosiva/aiv/estimation/registry.h"
#include "cosiva/experiments/runs/scenario/toml_entry.h"
#include "cosiva/zone/toml/toml_node.h"
#include "cosiva/zone/toml/toml_table.h"

namespace cosiva::experiments {
namespace {

using zone::NumberRange;
using zone::toml_number;

constexpr std::size_t bytes_max = 1U << 20U;
constexpr std::size_t values_max = 10'000;
constexpr std::size_t text_max = 4096;

constexpr std::array<SweptInfo, swept_count> infos{{
    {"speed_mps", "speed [m/s]", "metres per second over 0, at most 100", 0.0, 100.0, false, 0.5},
    {"odometry_noise_m", "odometry noise after 1 m [m]", "metres from 0 to 10", 0.0, 10.0, true, 0.01},
    {"reading_noise_m", "reading noise [m]", "metres over 0, at most 10", 0.0, 10.0, false, 0.01},
    {"missed_ratio", "missed reads [ratio]", "a ratio from 0 to 0.99", 0.0, 0.99, true, 0.0},
    {"scale_error", "odometer's scale error [ratio]", "a ratio from 0 to 0.5", 0.0, 0.5, true, 0.0},
    {"survey_error_m", "survey error [m]", "metres from 0 to 10", 0.0, 10.0, true, 0.0},
    {"rotation_deg", "grid's rotation [°]", "degrees from -360 to 360", -360.0, 360.0, true, 0.0},
    {"origin_x_m", "grid's origin, x [m]", "metres from -100000 to 100000", -1e5, 1e5, true, 0.0},
    {"origin_y_m", "grid's origin, y [m]", "metres from -100000 to 100000", -1e5, 1e5, true, 0.0},
    {"pitch_m", "pitch [m]", "metres over 0, at most 100000", 0.0, 1e5, false, 0.5},
}};

NumberRange range_of(const SweptInfo& info) { return {info.must, info.low, info.high, info.low_allowed}; }

std::vector<std::string_view> algorithm_names(const estimation::Registry& registry) {
  std::vector<std::string_view> names;
  for (const estimation::Registered& one : registry.all()) names.push_back(one.name);
  return names;
}

void read_settings(const Entry& root, CampaignPlan& plan) {
  constexpr NumberRange distance{"metres over 0, at most 1000000", 0.0, 1e6, false};
  constexpr NumberRange rate{"times a second, over 0, at most 100000", 0.0, 1e5, false};
  constexpr NumberRange reach{"metres over 0, at most 10", 0.0, 10.0, false};
  constexpr NumberRange error{"metres over 0, at most 1000", 0.0, 1e3, false};
  plan.name = root.text("name", 200, "Campaign");
  plan.zone = root.text("zone", text_max, "lacet4");
  plan.runs = static_cast<std::uint32_t>(root.whole("runs", 1, 1'000'000, 20));
  plan.seed = static_cast<std::uint64_t>(root.whole("seed", 0, std::int64_t{1} << 53, 1));
  plan.distance_m = root.number("distance_m", distance, 100.0);
  plan.rate_hz = root.number("rate_hz", rate, 20.0);
  plan.fiducials = root.one_of("fiducials", {"line", "grid"}, "line") == "grid" ? Fiducials::grid : Fiducials::line;
  plan.reach_m = root.number("reach_m", reach, 0.02);
  plan.particles = static_cast<std::uint32_t>(root.whole("particles", 10, 1'000'000, 500));
  plan.horizon = static_cast<std::uint32_t>(root.whole("horizon", 1, 1000, 4));
  plan.threshold_m = root.number("threshold_m", error, 0.01);
  plan.tolerance_m = root.number("tolerance_m", error, 0.01);
  plan.evaluated =
      root.one_of("tolerance_of", {"rmse", "p95"}, "rmse") == "p95" ? EvaluatedQuantity::p95 : EvaluatedQuantity::rmse;
}

/// Parameters of a grid are refused for beacons on a line; a grid's reader must detect one beacon at a time.
void check_fiducials(const Entry& root, const Entry& vary, const CampaignPlan& plan) {
  if (plan.fiducials == Fiducials::line) {
    for (const Swept swept : {Swept::rotation, Swept::origin_x, Swept::origin_y})
      if (vary.has(info_of(swept).key))
        vary.fault(info_of(swept).key, "campaign.plan", "only a grid has it: set fiducials = \"grid\"");
    if (root.has("reach_m")) root.fault("reach_m", "campaign.plan", "only a grid needs it: set fiducials = \"grid\"");
  } else if (2.0 * plan.reach_m > plan.of(Swept::pitch).front()) {
    vary.fault(vary.has(info_of(Swept::pitch).key) ? info_of(Swept::pitch).key : "", "campaign.plan",
               "a reader that reaches " + toml_number(plan.reach_m) + " m would detect two beacons of a grid of " +
                   toml_number(plan.of(Swept::pitch).front()) + " m at once; make reach_m at most half the pitch");
  }
}

void check_size(const Entry& vary, const CampaignPlan& plan) {
  // Each factor is at most 10⁴, but the product of ten of them may exceed an integer.
  double votes = plan.runs * static_cast<double>(plan.algorithms.size());
  for (const auto& values : plan.values) votes *= static_cast<double>(values.size());
  if (votes > static_cast<double>(campaign_votes_max))
    vary.fault("", "campaign.plan",
               "that is a grid of " + toml_number(votes) + " runs, over all algorithms; at most " +
                   std::to_string(campaign_votes_max) + " fit one campaign");
}

CampaignPlan read(const Entry& root) {
  CampaignPlan plan;
  root.expect_only({"name", "zone", "runs", "seed", "distance_m", "rate_hz", "fiducials", "reach_m", "particles",
                    "horizon", "threshold_m", "tolerance_m", "tolerance_of", "vary"});
  read_settings(root, plan);
  const auto vary = root.table("vary");
  if (!vary) return plan;
  std::vector<std::string_view> keys{"algorithm"};
  for (const SweptInfo& info : infos) keys.push_back(info.key);
  vary->expect_only(keys);
  const estimation::Registry registry;
  plan.algorithms = vary->some_of("algorithm", algorithm_names(registry), {"arc_kalman"});
  for (std::size_t i = 0; i < swept_count; ++i)
    plan.values[i] = vary->sweep(infos[i].key, range_of(infos[i]), values_max, infos[i].usual);
  check_fiducials(root, *vary, plan);
  check_size(*vary, plan);
  return plan;
}

}  // namespace

const SweptInfo& info_of(Swept swept) { return infos[static_cast<std::size_t>(swept)]; }

std::size_t CampaignPlan::environments() const {
  std::size_t count = 1;
  for (const auto& each : values) count *= each.size();
  return count;
}

std::array<std::size_t, swept_count> CampaignPlan::indices(std::size_t index) const {
  std::array<std::size_t, swept_count> at{};
  for (std::size_t i = swept_count; i-- > 0;) {
    at[i] = index % values[i].size();
    index /= values[i].size();
  }
  return at;
}

SweptValues CampaignPlan::environment(std::size_t index) const {
  const auto at = indices(index);
  SweptValues chosen{};
  for (std::size_t i = 0; i < swept_count; ++i) chosen[i] = values[i][at[i]];
  return chosen;
}

std::vector<Swept> CampaignPlan::swept() const {
  std::vector<Swept> several;
  for (std::size_t i = 0; i < swept_count; ++i)
    if (values[i].size() > 1) several.push_back(static_cast<Swept>(i));
  return several;
}

Result<CampaignPlan> read_campaign_plan(std::string_view text, const std::string& origin) {
  if (text.size() > bytes_max)
    return fail("campaign.plan", "expected at most 1 MiB, found " + std::to_string(text.size()) + " bytes", origin);
  zone::TomlFaults faults{origin, Entry::family};
  try {
    const toml::table root = toml::parse(text);
    CampaignPlan plan = read(Entry{faults, root, ""});
    if (faults.any()) return tl::unexpected(faults.first());
    return plan;
  } catch (const toml::parse_error& error) {
    faults.add("campaign.plan", static_cast<std::uint32_t>(error.source().begin.line), "",
               std::string{error.description()});
    return tl::unexpected(faults.first());
  } catch (const std::exception& error) {
    return fail("campaign.plan", std::string("cannot be read: ") + error.what(), origin);
  }
}

}  // namespace cosiva::experiments
