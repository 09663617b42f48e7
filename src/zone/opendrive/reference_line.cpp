#include "cosiva/zone/opendrive/reference_line.h"

#include <algorithm>
#include <cmath>

#include "cosiva/zone/opendrive/sloppy_records.h"

namespace cosiva::zone::opendrive {
namespace {

// Gaps by a file's own rounding at a joint stay: fit() bridges them without bending a line.
constexpr double gap_free_m = 5e-6;
constexpr double kink_free_rad = 5e-7;
constexpr double worth_a_diagnostic = 1e-4;  // metres or radians

/// Whether the parameter's range and the length contradict each other, and the length is the one that fits the next
/// record.
bool goes_on_too_long(const PlanRecord& record, const Geometry& geometry, const Pose2* next) {
  const auto* path = std::get_if<CubicPath>(&record.path);
  if (path == nullptr || record.arc <= geometry.length + std::max(0.01, 0.01 * geometry.length)) return false;
  if (next == nullptr) return true;
  return distance(path->at(geometry.length).p, position(*next)) < distance(path->at(record.arc).p, position(*next));
}

}  // namespace

std::optional<ReferenceLine> ReferenceLine::make(const Road& road, Report& report) {
  ReferenceLine line;
  std::vector<const Geometry*> plan;
  for (const Geometry& geometry : road.plan) {
    if (geometry.length >= record_min_m) plan.push_back(&geometry);
  }
  if (plan.empty()) {
    report.add(Diagnostic::Kind::lost, "roads without a plan view", road.location, "has no plan view of any length");
    return std::nullopt;
  }
  const auto by_s = [](const Geometry* a, const Geometry* b) { return a->s < b->s; };
  if (!std::is_sorted(plan.begin(), plan.end(), by_s)) {
    std::stable_sort(plan.begin(), plan.end(), by_s);
    report.add(Diagnostic::Kind::mended, "plan views out of order", road.location,
               "its geometry records are not in the order of their s; they are taken in that order");
  }
  std::vector<PlanRecord> records;
  for (std::size_t i = 0; i < plan.size(); ++i) {
    auto record = make_record(*plan[i], report);
    if (!record) return std::nullopt;
    if (goes_on_too_long(*record, *plan[i], i + 1 < plan.size() ? &plan[i + 1]->start : nullptr)) {
      report.add(Diagnostic::Kind::mended, "records that go on beyond their length", plan[i]->location,
                 "its polynomials lead on for " + metres(record->arc) + "; they are taken up to its length, " +
                     metres(plan[i]->length));
      record->arc = plan[i]->length;
    }
    records.push_back(std::move(*record));
  }
  drop_crumbs(plan, records, report);
  redraw_sloppy_records(plan, records, report);
  line.lay(road, plan, std::move(records), report);
  for (std::size_t i = 0; i + 1 < plan.size(); ++i) {
    if (!line.close_joint(i, plan[i + 1]->location, report)) return std::nullopt;
  }
  std::sort(line.breaks_.begin(), line.breaks_.end());
  return line;
}

/// Computes the range of each record along the road's s.
void ReferenceLine::lay(const Road& road, const std::vector<const Geometry*>& plan, std::vector<PlanRecord> records,
                        Report& report) {
  double s = plan.front()->s;
  for (std::size_t i = 0; i < plan.size(); ++i) {
    PlanRecord& record = records[i];
    const double until = i + 1 < plan.size() ? plan[i + 1]->s : std::max(road.length, plan[i]->s);
    const double published = until - plan[i]->s;
    // A hundredth is rounding, or an inaccurate spline; more is a contradiction, and the shape is trusted.
    const double off_m = std::fabs(published - record.arc) - 1.5 * record.slack;
    const bool plausible = off_m <= std::max(0.01, 0.01 * record.arc) && published > 0.5 * record_min_m;
    if (!plausible || off_m > 1e-3 + 1e-4 * record.arc) {
      report.add(Diagnostic::Kind::mended, "records whose s and shape disagree in length", plan[i]->location,
                 "the file has " + metres(published) + " for it, but it is " + metres(record.arc) + " long; " +
                     (plausible ? "lanes are stretched along it accordingly" : "its own length is taken"));
    }
    record.from = s;
    s += plausible ? published : record.arc;
    record.factor = record.arc / (s - record.from);
    records_.push_back(std::move(record));
    ends_.push_back(s);
  }
}

/// Both records are moved by half, over some metres.
bool ReferenceLine::close_joint(std::size_t index, const std::string& location, Report& report) {
  PlanRecord& before = records_[index];
  PlanRecord& after = records_[index + 1];
  const Jet left = raw(before, ends_[index]);
  const Jet right = raw(after, after.from);
  breaks_.push_back(after.from);
  const double gap_m = distance(left.p, right.p);
  const double kink_rad = wrap_angle(right.heading_rad() - left.heading_rad());
  if (gap_m <= gap_free_m && std::fabs(kink_rad) <= kink_free_rad) return true;

  if (!can_close(before, left, right, after)) {
    report.add(Diagnostic::Kind::lost, "roads with a gap or a corner", location,
               "begins " + metres(gap_m) + " and " + std::to_string(kink_rad) +
                   " rad from where the record before it ends, which is too much to round: the road is not taken");
    return false;
  }
  const double reach_m = easing_reach(0.5 * gap_m, 0.5 * kink_rad);
  const SinCos mean = sincos(left.heading_rad() + 0.5 * kink_rad);
  const Point2 half{0.5 * (right.p.x_m - left.p.x_m), 0.5 * (right.p.y_m - left.p.y_m)};
  const auto slope_of = [&](const Jet& jet, double sign) {
    const double v = norm(jet.d.x_m, jet.d.y_m);
    return Point2{sign * (v * mean.cos - jet.d.x_m), sign * (v * mean.sin - jet.d.y_m)};
  };
  const double over_before = std::min(reach_m, ends_[index] - before.from);
  const double over_after = std::min(reach_m, ends_[index + 1] - after.from);
  const Point2 turn_before = slope_of(left, -1.0);  // by the distance back from the joint
  const Point2 turn_after = slope_of(right, 1.0);
  before.at_end = {{half.x_m, turn_before.x_m, over_before}, {half.y_m, turn_before.y_m, over_before}};
  after.at_start = {{-half.x_m, turn_after.x_m, over_after}, {-half.y_m, turn_after.y_m, over_after}};
  breaks_.push_back(after.from - over_before);
  breaks_.push_back(after.from + over_after);
  if (gap_m > worth_a_diagnostic || std::fabs(kink_rad) > worth_a_diagnostic) {
    report.add(Diagnostic::Kind::mended, "joints of records that do not meet", location,
               "begins " + metres(gap_m) + " and " + std::to_string(kink_rad) +
                   " rad from where the record before it ends; smoothed over " + metres(reach_m) + " to each side");
  }
  return true;
}

Jet ReferenceLine::at(const PlanRecord& record, double s) const {
  Jet jet = raw(record, s);
  const auto add = [&](const PlanRecord::Eased& eased, double x, double sign) {
    jet.p = {jet.p.x_m + eased.x.at(x), jet.p.y_m + eased.y.at(x)};
    jet.d = {jet.d.x_m + sign * eased.x.slope_at(x), jet.d.y_m + sign * eased.y.slope_at(x)};
    jet.dd = {jet.dd.x_m + eased.x.bend_at(x), jet.dd.y_m + eased.y.bend_at(x)};
  };
  if (record.at_start) add(*record.at_start, s - record.from, 1.0);
  if (record.at_end) add(*record.at_end, ends_[static_cast<std::size_t>(&record - records_.data())] - s, -1.0);
  return jet;
}

Jet ReferenceLine::at(double s) const {
  s = std::clamp(s, records_.front().from, length());
  const auto after = std::upper_bound(records_.begin() + 1, records_.end(), s,
                                      [](double value, const PlanRecord& record) { return value < record.from; });
  return at(*(after - 1), s);
}

}  // namespace cosiva::zone::opendrive
