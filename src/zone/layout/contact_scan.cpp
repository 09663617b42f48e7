#include "cosiva/zone/layout/contact_scan.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

namespace cosiva::zone {
namespace {

constexpr double refined_m = 1e-5;  // a contact's ends are found to this accuracy, outward
constexpr double infinity = std::numeric_limits<double>::infinity();

}  // namespace

void ContactScan::along(SectionId on, SectionId other, std::span<const Pair> pairs) {
  mine_.clear();
  for (const Pair& pair : pairs) {
    if (mine_.empty() || mine_.back() != pair.mine) mine_.push_back(pair.mine);
  }
  pairs_ = pairs;
  const double ahead_m = followers_.gap_m(on, other);
  const double behind_m = followers_.gap_m(other, on);
  const bool may_follow = on == other || ahead_m < infinity || behind_m < infinity;
  scan({on, other, rules_.near_m, may_follow, ahead_m, behind_m});
}

/// A vehicle that turns on the spot sweeps a disc.
void ContactScan::turn(SectionId on, SectionId turning, std::span<const std::uint32_t> near) {
  const auto next = circuit_.next(turning);
  const bool sharp =
      std::any_of(next.begin(), next.end(), [&](SectionId after) { return !followers_.follows(turning, after); });
  const Section& section = circuit_.section(turning);
  const double end_m = section.length_m();
  const Point2 centre = position(section.end());

  mine_.assign(near.begin(), near.end());
  pairs_ = {};
  line_.samples.assign(1, {end_m, centre, 0});
  line_before_.samples = line_.samples;
  const std::size_t first = contacts.size();
  // A vehicle from behind follows, one ahead on the only successor is followed; but not round a sharp corner.
  const double behind_m = next.size() == 1 ? followers_.gap_m(turning, on) : infinity;
  scan({on, turning, rules_.disc_m, !sharp, followers_.gap_m(on, turning), behind_m});
  const std::size_t last = contacts.size();
  for (std::size_t i = first; on != turning && i < last; ++i) {
    const double from_m = std::max(end_m - rules_.step_m, 0.0);
    contacts.push_back({turning, on, from_m, end_m, contacts[i].from_m, contacts[i].to_m, centre});
  }
}

bool ContactScan::follow_each_other(const Task& task, double s_m, double other_s_m) const {
  if (!task.may_follow) return false;
  if (task.on == task.other && std::fabs(s_m - other_s_m) <= rules_.follow_m) return true;
  const double rest_m = circuit_.section(task.on).length_m() - s_m;
  const double other_rest_m = circuit_.section(task.other).length_m() - other_s_m;
  return rest_m + task.ahead_gap_m + other_s_m <= rules_.follow_m ||
         other_rest_m + task.behind_gap_m + s_m <= rules_.follow_m;
}

/// Distance of p from the body, squared.
double ContactScan::beyond_square(const Body& body, Point2 p) const {
  const auto [sine, cosine] = body.direction;
  const double x = p.x_m - body.p.x_m;
  const double y = p.y_m - body.p.y_m;
  const double beyond_x = std::max(std::fabs(cosine * x + sine * y) - rules_.half_length_m, 0.0);
  const double beyond_y = std::max(std::fabs(cosine * y - sine * x) - rules_.half_width_m, 0.0);
  return beyond_x * beyond_x + beyond_y * beyond_y;
}

/// After a sample at `far_m` from a body, the number of samples that are still further than `near_m` from it, each
/// being at most a step from the one before. Rounded down slightly, so that rounding skips nothing.
std::size_t ContactScan::steps_between(double far_m, double near_m) const {
  const double steps = (far_m - near_m) * steps_per_m_ - 1e-6;
  return steps > 1.0 ? static_cast<std::size_t>(steps) : 0;
}

/// Whether a body at s touches anything.
bool ContactScan::touches(const Task& task, double s_m, const Line& line) const {
  const Body body = body_at(task.on, s_m, nullptr);
  for (std::size_t i = 0; i < line.samples.size(); ++i) {
    const Sample& sample = line.samples[i];
    const double square = beyond_square(body, sample.p);
    if (square > task.near_m * task.near_m)
      i += std::min(steps_between(std::sqrt(square), task.near_m), sample.more);
    else if (!follow_each_other(task, s_m, sample.s_m))
      return true;
  }
  return false;
}

/// Extends `contact` by what a body touches; false when it touches nothing.
bool ContactScan::grow(Contact& contact, double& nearest_square, const Task& task, const Body& body,
                       const Line& line) const {
  bool touched = false;
  double nearest_m = std::sqrt(nearest_square);
  for (std::size_t i = 0; i < line.samples.size(); ++i) {
    const Sample& sample = line.samples[i];
    const double x = sample.p.x_m - body.p.x_m;
    const double y = sample.p.y_m - body.p.y_m;
    const double square = x * x + y * y;
    if (touched && square >= nearest_square && contact.other_from_m <= sample.s_m && sample.s_m <= contact.other_to_m) {
      // Nothing new here, nor after it before a sample may be nearer or lies beyond the stretch known to be touched.
      std::size_t skip = std::min(steps_between(std::sqrt(square), nearest_m), sample.more);
      while (skip > 0 && line.samples[i + skip].s_m > contact.other_to_m) skip /= 2;
      i += skip;
      continue;
    }
    const double out_square = beyond_square(body, sample.p);
    if (out_square > task.near_m * task.near_m) {
      i += std::min(steps_between(std::sqrt(out_square), task.near_m), sample.more);
      continue;
    }
    if (follow_each_other(task, body.s_m, sample.s_m)) continue;
    touched = true;
    contact.other_from_m = std::min(contact.other_from_m, sample.s_m);
    contact.other_to_m = std::max(contact.other_to_m, sample.s_m);
    if (square < nearest_square) {
      nearest_square = square;
      nearest_m = std::sqrt(square);
      contact.position = {0.5 * (sample.p.x_m + body.p.x_m), 0.5 * (sample.p.y_m + body.p.y_m)};
    }
  }
  return touched;
}

/// The start of touching, between a position that touches nothing and one that does; on the safe side.
double ContactScan::boundary(const Task& task, double outside_m, double inside_m, const Line& line) const {
  while (std::fabs(outside_m - inside_m) > refined_m) {
    const double centre_m = 0.5 * (outside_m + inside_m);
    (touches(task, centre_m, line) ? inside_m : outside_m) = centre_m;
  }
  return outside_m;
}

/// Goes along the chunks `mine_`, in their order.
void ContactScan::scan(const Task& task) {
  const Contact nothing{task.on, task.other, 0.0, 0.0, infinity, -infinity, {}};
  std::optional<Contact> open;
  double nearest_square = infinity;
  double before_m = -1.0;  // the last sample that touched nothing, if any
  const auto close = [&](double outside_m, const Line& neighbour) {
    if (!open) return;
    open->to_m = boundary(task, outside_m, open->to_m, neighbour);
    contacts.push_back(*open);
    open.reset();
  };

  double end_m = -1.0;  // of the chunk before, to detect whether chunks follow each other without a hole
  for (const std::uint32_t index : mine_) {
    const Chunk& chunk = chunks_[index];
    if (!pairs_.empty()) lay_line(index);
    if (chunk.from_m != end_m) {
      close(end_m, line_before_);
      before_m = -1.0;
    }
    end_m = chunk.to_m;
    sweep_along(chunk);
    for (const Body& body : bodies_) {
      Contact grown = open.value_or(nothing);
      if (!open) nearest_square = infinity;
      if (grow(grown, nearest_square, task, body, line_)) {
        if (!open) grown.from_m = before_m < 0.0 ? body.s_m : boundary(task, before_m, body.s_m, line_);
        grown.to_m = body.s_m;
        open = grown;
      } else {
        close(body.s_m, line_);
        before_m = body.s_m;
      }
    }
    std::swap(line_before_, line_);
  }
  if (open) close(open->to_m, line_before_);
  line_before_.parts.clear();
}

/// Appends samples of a chunk, with its overhang.
void ContactScan::sample(const Chunk& chunk, std::vector<Sample>& samples) const {
  const Section& section = circuit_.section(chunk.section);
  const double length_m = chunk.to_m - chunk.from_m;
  const double count = std::max(1.0, std::ceil(length_m / rules_.step_m));
  const std::size_t first = samples.size();
  const auto stick_out = [&](double s, double sign, double out_m) {
    const Pose2 X_MP = section.pose_at(s);
    for (double x = rules_.step_m; x < out_m + rules_.step_m; x += rules_.step_m)
      samples.push_back({s, X_MP * Point2{sign * std::min(x, out_m), 0.0}, 0});
  };
  if (chunk.before_m > 0.0) stick_out(chunk.from_m, -1.0, chunk.before_m);
  for (double i = 0.0; i <= count; i += 1.0) {
    const double s = i == count ? chunk.to_m : chunk.from_m + length_m * (i / count);
    samples.push_back({s, position(section.pose_at(s)), 0});
  }
  if (chunk.after_m > 0.0) stick_out(chunk.to_m, 1.0, chunk.after_m);
  // The overhang before the start runs in the other direction; nothing is skipped from there.
  for (std::size_t i = first; i < samples.size(); ++i) {
    if (samples[i].s_m > chunk.from_m || chunk.before_m == 0.0) samples[i].more = samples.size() - 1 - i;
  }
}

/// Fills `line_` with the samples of all chunks near chunk `mine`, and removes those pairs. Most of them were near the
/// chunk before, too: these are copied.
void ContactScan::lay_line(std::uint32_t mine) {
  line_.samples.clear();
  line_.parts.clear();
  auto known = line_before_.parts.begin();
  const auto end = line_before_.parts.end();
  for (; !pairs_.empty() && pairs_.front().mine == mine; pairs_ = pairs_.subspan(1)) {
    const std::uint32_t chunk = pairs_.front().theirs;
    line_.parts.push_back({chunk, line_.samples.size()});
    while (known != end && known->chunk < chunk) ++known;
    if (known == end || known->chunk != chunk) {
      sample(chunks_[chunk], line_.samples);
      continue;
    }
    const auto begin = line_before_.samples.begin();
    const std::size_t last = known + 1 == end ? line_before_.samples.size() : (known + 1)->first;
    line_.samples.insert(line_.samples.end(), begin + static_cast<std::ptrdiff_t>(known->first),
                         begin + static_cast<std::ptrdiff_t>(last));
  }
}

/// `near`, if any, has the same direction on a straight section, which then need not be computed again.
ContactScan::Body ContactScan::body_at(SectionId on, double s_m, const Body* near) const {
  const Pose2 X_MB = circuit_.section(on).pose_at(s_m);
  const bool same = near != nullptr && near->heading_rad == X_MB.heading_rad;
  return {s_m, position(X_MB), X_MB.heading_rad, same ? near->direction : sincos(X_MB.heading_rad)};
}

/// Fills `bodies_` along a chunk.
void ContactScan::sweep_along(const Chunk& chunk) {
  bodies_.clear();
  const double length_m = chunk.to_m - chunk.from_m;
  const double count = std::max(1.0, std::ceil(length_m / rules_.step_m));
  for (double i = 0.0; i <= count; i += 1.0) {
    const double s = i == count ? chunk.to_m : chunk.from_m + length_m * (i / count);
    bodies_.push_back(body_at(chunk.section, s, bodies_.empty() ? nullptr : &bodies_.back()));
  }
}

}  // namespace cosiva::zone
