#include "cosiva/aiv/localisation/course_position.h"

#include <algorithm>
#include <array>
#include <cstddef>
#include <span>
#include <utility>
#include <vector>

#include "cosiva/base/archive.h"
#include "cosiva/base/expect.h"

namespace cosiva::aiv {
namespace {

/// Minimum number of traversed sections that are stored.
constexpr std::size_t traversed_kept = 16;

/// A set of sections. More than fit are left out. Invariant: it has no more sections than fit.
class NearSections {
 public:
  [[nodiscard]] bool room() const { return count_ < ids_.size(); }
  bool add(zone::SectionId id) {
    if (!room()) return false;
    ids_[count_++] = id;
    return true;
  }
  /// Each once, in ascending order.
  void sort() {
    COSIVA_EXPECT(count_ <= ids_.size());
    const auto end = ids_.begin() + static_cast<std::ptrdiff_t>(count_);
    std::sort(ids_.begin(), end);
    count_ = static_cast<std::size_t>(std::unique(ids_.begin(), end) - ids_.begin());
  }
  [[nodiscard]] std::span<const zone::SectionId> ids() const { return std::span{ids_}.first(count_); }

 private:
  std::array<zone::SectionId, 64> ids_;
  std::size_t count_{0};
};

/// The sections of the course within a distance of the position, each once and in ascending order.
NearSections sections_near(const CoursePosition& position, double reach_m) {
  const zone::Circuit& circuit = position.circuit();
  const zone::TrackPosition here = position.track_position();
  NearSections near;
  double end_m = circuit.section(here.section).length_m() - here.s_m;
  for (zone::SectionLookAhead ahead = section_look_ahead(circuit, position.outlook());
       near.add(ahead.section()) && end_m <= reach_m && ahead.step();)
    end_m += circuit.section(ahead.section()).length_m();
  double start_m = here.s_m;
  const auto driven = position.course().traversed();
  std::size_t traversed = driven.size();
  zone::SectionId id = here.section;
  while (start_m <= reach_m && near.room()) {
    const auto before = circuit.previous(id);
    if (traversed > 0)
      id = driven[--traversed];
    else if (before.size() == 1)
      id = before.front();
    else
      break;
    near.add(id);
    start_m += circuit.section(id).length_m();
  }
  // At a merge whose traversed branch is unknown all branches count.
  if (start_m <= reach_m)
    for (const zone::SectionId before : circuit.previous(id)) near.add(before);
  near.sort();
  return near;
}

}  // namespace

Pose2 CoursePosition::pose() const {
  const zone::TrackPosition here = track_position();
  if (here != posed_at_) {
    pose_ = circuit_.pose_at(here);
    posed_at_ = here;
  }
  return pose_;
}

void CoursePosition::jump_to(zone::TrackPosition track_position) {
  motion_ = AivMotion{circuit_, track_position};
  if (!course_.arrive(track_position.section)) course_.clear();
}

void CoursePosition::jump_without_course(zone::TrackPosition track_position) {
  motion_ = AivMotion{circuit_, track_position};
  course_.clear();
}

void CoursePosition::follow(const zone::Course& course) {
  if (course.here() != track_position().section) return course_.clear();
  // The sections actually traversed are more reliable than those assumed by an order.
  const bool driven = course_.here() == course.here() && !course_.traversed().empty();
  const auto traversed = driven ? course_.traversed() : course.traversed();
  const auto kept = traversed.last(std::min(traversed.size(), traversed_kept));
  const auto on = course.sections().subspan(course.traversed().size());
  std::vector<zone::SectionId> sections;
  sections.reserve(kept.size() + on.size());
  sections.insert(sections.end(), kept.begin(), kept.end());
  sections.insert(sections.end(), on.begin(), on.end());
  const std::size_t at = kept.size();
  course_ = zone::Course{std::move(sections), at};
  COSIVA_EXPECT(course_.here() == motion_.current_section());
}

void CoursePosition::expect_next(zone::SectionId next) { course_ = zone::Course{{motion_.current_section(), next}}; }

double CoursePosition::shift(double distance_m) {
  return distance_m < 0.0 ? shift_back(distance_m) : shift_on(distance_m);
}

double CoursePosition::shift_on(double distance_m) {
  double left_m = distance_m;
  for (;;) {
    const zone::SectionId here = motion_.current_section();
    const double length_m = circuit_.section(here).length_m();
    if (motion_.mDTCS_m() + left_m <= length_m) {
      motion_.move(circuit_, left_m);
      return distance_m;
    }
    left_m -= length_m - motion_.mDTCS_m();
    const zone::SectionLookAhead ahead = section_look_ahead(circuit_, outlook());
    if (!ahead.decided() || bend_rad(circuit_, here, ahead.next()) != 0.0) {
      motion_ = AivMotion{circuit_, {here, length_m}};
      return distance_m - left_m;
    }
    enter(ahead.next());
  }
}

double CoursePosition::shift_back(double distance_m) {
  double left_m = -distance_m;
  for (;;) {
    const zone::SectionId here = motion_.current_section();
    const double length_m = circuit_.section(here).length_m();
    const double ahead_m = length_m - motion_.mDTCS_m();
    if (ahead_m + left_m <= length_m) {
      motion_.shift(circuit_, -left_m);
      return distance_m;
    }
    left_m -= length_m - ahead_m;
    const zone::SectionId before = section_before();
    if (before == zone::no_section || bend_rad(circuit_, before, here) != 0.0) {
      motion_ = AivMotion{circuit_, {here, 0.0}};
      return distance_m + left_m;
    }
    if (!course_.traversed().empty()) {
      course_.step_back();
    } else if (!course_.empty()) {
      std::vector<zone::SectionId> sections{before};
      sections.insert(sections.end(), course_.sections().begin(), course_.sections().end());
      course_ = zone::Course{std::move(sections)};
    }
    motion_ = AivMotion{circuit_, {before, circuit_.section(before).length_m()}};
  }
}

zone::SectionId CoursePosition::section_before() const {
  if (!course_.traversed().empty()) return course_.traversed().back();
  const auto before = circuit_.previous(motion_.current_section());
  return before.empty() ? zone::no_section : before.front();
}

void CoursePosition::enter(zone::SectionId next) {
  if (!course_.empty()) {
    if (course_.remaining().empty()) course_.extend({&next, 1});
    course_.step();
    if (course_.traversed().size() >= 4 * traversed_kept) course_.forget_traversed(traversed_kept);
  }
  motion_ = AivMotion{circuit_, {next, 0.0}};
}

void CoursePosition::enter_branch(zone::SectionId next) {
  if (course_.remaining().empty() || course_.remaining().front() != next) {
    course_.cut(0);
    if (course_.empty()) course_ = zone::Course{{motion_.current_section()}};
  }
  enter(next);
  COSIVA_EXPECT(course_.here() == motion_.current_section());
}

std::optional<double> CoursePosition::offset_to(zone::TrackPosition track_position, double limit_m) const {
  const zone::TrackPosition here = motion_.track_position(circuit_);
  const auto ahead_m = circuit_.distance_ahead(here, track_position, limit_m, course_.remaining());
  const auto back_m = distance_back_m(track_position, limit_m);
  if (ahead_m && (!back_m || *ahead_m <= *back_m)) return *ahead_m;
  if (back_m) return -*back_m;
  return std::nullopt;
}

std::optional<double> CoursePosition::distance_back_m(zone::TrackPosition track_position, double limit_m) const {
  const zone::TrackPosition here = motion_.track_position(circuit_);
  const auto traversed = course_.traversed();
  double back_m = here.s_m;  // to the end of traversed[i − 1]
  for (std::size_t i = traversed.size(); i-- > 0 && back_m <= limit_m;
       back_m += circuit_.section(traversed[i]).length_m()) {
    if (traversed[i] != track_position.section) continue;
    return circuit_.distance_ahead(track_position, here, limit_m,
                                   course_.sections().subspan(i + 1, traversed.size() - i));
  }
  // The traversed sections are known further back than that, and the position is not on them.
  if (!traversed.empty() && back_m > limit_m && track_position.section != here.section) return std::nullopt;
  return circuit_.distance_ahead(track_position, here, limit_m);
}

std::optional<CoursePosition::Foot> CoursePosition::foot_of(Point2 fiducial, double reach_m,
                                                            double beside_m_max) const {
  // Sections further along than the reach cannot contain the foot.
  const NearSections sections = sections_near(*this, reach_m);
  std::optional<Foot> best;
  double best_m = beside_m_max;
  for (const zone::SectionId id : sections.ids()) {
    const auto near = circuit_.section(id).nearest(fiducial);
    if (near.distance_m >= best_m) continue;
    const auto offset_m = offset_to({id, near.s_m}, reach_m);
    if (!offset_m) continue;
    best_m = near.distance_m;
    best = Foot{*offset_m, best_m};
  }
  return best;
}

void CoursePosition::archive(Archive& archive) {
  archive(motion_, course_);
  if (archive.reads()) posed_at_ = {zone::no_section, 0.0};
}

}  // namespace cosiva::aiv
