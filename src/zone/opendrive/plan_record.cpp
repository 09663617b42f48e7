#include "cosiva/zone/opendrive/plan_record.h"

#include <algorithm>
#include <cmath>

namespace cosiva::zone::opendrive {
namespace {

constexpr double crumb_max_m = 0.3;

}  // namespace

std::optional<PlanRecord> make_record(const Geometry& geometry, Report& report) {
  const auto lost = [&](const std::string& why) {
    report.add(Diagnostic::Kind::lost, "roads whose plan view cannot be followed", geometry.location,
               "cannot be followed, and its road is not taken: " + why);
    return std::nullopt;
  };
  if (const auto* clothoid = std::get_if<Clothoid>(&geometry.shape)) {
    const double rate = (clothoid->curvature_end - clothoid->curvature_start) / geometry.length;
    auto section = Section::make(geometry.start, geometry.length, clothoid->curvature_start, rate);
    if (!section) return lost(section.error().message);
    return PlanRecord{0.0, 1.0, geometry.length, std::move(*section)};
  }
  Cubics cubics = std::get<Cubics>(geometry.shape);
  auto path = CubicPath::make(geometry.start, cubics, geometry.length);
  const auto off = [&](const std::optional<CubicPath>& made) {
    return made ? std::fabs(made->length() / geometry.length - 1.0) : 1e9;
  };
  if (cubics.range != Cubics::Range::along_u && off(path) > 0.05) {
    const bool was_normalized = cubics.range == Cubics::Range::normalized;
    cubics.range = was_normalized ? Cubics::Range::arc_length : Cubics::Range::normalized;
    if (auto other = CubicPath::make(geometry.start, cubics, geometry.length); off(other) < 0.01) {
      path = std::move(other);
      report.add(Diagnostic::Kind::mended, "paramPoly3 with the wrong pRange", geometry.location,
                 std::string("its length is that of the other pRange, which is taken: ") +
                     (was_normalized ? "arcLength" : "normalized"));
    }
  }
  if (!path) return lost("its polynomials do not move, or lead further than 100 km");
  const double arc = path->length();
  return PlanRecord{0.0, 1.0, arc, std::move(*path)};
}

Jet raw(const PlanRecord& record, double s) {
  const double arc = (s - record.from) * record.factor;
  Jet jet;
  if (const auto* section = std::get_if<Section>(&record.path)) {
    const Pose2 pose = section->pose_at(arc);
    const SinCos direction = sincos(pose.heading_rad);
    const double bend = section->curvature_at(arc);
    jet = {position(pose), {direction.cos, direction.sin}, {-bend * direction.sin, bend * direction.cos}};
  } else {
    jet = std::get<CubicPath>(record.path).at(arc);
  }
  const double f = record.factor;
  return {jet.p, {f * jet.d.x_m, f * jet.d.y_m}, {f * f * jet.dd.x_m, f * f * jet.dd.y_m}};
}

bool can_close(const PlanRecord& before, const Jet& left, const Jet& right, const PlanRecord& after) {
  return distance(left.p, right.p) <= std::min(gap_max_m, 0.5 * std::min(before.arc, after.arc)) &&
         std::fabs(wrap_angle(right.heading_rad() - left.heading_rad())) <= corner_max_rad;
}

void drop_crumbs(std::vector<const Geometry*>& plan, std::vector<PlanRecord>& records, Report& report) {
  const auto left_out = [&](const Geometry* geometry, const PlanRecord& record) {
    report.add(Diagnostic::Kind::mended, "crumbs of plan views", geometry->location,
               "is " + metres(record.arc) + " long and does not meet its neighbours; it is left out");
    return record.arc + record.slack;
  };
  std::size_t kept = 1;  // so many of those before i stay
  for (std::size_t i = 1; i < records.size(); ++i) {
    bool stays = true;
    while (stays) {
      const PlanRecord& before = records[kept - 1];
      const PlanRecord& after = records[i];
      if (std::min(before.arc, after.arc) > crumb_max_m ||
          can_close(before, raw(before, before.arc), raw(after, 0.0), after))
        break;
      // The first record stays in place: the road begins there. One that is no crumb is not left out for its sake.
      if (kept == 1 && after.arc > crumb_max_m) break;
      stays = kept > 1 && before.arc < after.arc;
      const double removed = stays ? left_out(plan[kept - 1], before) : left_out(plan[i], after);
      if (stays) --kept;
      records[kept - 1].slack += removed;
    }
    if (!stays) continue;
    if (kept != i) {
      records[kept] = std::move(records[i]);
      plan[kept] = plan[i];
    }
    ++kept;
  }
  records.erase(records.begin() + static_cast<std::ptrdiff_t>(kept), records.end());
  plan.erase(plan.begin() + static_cast<std::ptrdiff_t>(kept), plan.end());
}

}  // namespace cosiva::zone::opendrive
