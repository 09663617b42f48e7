#include "cosiva/virtual/simulator/twin.h"

#include <algorithm>
#include <cmath>
#include <utility>
#include <vector>

#include "cosiva/base/archive.h"
#include "cosiva/base/expect.h"
#include "cosiva/base/math.h"
#include "cosiva/virtual/simulator/follow.h"

namespace cosiva::virtual_side {
namespace {

/// The distance of `to` along the circuit from `from`, negative behind it; nothing if it exceeds `limit_m` in both
/// directions.
std::optional<double> signed_distance(const zone::Circuit& circuit, zone::TrackPosition from, zone::TrackPosition to,
                                      double limit_m) {
  if (from.section == to.section && std::fabs(to.s_m - from.s_m) <= limit_m) return to.s_m - from.s_m;
  if (const auto forward = circuit.shortest_route(from, to, limit_m)) return forward->length_m;
  if (const auto backward = circuit.shortest_route(to, from, limit_m)) return -backward->length_m;
  return std::nullopt;
}

/// On two branches that merge or fork, bodies are nearer to each other than this for a while: the course decides which
/// branch applies.
constexpr double same_position_m = 0.1;
/// The speeds of two reports that are further apart do not give the present acceleration.
constexpr double trend_within_s = 0.5;

}  // namespace

Twin::Twin(std::string id, std::uint32_t number, SimDuration extrapolate_max)
    : id_{std::move(id)}, number_{number}, extrapolate_max_{extrapolate_max} {}

double Twin::correction_ratio(SimTime time) const {
  const SimDuration since = time - corrected_at_;
  if (since >= correction_time) return 0.0;
  if (since <= SimDuration::zero()) return 1.0;
  const double rest = 1.0 - to_seconds(since) / to_seconds(correction_time);
  return rest * rest;
}

Twin::Image Twin::image_at(const zone::Circuit* circuit, SimTime time) const {
  const double travel_s = to_seconds(std::clamp(time - report_.at, SimDuration::zero(), extrapolate_max_));
  const double ratio = correction_ratio(time);
  const bool lost = time - report_.at > extrapolate_max_;
  const double shown_speed = lost ? 0.0 : anticipation_ ? anticipation_->speed_mps(travel_s) : speed_mps_;

  if (circuit != nullptr && on_circuit_) {
    const double correction = correction_.a * ratio;
    double along = (anticipation_ ? anticipation_->distance_m(travel_s) : progress_.mps * travel_s) + correction;
    // The correction may show the twin beyond the end of its base for a moment; the extrapolation never does.
    if (along > progress_.base_left_m) along = std::max(correction, progress_.base_left_m);
    aiv::AivMotion motion = motion_;
    motion.shift(*circuit, along, remaining(position_.section),
                 on_course_ ? course_.traversed() : std::span<const zone::SectionId>{});
    const zone::TrackPosition track_position = motion.track_position(*circuit);
    const Pose2 on_line = circuit->pose_at(track_position);
    const double left = left_m_ + correction_.b * ratio;
    const SinCos turn = sincos(on_line.heading_rad);
    const Pose2 shown{on_line.x_m - left * turn.sin, on_line.y_m + left * turn.cos,
                      wrap_angle(on_line.heading_rad + heading_off_rad_ + correction_.heading_rad * ratio)};
    return {shown, track_position, shown_speed};
  }

  // Off the circuit: a constant twist; its chord turns half as much as its heading.
  double forward = report_.vx_mps.value_or(0.0) * travel_s;
  double sideways = report_.vy_mps * travel_s;
  const double length = norm(forward, sideways);
  if (length > progress_.base_left_m) {
    const double shrink = progress_.base_left_m / length;
    forward *= shrink;
    sideways *= shrink;
  }
  const double turned = report_.omega_radps * travel_s;
  const SinCos turn = sincos(report_.X_MB.heading_rad + 0.5 * turned);
  const Pose2 shown{report_.X_MB.x_m + forward * turn.cos - sideways * turn.sin + correction_.a * ratio,
                    report_.X_MB.y_m + forward * turn.sin + sideways * turn.cos + correction_.b * ratio,
                    wrap_angle(report_.X_MB.heading_rad + turned + correction_.heading_rad * ratio)};
  return {shown, std::nullopt, shown_speed};
}

zone::Circuit::Located Twin::locate(const zone::Circuit& circuit, const Pose2& X_MB) const {
  // The vehicle is nearly always still on its section or on the next one; otherwise, and if its course leads elsewhere
  // by now, the whole circuit is searched.
  if (on_circuit_ && (on_course_ || course_.empty())) {
    zone::SectionId candidate = position_.section;
    for (int tries = 0; tries < 2; ++tries) {
      const zone::Section& section = circuit.section(candidate);
      const auto near = section.nearest(position(X_MB));
      const bool inside = near.s_m > 0.0 && near.s_m < section.length_m();
      // The nearest point of a section that bends back may belong to another pass, far along: this case is left to the
      // search.
      const bool continues = tries == 0 ? std::fabs(near.s_m - position_.s_m) < relocate_beyond_m
                                        : section.length_m() < relocate_beyond_m || near.s_m < relocate_beyond_m;
      if (inside && continues && near.distance_m < 0.1) return {{candidate, near.s_m}, near.left_m, near.distance_m};
      const auto remaining = this->remaining(candidate);
      const auto next = remaining.empty() ? circuit.next(candidate) : remaining;
      if (next.empty()) break;
      candidate = next.front();
    }
  }
  zone::Circuit::Located located = circuit.locate(position(X_MB), X_MB.heading_rad);
  // If no section of matching heading is near, the vehicle is off-path near the closest section of any heading.
  if (located.distance_m > circuit_within_m) located = circuit.locate(position(X_MB));
  return prefer_course(circuit, X_MB, located);
}

zone::Circuit::Located Twin::prefer_course(const zone::Circuit& circuit, const Pose2& X_MB,
                                           zone::Circuit::Located located) const {
  constexpr std::size_t section_look_ahead = 3;
  const auto remaining = course_.remaining();
  const auto traversed = course_.traversed();
  std::vector<zone::SectionId> candidates;
  if (!course_.empty()) candidates.push_back(course_.here());
  candidates.insert(candidates.end(), remaining.begin(),
                    remaining.begin() + static_cast<std::ptrdiff_t>(std::min(remaining.size(), section_look_ahead)));
  if (std::ranges::find(candidates, located.position.section) != candidates.end()) return located;
  // The previous section is the last candidate: if sections coincide, the vehicle is on the one that its course
  // continues along.
  if (!traversed.empty()) candidates.push_back(traversed.back());
  std::optional<zone::Circuit::Located> best;
  double best_rad = 0.0;
  for (const zone::SectionId section : candidates) {
    const auto near = circuit.section(section).nearest(position(X_MB));
    const double off_rad =
        std::fabs(wrap_angle(X_MB.heading_rad - circuit.section(section).pose_at(near.s_m).heading_rad));
    const bool nearer = !best || near.distance_m < best->distance_m - 1e-3;
    const bool as_near = best && near.distance_m < best->distance_m + 1e-3;
    if (near.distance_m > same_position_m || !(nearer || (as_near && off_rad < best_rad - 1e-3))) continue;
    best = zone::Circuit::Located{{section, near.s_m}, near.left_m, near.distance_m};
    best_rad = off_rad;
  }
  return best.value_or(located);
}

void Twin::take_speed(const MotionReport& report) {
  MotionReport taken = report;
  if (!taken.vx_mps) {
    // For a vehicle that reports no velocity: the distance from its last position, if that is recent.
    const double since_s = reported_ ? to_seconds(report.at - report_.at) : 0.0;
    double speed = 0.0;
    if (since_s > 1e-3 && since_s < 2.0) speed = distance(report_.X_MB, report.X_MB) / since_s;
    taken.vx_mps = speed;
  }
  taken.vx_mps = std::clamp(*taken.vx_mps, -speed_mps_max, speed_mps_max);
  taken.vy_mps = std::clamp(taken.vy_mps, -speed_mps_max, speed_mps_max);
  taken.omega_radps = std::clamp(taken.omega_radps, -2.0 * pi, 2.0 * pi);
  report_ = taken;
  speed_mps_ = taken.vy_mps == 0.0 ? std::fabs(*taken.vx_mps) : norm(*taken.vx_mps, taken.vy_mps);
}

/// From one report to the next the twin moves as an AIV does: each section on the path responds to nextAIVposition.
/// What a report states is then its position, whatever it moved by.
void Twin::move_to(const zone::Circuit& circuit, zone::TrackPosition position, const OnMove& on_move) {
  constexpr double apart_m_max = 20.0;
  const zone::TrackPosition from = position_;
  const auto route = remaining(from.section);
  const auto distance_m = on_move && on_circuit_ && from.section != position.section
                              ? circuit.distance_ahead(from, position, apart_m_max, route)
                              : std::nullopt;
  if (distance_m) {
    aiv::AivMotion motion{circuit, from};
    motion.travel(circuit, *distance_m, route, on_move);
  }
  motion_ = aiv::AivMotion(circuit, position);
}

std::optional<Twin::Divergence> Twin::report(const zone::Circuit* circuit, SimTime now, const MotionReport& report,
                                             const OnMove& on_move, const Forecast& forecast) {
  std::optional<Divergence> divergence;
  Image shown{};
  if (reported_) {
    const Image predicted = image_at(circuit, report.at);
    divergence = Divergence{distance(predicted.X_MB, report.X_MB),
                            std::fabs(wrap_angle(predicted.X_MB.heading_rad - report.X_MB.heading_rad))};
    shown = image_at(circuit, now);
  }

  const double since_s = reported_ ? to_seconds(report.at - report_.at) : 0.0;
  take_speed(report);
  const bool was_reported = std::exchange(reported_, true);
  progress_.base_left_m = std::numeric_limits<double>::infinity();
  correction_ = {};
  corrected_at_ = now;

  bool on = false;
  if (circuit != nullptr) {
    const auto located = locate(*circuit, report.X_MB);
    const double heading_off = wrap_angle(report.X_MB.heading_rad - circuit->pose_at(located.position).heading_rad);
    const SinCos off = sincos(heading_off);
    // Across a section the motion cannot be extrapolated along it; backwards along it, it can.
    on = report.on_map && located.distance_m <= circuit_within_m && (std::fabs(off.cos) >= 0.5 || speed_mps_ < 0.01);
    if (on) move_to(*circuit, located.position, on_move);
    position_ = located.position;
    off_m_ = located.distance_m;
    left_m_ = located.left_m;
    heading_off_rad_ = heading_off;
    const double before_mps = std::exchange(progress_.mps, *report_.vx_mps * off.cos - report_.vy_mps * off.sin);
    const bool recent = since_s > 0.0 && since_s < trend_within_s;
    progress_.trend_mps2 = recent ? (progress_.mps - before_mps) / since_s : 0.0;
    follow_course(*circuit);
  }
  on_circuit_ = on;
  if (on) measure_base(*circuit);
  const auto expected = on && progress_.mps >= 0.0 && forecast ? forecast(*this) : std::nullopt;
  anticipation_.reset();
  if (expected) anticipation_.emplace(progress_.mps, *expected);
  if (was_reported) correct_from(circuit, shown);
  return divergence;
}

void Twin::set_base_end(const zone::Circuit* circuit, std::optional<zone::TrackPosition> end) {
  if (base_end_ == end) return;
  base_end_ = end;
  if (circuit != nullptr && on_circuit_) measure_base(*circuit);
}

void Twin::follow_course(const zone::Circuit& circuit) {
  // Off the path, the nearest section need not be part of the course.
  if (off_m_ <= same_position_m) on_course_ = follow(course_, circuit, position_.section);
}

void Twin::set_course(const zone::Circuit* circuit, zone::Course course) {
  course_ = std::move(course);
  on_course_ = circuit != nullptr && reported_ && !course_.empty();
  if (on_course_) follow_course(*circuit);
  if (circuit != nullptr && on_circuit_) measure_base(*circuit);
}

std::span<const zone::SectionId> Twin::remaining(zone::SectionId section) const {
  if (!on_course_) return {};
  const auto remaining = course_.remaining();
  if (course_.here() == section) return remaining;
  const auto found = std::ranges::find(remaining, section);
  return found == remaining.end() ? std::span<const zone::SectionId>{}
                                  : remaining.subspan(static_cast<std::size_t>(found - remaining.begin()) + 1);
}

void Twin::measure_base(const zone::Circuit& circuit) {
  // The vehicle may have coasted a little past the end; without this, the distance to the end would be that of a whole
  // lap.
  constexpr double overshoot_m = 0.25;
  constexpr double far_m = 1e4;
  progress_.base_left_m = std::numeric_limits<double>::infinity();
  if (!base_end_) return;
  if (circuit.shortest_route(*base_end_, position_, overshoot_m)) {
    progress_.base_left_m = 0.0;
  } else if (const auto left = circuit.distance_ahead(position_, *base_end_, far_m, remaining(position_.section))) {
    COSIVA_EXPECT(*left >= 0.0);
    progress_.base_left_m = *left;
  }
}

void Twin::correct_from(const zone::Circuit* circuit, const Image& shown) {
  const Image now = image_at(circuit, corrected_at_);
  if (distance(shown.X_MB, now.X_MB) > relocate_beyond_m) return;
  Offset offset{shown.X_MB.x_m - now.X_MB.x_m, shown.X_MB.y_m - now.X_MB.y_m,
                wrap_angle(shown.X_MB.heading_rad - now.X_MB.heading_rad)};
  if (on_circuit_) {
    const zone::TrackPosition was =
        shown.position ? *shown.position : circuit->locate(position(shown.X_MB), shown.X_MB.heading_rad).position;
    const auto along = signed_distance(*circuit, *now.position, was, 2.0 * relocate_beyond_m);
    if (!along) return;  // another branch of the circuit: the twin was shown on the wrong one
    const Pose2 on_line = circuit->pose_at(was);
    const SinCos turn = sincos(on_line.heading_rad);
    const double left = -turn.sin * (shown.X_MB.x_m - on_line.x_m) + turn.cos * (shown.X_MB.y_m - on_line.y_m);
    offset = {*along, left - left_m_, wrap_angle(shown.X_MB.heading_rad - on_line.heading_rad - heading_off_rad_)};
  }
  correction_ = offset;
}

void Twin::leave_circuit(const zone::Circuit* circuit, SimTime now, bool turns) {
  if (!reported_) return;
  const Image shown = image_at(circuit, now);
  report_.X_MB = turns ? turned_round(shown.X_MB) : shown.X_MB;
  report_.vx_mps = 0.0;
  report_.vy_mps = 0.0;
  report_.omega_radps = 0.0;
  speed_mps_ = 0.0;
  progress_ = {};
  anticipation_.reset();
  on_circuit_ = false;
  course_.clear();
  on_course_ = false;
  base_end_.reset();
  progress_.base_left_m = std::numeric_limits<double>::infinity();
  correction_ = {};
}

void Twin::fold(Digest& digest) const {
  digest.add(std::string_view{id_});
  digest.add(report_.at);
  digest.add(report_.X_MB.x_m);
  digest.add(report_.X_MB.y_m);
  digest.add(report_.X_MB.heading_rad);
  digest.add(speed_mps_);
  digest.add(position_.s_m);
  digest.add(correction_.a);
  digest.add(correction_.b);
}

void Twin::archive(Archive& archive) {
  archive(id_, number_, extrapolate_max_, reported_, report_, speed_mps_, progress_, base_end_, anticipation_,
          on_circuit_, motion_, course_, on_course_, position_, left_m_, off_m_, heading_off_rad_, corrected_at_,
          correction_);
}

}  // namespace cosiva::virtual_side
