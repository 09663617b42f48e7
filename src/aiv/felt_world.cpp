#include "aiv/felt_world.h"

#include <algorithm>
#include <cmath>
#include <utility>

namespace cosiva::aiv {
namespace {

constexpr double infinite = std::numeric_limits<double>::infinity();
/// A long body is felt as discs on its middle line, no further apart than this.
constexpr double disc_spacing_m = 0.05;

}  // namespace

FeltWorld::FeltWorld(const zone::TrafficZone& zone, Model model)
    : zone_{zone}, model_{model}, way_{zone.circuit, model.sample_m, model.reach_m} {}

bool FeltWorld::hear(SimTime now, wire::Ahead ahead) {
  const auto was_there = [this](const wire::Body& body) {
    return std::ranges::find(ahead_.bodies, body.id, &wire::Body::id) != ahead_.bodies.end();
  };
  const bool same = ahead.bodies.size() == ahead_.bodies.size() && std::ranges::all_of(ahead.bodies, was_there);
  ahead_ = std::move(ahead);
  heard_at_ = now;
  news_at_ = now;
  return !same;
}

void FeltWorld::forget() {
  ahead_.bodies.clear();
  news_at_.reset();
}

void FeltWorld::age(SimTime now) {
  if (news_at_ && now - *news_at_ > model_.memory) forget();
}

double FeltWorld::disc_gap_m(Point2 p_B, double radius_m) const {
  const double half_m = 0.5 * zone_.vehicle.width_m + model_.margin_m;
  const WayAhead::Beside there = way_.beside(p_B);
  const double near_m = half_m + radius_m + way_.sample_m();
  if (!(there.distance2_m2 < near_m * near_m)) return infinite;
  const double along_m = way_.along_way_m(p_B, there.sample);
  // Beyond the last sample the way is not known any more, and behind the middle nothing holds the vehicle.
  if (along_m <= 0.0 || along_m > way_.length_m() + 0.5 * way_.sample_m()) return infinite;
  const double beyond_m = along_m - static_cast<double>(there.sample) * way_.sample_m();
  const double beside_m = std::sqrt(std::max(0.0, there.distance2_m2 - beyond_m * beyond_m));
  // How far the disc's part inside the corridor reaches along the way, to either side of its middle.
  const double outside_m = std::max(0.0, beside_m - half_m);
  if (outside_m > radius_m) return infinite;
  const double extent_m = std::sqrt(radius_m * radius_m - outside_m * outside_m);
  return std::max(0.0, along_m - extent_m - 0.5 * zone_.vehicle.length_m);
}

double FeltWorld::body_gap_m(const wire::Body& body, const Pose2& X_BM, double carried_s) const {
  const Point2 middle_M{body.x_m + body.vx_mps * carried_s, body.y_m + body.vy_mps * carried_s};
  const Point2 middle_B = X_BM * middle_M;
  const double half_m = 0.5 * body.length_m;
  if (norm(middle_B.x_m, middle_B.y_m) > model_.reach_m + half_m + body.radius_m) return infinite;
  const auto discs = static_cast<int>(std::ceil(body.length_m / disc_spacing_m)) + 1;
  const auto [sin, cos] = sincos(body.heading_rad + X_BM.heading_rad);
  double nearest_m = infinite;
  for (int i = 0; i < discs; ++i) {
    const double along_m = discs == 1 ? 0.0 : body.length_m * i / (discs - 1) - half_m;
    const Point2 p_B{middle_B.x_m + along_m * cos, middle_B.y_m + along_m * sin};
    nearest_m = std::min(nearest_m, disc_gap_m(p_B, body.radius_m));
  }
  // Whoever is touched by something mostly behind it drives away from it; two that feel each other do not both wait.
  if (nearest_m <= 0.0 && middle_B.x_m <= 0.0) return infinite;
  return nearest_m;
}

FeltWorld::Contact FeltWorld::first(SimTime now, const Outlook& outlook) {
  Contact contact;
  if (ahead_.bodies.empty()) return contact;
  way_.sample(outlook);
  const Pose2 X_BM = inverse(outlook.X_MB ? *outlook.X_MB : zone_.circuit.pose_at(outlook.here));
  const double carried_s = to_seconds(std::clamp(now - heard_at_, SimDuration::zero(), model_.carry_max));
  for (const wire::Body& body : ahead_.bodies) {
    const double gap_m = body_gap_m(body, X_BM, carried_s);
    if (gap_m < contact.gap_m) contact = {gap_m, body.id};
  }
  return contact;
}

void FeltWorld::fold(Digest& digest) const {
  digest.add(std::uint64_t{informed()});
  digest.add(std::uint64_t{ahead_.header_id});
  digest.add(std::uint64_t{ahead_.bodies.size()});
  for (const wire::Body& body : ahead_.bodies) {
    digest.add(std::string_view{body.id});
    digest.add(body.x_m);
    digest.add(body.y_m);
  }
}

}  // namespace cosiva::aiv
