#include "cosiva/aiv/motion/speed.h"

#include <array>
#include <cmath>
#include <cstddef>
#include <limits>

#include "cosiva/aiv/motion/formulas.h"
#include "cosiva/base/expect.h"

namespace cosiva::aiv {
namespace {

constexpr std::array profile_terms{std::string_view{"stop"}, std::string_view{"slow"}, std::string_view{"medium"},
                                   std::string_view{"fast"}};

}  // namespace

std::string_view to_string(Profile profile) { return profile_terms[static_cast<std::size_t>(profile)]; }

std::optional<Profile> parse_profile(std::string_view word) {
  for (std::size_t i = 0; i < profile_terms.size(); ++i) {
    if (profile_terms[i] == word) return static_cast<Profile>(i);
  }
  return std::nullopt;
}

zone::SpeedProfile kinematics(const zone::SpeedProfiles& profiles, Profile profile) {
  switch (profile) {
    case Profile::stop: return {0.0, profiles.medium.acceleration_mps2, profiles.medium.braking_mps2};
    case Profile::slow: return profiles.slow;
    case Profile::medium: return profiles.medium;
    case Profile::fast: return profiles.fast;
  }
  return {};
}

std::string_view to_string(Status status) {
  switch (status) {
    case Status::normal: return "Normal";
    case Status::stopped: return "stopped";
    case Status::slow_speed: return "slow speed";
    case Status::medium_speed: return "medium speed";
    case Status::fast_speed: return "fast speed";
  }
  return "?";
}

Status status_of(double speed_mps, std::optional<Profile> imposed) {
  if (std::fabs(speed_mps) < stopped_mps) return Status::stopped;
  if (!imposed) return Status::normal;
  switch (*imposed) {
    case Profile::stop: return Status::stopped;
    case Profile::slow: return Status::slow_speed;
    case Profile::medium: return Status::medium_speed;
    case Profile::fast: return Status::fast_speed;
  }
  return Status::normal;
}

SpeedChoice CrispSpeedPolicy::target(const Situation& situation) const {
  if (situation.end_of_base_m <= 0.0) return {Profile::stop};
  if (situation.imposed) return {*situation.imposed};
  return {static_cast<Profile>(static_cast<int>(plain::crisp_profile(situation.charge, situation.obstacle_ahead_m)))};
}

double stoppable_speed(double distance_m, double braking_mps2, double late_s) {
  COSIVA_EXPECT(braking_mps2 > 0.0 && late_s >= 0.0);
  if (!(distance_m > 0.0)) return 0.0;
  if (std::isinf(distance_m)) return std::numeric_limits<double>::infinity();
  return plain::stoppable_speed(distance_m, braking_mps2, late_s);
}

}  // namespace cosiva::aiv
