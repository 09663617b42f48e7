// find_contacts: where the bodies of vehicles on different sections could touch.
#include "cosiva/zone/layout/contacts.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "cosiva/base/expect.h"
#include "cosiva/zone/circuit/followers.h"
#include "cosiva/zone/layout/contact_chunks.h"
#include "cosiva/zone/layout/contact_scan.h"

namespace cosiva::zone {
namespace {

constexpr double step_max_m = 0.005;  // between samples along a section
// Pairs of chunks to examine, and to scan sample by sample: a few seconds' work, and as much again for each chunk as
// sections that run side by side or in both directions may take.
constexpr std::size_t near_max = 20'000'000;
constexpr std::size_t near_per_chunk_max = 200;
constexpr std::size_t scan_max = 500'000;
constexpr std::size_t scan_per_chunk_max = 10;
// Far more than rounding moves a position by.
constexpr double hair_m = 1e-9;

double cross(Point2 a, Point2 b) { return a.x_m * b.y_m - a.y_m * b.x_m; }
Point2 minus(Point2 a, Point2 b) { return {a.x_m - b.x_m, a.y_m - b.y_m}; }

double distance_to_chord(Point2 p, Point2 from, Point2 to) {
  const Point2 along = minus(to, from);
  const Point2 out = minus(p, from);
  const double square = along.x_m * along.x_m + along.y_m * along.y_m;
  const double t = square > 0.0 ? std::clamp((out.x_m * along.x_m + out.y_m * along.y_m) / square, 0.0, 1.0) : 0.0;
  return norm(out.x_m - t * along.x_m, out.y_m - t * along.y_m);
}

double distance_between_chords(Point2 a, Point2 b, Point2 c, Point2 d) {
  const Point2 ab = minus(b, a);
  const Point2 cd = minus(d, c);
  const bool c_and_d_apart = cross(ab, minus(c, a)) * cross(ab, minus(d, a)) < 0.0;
  const bool a_and_b_apart = cross(cd, minus(a, c)) * cross(cd, minus(b, c)) < 0.0;
  if (c_and_d_apart && a_and_b_apart) return 0.0;
  return std::min(
      {distance_to_chord(a, c, d), distance_to_chord(b, c, d), distance_to_chord(c, a, b), distance_to_chord(d, a, b)});
}

/// Finds the contacts section by section. Invariant: the allowed work is enough for all that is searched after it was
/// counted.
class Finder {
 public:
  Finder(const Circuit& circuit, const ContactRules& rules)
      : circuit_{circuit}, rules_{rules}, chunks_{circuit, rules}, followers_{circuit} {}

  /// Whether the work exceeds its limit. To be checked first.
  [[nodiscard]] bool too_many();
  [[nodiscard]] std::vector<Contact> contacts();

 private:
  [[nodiscard]] bool one_gentle_path(const Chunk& a, const Chunk& b) const;
  [[nodiscard]] bool all_follow(const Chunk& a, const Chunk& b) const;
  [[nodiscard]] bool may_touch(const Chunk& body, const Chunk& line) const;
  [[nodiscard]] bool find_pairs(SectionId on);
  [[nodiscard]] bool find_near_turn(SectionId turning);
  void allow();

  const Circuit& circuit_;
  const ContactRules& rules_;
  Chunks chunks_;
  Followers followers_;
  std::size_t near_left_{0};  ///< the rest of the allowed work
  std::size_t scans_left_{0};
  std::vector<ContactScan::Pair> pairs_;  ///< of the present section's chunks
  std::vector<std::uint32_t> near_turn_;  ///< chunks near the present section's end
};

void Finder::allow() {
  near_left_ = near_max + near_per_chunk_max * chunks_.size();
  scans_left_ = scan_max + scan_per_chunk_max * chunks_.size();
}

/// Whether all of both chunks lies on one track that turns so little that a vehicle nearby follows: then chord ≥
/// arc·cos(turn/2) keeps those apart that are further than `follow_m` along it, and there is nothing to scan.
bool Finder::one_gentle_path(const Chunk& a, const Chunk& b) const {
  const auto bend = [&](const Chunk& chunk) { return circuit_.section(chunk.section).curvature_max_per_m(); };
  const auto gentle = [&](double turn_rad) {
    return (1.0 - turn_rad * turn_rad / 8.0) * rules_.follow_m > rules_.reach_m;
  };
  if (a.section == b.section) return gentle(bend(a) * (std::max(a.to_m, b.to_m) - std::min(a.from_m, b.from_m)));
  const auto joined = [&](const Chunk& first, const Chunk& second) {
    const auto next = circuit_.next(first.section);
    if (std::find(next.begin(), next.end(), second.section) == next.end()) return false;
    const double rest_m = circuit_.section(first.section).length_m() - first.from_m;
    const double turn_rad = std::fabs(circuit_.turn_at(first.section, second.section));
    return followers_.follows(first.section, second.section) &&
           gentle(bend(first) * rest_m + turn_rad + bend(second) * second.to_m);
  };
  return joined(a, b) || joined(b, a);
}

/// Whether of two vehicles anywhere on the two chunks one follows the other: then there is nothing to scan.
bool Finder::all_follow(const Chunk& a, const Chunk& b) const {
  const double follow_m = rules_.follow_m - hair_m;
  if (a.section == b.section && std::max(a.to_m - b.from_m, b.to_m - a.from_m) <= follow_m) return true;
  const auto behind = [&](const Chunk& first, const Chunk& second) {
    const double rest_m = circuit_.section(first.section).length_m() - first.from_m;
    return rest_m + followers_.gap_m(first.section, second.section) + second.to_m <= follow_m;
  };
  return behind(a, b) || behind(b, a);
}

/// By the chords: a body whose centre is on one chunk reaches half its length beyond it and half its width to each side
/// of it.
bool Finder::may_touch(const Chunk& body, const Chunk& line) const {
  const double chord_m = distance(body.start, body.end);
  const double out_m = rules_.half_length_m;
  const Point2 along = chord_m > 0.0 ? Point2{(body.end.x_m - body.start.x_m) / chord_m * out_m,
                                              (body.end.y_m - body.start.y_m) / chord_m * out_m}
                                     : Point2{};
  const Point2 from{body.start.x_m - along.x_m, body.start.y_m - along.y_m};
  const Point2 to{body.end.x_m + along.x_m, body.end.y_m + along.y_m};
  const double sideways_m = rules_.half_width_m + (chord_m > 0.0 ? body.sideways_m : out_m) + body.bulge_m;
  return distance_between_chords(from, to, line.start, line.end) <= sideways_m + rules_.near_m + line.bulge_m;
}

/// Fills `pairs_`: for each chunk of a section the chunks near enough to scan, sorted. False, and unfinished, when
/// there are too many in all.
bool Finder::find_pairs(SectionId on) {
  pairs_.clear();
  bool few = true;
  for (std::uint32_t mine = chunks_.first_of(on); few && mine < chunks_.first_of(on + 1); ++mine) {
    const Chunk& a = chunks_[mine];
    chunks_.visit_around(a.centre, [&](std::uint32_t theirs) {
      const Chunk& b = chunks_[theirs];
      if (near_left_-- == 0) return few = false;
      if (distance(a.centre, b.centre) > a.radius_m() + b.radius_m() + rules_.reach_m || one_gentle_path(a, b) ||
          !may_touch(a, b))
        return true;
      if (scans_left_-- == 0) return few = false;
      if (!all_follow(a, b)) pairs_.push_back({b.section, mine, theirs});
      return true;
    });
  }
  std::sort(pairs_.begin(), pairs_.end());
  return few;
}

/// Fills `near_turn_` with the chunks near a section's end where vehicles turn on the spot; none where they do not.
/// False: too many in all.
bool Finder::find_near_turn(SectionId turning) {
  near_turn_.clear();
  const auto next = circuit_.next(turning);
  if (!circuit_.part(turning).pivots ||
      std::all_of(next.begin(), next.end(), [&](SectionId after) { return circuit_.turn_at(turning, after) == 0.0; }))
    return true;
  const Point2 centre = position(circuit_.section(turning).end());
  const double reach_m = rules_.disc_m + norm(rules_.half_length_m, rules_.half_width_m);
  bool few = true;
  chunks_.visit_around(centre, [&](std::uint32_t index) {
    if (near_left_-- == 0) return few = false;
    const Chunk& chunk = chunks_[index];
    if (distance(chunk.centre, centre) > chunk.radius_m() + reach_m) return true;
    if (scans_left_-- == 0) return few = false;
    near_turn_.push_back(index);
    return true;
  });
  std::sort(near_turn_.begin(), near_turn_.end());
  return few;
}

bool Finder::too_many() {
  allow();
  if (!followers_.find(rules_.follow_m, near_left_)) return true;
  for (SectionId id = 0; id < circuit_.size(); ++id) {
    if (!find_pairs(id) || !find_near_turn(id)) return true;
  }
  return false;
}

std::vector<Contact> Finder::contacts() {
  allow();
  ContactScan scan{circuit_, rules_, chunks_, followers_};
  for (SectionId id = 0; id < circuit_.size(); ++id) {
    const bool few = find_pairs(id) && find_near_turn(id);
    COSIVA_EXPECT(few);  // counted already
    for (auto first = pairs_.begin(); first != pairs_.end();) {
      const auto last = std::find_if(first, pairs_.end(), [&](const auto& pair) { return pair.other != first->other; });
      scan.along(id, first->other, {first, last});
      first = last;
    }
    for (auto first = near_turn_.begin(); first != near_turn_.end();) {
      const SectionId on = chunks_[*first].section;
      const auto last =
          std::find_if(first, near_turn_.end(), [&](std::uint32_t chunk) { return chunks_[chunk].section != on; });
      scan.turn(on, id, {first, last});
      first = last;
    }
  }
  std::stable_sort(scan.contacts.begin(), scan.contacts.end(), [](const Contact& a, const Contact& b) {
    if (a.on != b.on) return a.on < b.on;
    return a.other != b.other ? a.other < b.other : a.from_m < b.from_m;
  });
  return std::move(scan.contacts);
}

}  // namespace

ContactRules::ContactRules(const VehicleShape& shape, double clearance)
    : half_length_m{0.5 * shape.length_m},
      half_width_m{0.5 * shape.width_m},
      near_m{half_width_m + clearance},
      disc_m{norm(half_length_m, half_width_m) + clearance},
      reach_m{norm(half_length_m, half_width_m) + near_m},
      follow_m{shape.length_m + shape.width_m + 2.0 * clearance},
      step_m{std::max(step_max_m, half_width_m / 20.0)} {}

std::optional<std::vector<Contact>> find_contacts(const Circuit& circuit, const ContactRules& rules) {
  Finder finder{circuit, rules};
  // Counted first: a scan that will be abandoned takes a hundred times as long.
  if (finder.too_many()) return std::nullopt;
  return finder.contacts();
}

}  // namespace cosiva::zone
