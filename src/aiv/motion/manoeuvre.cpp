#include "cosiva/aiv/motion/manoeuvre.h"

#include <algorithm>
#include <cmath>

#include "cosiva/aiv/motion/formulas.h"
#include "cosiva/base/archive.h"
#include "cosiva/base/expect.h"
#include "cosiva/zone/circuit/path_snap.h"

namespace cosiva::aiv {

Onward onward(const zone::Circuit& circuit, zone::SectionId from, std::size_t branch) {
  const auto branches = circuit.next(from);
  if (branches.empty()) return {};
  const zone::SectionId to = branches[std::min(branch, branches.size() - 1)];
  const double turn_rad = circuit.part(from).pivots ? circuit.turn_at(from, to) : 0.0;
  if (branch == wire::no_branch && (branches.size() > 1 || turn_rad != 0.0)) return {};
  return {to, turn_rad};
}

std::optional<zone::TrackPosition> sought(const zone::Circuit& circuit, const Pose2& X_MB,
                                          const std::optional<wire::Manoeuvre>& goal) {
  const auto entry_point = goal ? zone::snap_to_path(circuit, X_MB * to_pose(*goal), goal_within_m)
                                : zone::snap_to_path(circuit, X_MB, seek_within_m);
  return entry_point ? std::optional{entry_point->position} : std::nullopt;
}

bool to_stay(const wire::Manoeuvre& goal) { return norm(1e-3 * goal.x_mm, 1e-3 * goal.y_mm) <= stays_within_m; }

wire::Manoeuvre to_manoeuvre(const Pose2& X_AB) {
  const auto milli = [](double value) { return static_cast<std::int16_t>(std::lround(1e3 * value)); };
  return {milli(X_AB.x_m), milli(X_AB.y_m), milli(X_AB.heading_rad)};
}

Pose2 to_pose(const wire::Manoeuvre& manoeuvre) {
  return {1e-3 * manoeuvre.x_mm, 1e-3 * manoeuvre.y_mm, wrap_angle(1e-3 * manoeuvre.turned_mrad)};
}

Manoeuvre::Manoeuvre(const Pose2& X_SG, const ManoeuvreRates& rates) : rates_{rates}, X_SG_{X_SG} {
  constexpr double near_m = 5e-4;
  const double distance_m = norm(X_SG.x_m, X_SG.y_m);
  const bool goes = distance_m > near_m;
  if (!goes) X_SG_ = {0.0, 0.0, X_SG.heading_rad};
  const double towards_rad = goes ? det_atan2(X_SG.y_m, X_SG.x_m) : 0.0;
  const double last_rad = wrap_angle(X_SG.heading_rad - towards_rad);
  left_[0] = std::fabs(towards_rad);
  left_[1] = goes ? distance_m : 0.0;
  left_[2] = std::fabs(last_rad);
  sign_[0] = towards_rad < 0.0 ? -1.0 : 1.0;
  sign_[1] = 1.0;
  sign_[2] = last_rad < 0.0 ? -1.0 : 1.0;
}

Manoeuvre::Step Manoeuvre::step(double speed_mps, double dt_s) {
  const bool commanded = speed_mps > 0.0;
  uncommanded_s_ = commanded ? 0.0 : uncommanded_s_ + dt_s;
  if (commanded) lasted_s_ += dt_s;
  while (leg_ < legs && left_[leg_] == 0.0) ++leg_;
  if (leg_ == legs) return {};

  const bool turns = leg_ != 1;
  const double per_s2 = turns ? rates_.turn_radps2 : rates_.speed_mps2;
  const double most = !commanded ? 0.0 : turns ? rates_.turn_radps : std::min(speed_mps, rates_.speed_mps);
  double& left = left_[leg_];
  rate_ = plain::manoeuvre_rate(rate_, most, left, per_s2, dt_s);
  constexpr double close = 1e-6;
  const double moved = left - rate_ * dt_s < close ? left : rate_ * dt_s;
  left -= moved;
  COSIVA_EXPECT(rate_ >= 0.0 && left >= 0.0);

  Step step;
  if (turns) {
    step.turned_rad = sign_[leg_] * moved;
    X_SB_.heading_rad = wrap_angle(X_SB_.heading_rad + step.turned_rad);
  } else {
    step.moved_m = moved;
    const auto [sin, cos] = sincos(X_SB_.heading_rad);
    X_SB_.x_m += cos * moved;
    X_SB_.y_m += sin * moved;
  }
  if (left > 0.0) return step;
  rate_ = 0.0;
  while (leg_ < legs && left_[leg_] == 0.0) ++leg_;
  if (leg_ == legs) X_SB_ = X_SG_;  // removes the rounding error
  return step;
}

void Manoeuvre::archive(Archive& archive) {
  archive(rates_, X_SG_, X_SB_, left_, sign_, leg_, rate_, lasted_s_, uncommanded_s_);
}

}  // namespace cosiva::aiv
