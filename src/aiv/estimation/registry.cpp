#include "cosiva/aiv/estimation/registry.h"

#include <algorithm>
#include <utility>

#include "cosiva/aiv/estimation/arc.h"
#include "cosiva/aiv/estimation/calibrating.h"
#include "cosiva/aiv/estimation/particles.h"
#include "cosiva/aiv/estimation/planar.h"
#include "cosiva/base/expect.h"

namespace cosiva::estimation {
namespace {

template <typename T>
std::unique_ptr<Algorithm> made(const Setting& setting) {
  return std::make_unique<T>(setting);
}

bool well_named(std::string_view name) {
  const auto fits = [](char c) { return (c >= 'a' && c <= 'z') || (c >= '0' && c <= '9') || c == '_'; };
  return !name.empty() && std::ranges::all_of(name, fits);
}

}  // namespace

Registry::Registry() {
  all_ = {
      {"dead_reckoning", "odometry alone, along the sections (equations 1 to 3)", false, false, made<DeadReckoning>},
      {"reset_rule", "the article's: dead reckoning, and the fiducial's position on every reading", true, false,
       made<ResetRule>},
      {"arc_kalman", "Kalman filter of the arc length", true, false, made<ArcKalman>},
      {"arc_kalman_scale", "the same with the odometer's scale as a state", true, false, made<ArcKalmanScale>},
      {"ekf", "extended Kalman filter of the pose, with a gate", false, false, made<Ekf>},
      {"ukf", "unscented Kalman filter of the pose, with a gate", false, false, made<Ukf>},
      {"iekf", "invariant extended Kalman filter on SE(2)", false, false, made<InvariantEkf>},
      {"particles", "particle filter on the graph of sections", true, false, made<ParticleFilter>},
      {"arc_smoother", "Rauch-Tung-Striebel smoother of the arc length, over the whole run", true, true,
       made<ArcSmoother>},
      {"ufir", "unbiased FIR filter over the last readings", true, false, made<UnbiasedFir>},
      {"calibrating", "EKF that estimates scales and biases, reduces outliers, and searches for its heading", false,
       false, made<CalibratingFilter>},
      {"smoother", "the same over the whole run, forwards and backwards until convergence", false, true,
       made<CalibratingSmoother>},
  };
  for (const Registered& one : all_)
    COSIVA_EXPECT(well_named(one.name) && std::ranges::count(all_, one.name, &Registered::name) == 1);
}

Result<void> Registry::add(Registered algorithm) {
  if (!well_named(algorithm.name)) return fail("algorithm.name", "a name is of a-z, 0-9 and _", algorithm.name);
  if (find(algorithm.name)) return fail("algorithm.duplicate", "there is an algorithm of this name", algorithm.name);
  all_.push_back(std::move(algorithm));
  return {};
}

Result<const Registered*> Registry::find(std::string_view name) const {
  const auto found = std::ranges::find(all_, name, &Registered::name);
  if (found != all_.end()) return &*found;
  std::string there;
  for (const Registered& one : all_) there += (there.empty() ? "" : ", ") + one.name;
  return fail("algorithm.unknown", "there is no such algorithm; there are " + there, std::string(name));
}

Result<std::unique_ptr<Algorithm>> Registry::make(std::string_view name, const Setting& setting) const {
  const auto found = find(name);
  if (!found) return tl::unexpected(found.error());
  if ((*found)->needs_track && !setting.track)
    return fail("algorithm.track", "the algorithm needs a track, and there is none here", std::string(name));
  if (!setting.start_known && name != "particles")
    return fail("algorithm.start", "the algorithm needs a known start; only particles does without", std::string(name));
  return (*found)->make(setting);
}

}  // namespace cosiva::estimation
