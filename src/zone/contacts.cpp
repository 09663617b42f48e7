// find_contacts: where the bodies of vehicles on different ways could touch.
#include "zone/contacts.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <tuple>
#include <utility>

namespace cosiva::zone {
namespace {

constexpr double step_max_m = 0.005;  // between samples along a way
constexpr double chunk_max_m = 0.25;  // ways are compared chunk by chunk
constexpr double refined_m = 1e-5;    // a span's ends are found to this, outward
// Whoever comes to a corner sharper than this does not merely follow the one that turns there: it is in its way.
constexpr double follow_turn_max_rad = pi / 4.0;
// Pairs of chunks to look at, and to scan sample by sample: a few seconds' work, and as much again for each chunk as
// ways that lie side by side or run both ways may take.
constexpr std::size_t near_max = 20'000'000;
constexpr std::size_t near_per_chunk_max = 200;
constexpr std::size_t scan_max = 500'000;
constexpr std::size_t scan_per_chunk_max = 10;
constexpr double infinity = std::numeric_limits<double>::infinity();

/// A short stretch of a section, and beyond an open end what a vehicle standing there sticks out.
struct Chunk {
  SectionId section;
  double from_m;
  double to_m;
  double before_m;  ///< straight on before from_m, 0 but at an open start
  double after_m;
  Point2 middle;
  Point2 start;  ///< of its chord, what sticks out included
  Point2 end;
  double bulge_m;     ///< how far the chunk strays from its chord
  double sideways_m;  ///< how far a body's ends leave the chord because it turns

  /// All of it lies within this of its middle.
  [[nodiscard]] double radius_m() const { return 0.5 * (to_m - from_m) + std::max(before_m, after_m); }
};

/// A sample of a centre line.
struct Sample {
  double s_m;
  Point2 p;
  std::size_t more{0};  ///< how many follow that are each at most a step from the one before
};

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

class Finder {
 public:
  Finder(const Circuit& circuit, const ContactRules& rules) : circuit_{circuit}, rules_{rules} {
    cut_chunks();
    sort_into_cells();
    near_left_ = near_max + near_per_chunk_max * chunks_.size();
    scans_left_ = scan_max + scan_per_chunk_max * chunks_.size();
  }

  /// False: too many. Without `scanning` that is all it finds out.
  [[nodiscard]] bool find(bool scanning);
  [[nodiscard]] std::vector<Contact> contacts() && { return std::move(contacts_); }

 private:
  using Cell = std::pair<std::int64_t, std::int64_t>;
  struct Neighbour {
    SectionId section;
    std::uint32_t mine;
    std::uint32_t theirs;
    friend bool operator<(const Neighbour& a, const Neighbour& b) {
      return std::tie(a.section, a.mine, a.theirs) < std::tie(b.section, b.mine, b.theirs);
    }
  };

  void cut_chunks();
  void sort_into_cells();
  [[nodiscard]] Cell cell_of(Point2 p) const;
  template <typename Visit>
  void visit_cells_around(Point2 p, const Visit& visit) const;
  [[nodiscard]] bool find_neighbours(SectionId on);

  [[nodiscard]] bool find_followers();
  [[nodiscard]] bool follows(SectionId before, SectionId after) const {
    return std::fabs(circuit_.turn_at(before, after)) <= follow_turn_max_rad;
  }
  [[nodiscard]] double ahead_m(const Place& a, const Place& b) const;
  [[nodiscard]] bool one_way(const Place& a, const Place& b) const {
    return ahead_m(a, b) <= rules_.follow_m || ahead_m(b, a) <= rules_.follow_m;
  }
  [[nodiscard]] bool one_gentle_way(const Chunk& a, const Chunk& b) const;
  [[nodiscard]] bool may_touch(const Chunk& body, const Chunk& line) const;

  void sample(const Chunk& chunk, bool with_ends, std::vector<Sample>& samples) const;
  template <typename Passes>
  bool touch(Contact& contact, double& nearest_square, double s_m, const std::vector<Sample>& line, double near_m,
             const Passes& passes) const;
  template <typename LineOf, typename Passes>
  void scan(SectionId on, SectionId other, const std::vector<std::uint32_t>& chunks, const LineOf& line_of,
            double near_m, const Passes& passes);
  void scan_section(SectionId on);
  [[nodiscard]] bool find_near_turn(SectionId turning);
  void scan_turn(SectionId turning);

  const Circuit& circuit_;
  const ContactRules& rules_;

  struct Follower {
    SectionId section;
    double gap_m;  ///< from the end of one section to the start of the other
  };
  std::vector<std::vector<Follower>> followers_;
  std::vector<Chunk> chunks_;
  std::vector<std::uint32_t> first_chunk_;  ///< of each section, and one past the last
  double cell_m_{1.0};
  std::vector<std::pair<Cell, std::uint32_t>> cells_;
  std::size_t near_left_{0};  ///< what of the allowed work is left
  std::size_t scans_left_{0};
  std::vector<Neighbour> neighbours_;     ///< of the present section's chunks
  std::vector<std::uint32_t> near_turn_;  ///< chunks near the present section's end
  std::vector<Contact> contacts_;
};

void Finder::cut_chunks() {
  for (SectionId id = 0; id < circuit_.size(); ++id) {
    first_chunk_.push_back(static_cast<std::uint32_t>(chunks_.size()));
    const Section& section = circuit_.section(id);
    // On a large zone with large vehicles, chunks grow with the vehicle.
    const double chunk_m = std::max(chunk_max_m, rules_.half_length_m);
    const double count = std::max(1.0, std::ceil(section.length_m() / chunk_m));
    const double bend_per_m = section.curvature_max_per_m();
    for (double i = 0.0; i < count; i += 1.0) {
      Chunk chunk{};
      chunk.section = id;
      chunk.from_m = section.length_m() * (i / count);
      chunk.to_m = section.length_m() * ((i + 1.0) / count);
      if (i == 0.0 && circuit_.previous(id).empty()) chunk.before_m = rules_.half_length_m;
      if (i + 1.0 == count && circuit_.next(id).empty()) chunk.after_m = rules_.half_length_m;
      chunk.middle = position(section.pose_at(0.5 * (chunk.from_m + chunk.to_m)));
      chunk.start = section.pose_at(chunk.from_m) * Point2{-chunk.before_m, 0.0};
      chunk.end = section.pose_at(chunk.to_m) * Point2{chunk.after_m, 0.0};
      // A curve strays from its chord by at most ⅛·h²·max|κ|; what sticks out is straight, but turned against it.
      const double length_m = chunk.to_m - chunk.from_m;
      const double turn_rad = std::min(bend_per_m * length_m, pi);
      chunk.bulge_m = std::min(0.125 * bend_per_m * length_m * length_m, length_m) +
                      (chunk.before_m + chunk.after_m) * turn_rad + 1e-9;
      chunk.sideways_m = rules_.half_length_m * turn_rad;
      chunks_.push_back(chunk);
    }
  }
  first_chunk_.push_back(static_cast<std::uint32_t>(chunks_.size()));
}

void Finder::sort_into_cells() {
  double radius_max_m = 0.0;
  for (const Chunk& chunk : chunks_) radius_max_m = std::max(radius_max_m, chunk.radius_m());
  // Cells so large that neighbours are in the same cell or in one of the eight around it.
  cell_m_ =
      2.0 * radius_max_m + std::max(rules_.reach_m, rules_.disc_m + norm(rules_.half_length_m, rules_.half_width_m));
  cells_.reserve(chunks_.size());
  for (std::uint32_t i = 0; i < chunks_.size(); ++i) cells_.emplace_back(cell_of(chunks_[i].middle), i);
  std::sort(cells_.begin(), cells_.end());
}

Finder::Cell Finder::cell_of(Point2 p) const {
  return {static_cast<std::int64_t>(std::floor(p.x_m / cell_m_)),
          static_cast<std::int64_t>(std::floor(p.y_m / cell_m_))};
}

/// Until visit(chunk) is false.
template <typename Visit>
void Finder::visit_cells_around(Point2 p, const Visit& visit) const {
  const Cell home = cell_of(p);
  for (std::int64_t column = home.first - 1; column <= home.first + 1; ++column) {
    const Cell low{column, home.second - 1};
    const Cell high{column, home.second + 1};
    auto at = std::lower_bound(cells_.begin(), cells_.end(), std::pair{low, std::uint32_t{0}});
    for (; at != cells_.end() && at->first <= high; ++at) {
      if (!visit(at->second)) return;
    }
  }
}

/// For each section, those that begin within `follow_m` of its end, and how far after it. False: too many.
bool Finder::find_followers() {
  followers_.resize(circuit_.size());
  for (SectionId id = 0; id < circuit_.size(); ++id) {
    auto& found = followers_[id];
    const auto go_on = [&](SectionId from, double gap_m) {
      for (const SectionId after : circuit_.next(from)) {
        if (near_left_ <= found.size()) return false;
        near_left_ -= found.size() + 1;
        if (!follows(from, after)) continue;
        const auto known =
            std::find_if(found.begin(), found.end(), [&](const Follower& f) { return f.section == after; });
        if (known == found.end())
          found.push_back({after, gap_m});
        else
          known->gap_m = std::min(known->gap_m, gap_m);
      }
      return true;
    };
    if (!go_on(id, 0.0)) return false;
    for (std::size_t i = 0; i < found.size(); ++i) {
      const double gap_m = found[i].gap_m + circuit_.section(found[i].section).length_m();
      if (gap_m <= rules_.follow_m && !go_on(found[i].section, gap_m)) return false;
    }
  }
  return true;
}

/// Distance to travel from a to b, when it is within `follow_m`; else infinity.
double Finder::ahead_m(const Place& a, const Place& b) const {
  double best_m = a.section == b.section && b.s_m >= a.s_m ? b.s_m - a.s_m : infinity;
  const double rest_m = circuit_.section(a.section).length_m() - a.s_m;
  for (const Follower& follower : followers_[a.section]) {
    if (follower.section == b.section) best_m = std::min(best_m, rest_m + follower.gap_m + b.s_m);
  }
  return best_m;
}

/// Whether all of both chunks lies on one way that turns so little that whoever is near follows: then chord ≥
/// arc·cos(turn/2) keeps those apart that are further than `follow_m` along it, and there is nothing to scan.
bool Finder::one_gentle_way(const Chunk& a, const Chunk& b) const {
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
    return turn_rad <= follow_turn_max_rad && gentle(bend(first) * rest_m + turn_rad + bend(second) * second.to_m);
  };
  return joined(a, b) || joined(b, a);
}

/// By the chords: a body whose middle is on one chunk reaches half its length beyond it and half its width beside it.
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

/// Fills `neighbours_`: for each chunk of a section the chunks near enough to scan, sorted by section, own chunk, other
/// chunk. False, and unfinished, when there are too many in all.
bool Finder::find_neighbours(SectionId on) {
  neighbours_.clear();
  bool few = true;
  for (std::uint32_t mine = first_chunk_[on]; few && mine < first_chunk_[on + 1]; ++mine) {
    const Chunk& a = chunks_[mine];
    visit_cells_around(a.middle, [&](std::uint32_t theirs) {
      const Chunk& b = chunks_[theirs];
      if (near_left_-- == 0) return few = false;
      if (distance(a.middle, b.middle) > a.radius_m() + b.radius_m() + rules_.reach_m || one_gentle_way(a, b) ||
          !may_touch(a, b))
        return true;
      if (scans_left_-- == 0) return few = false;
      neighbours_.push_back({b.section, mine, theirs});
      return true;
    });
  }
  std::sort(neighbours_.begin(), neighbours_.end());
  return few;
}

void Finder::sample(const Chunk& chunk, bool with_ends, std::vector<Sample>& samples) const {
  const Section& section = circuit_.section(chunk.section);
  const double length_m = chunk.to_m - chunk.from_m;
  const double count = std::max(1.0, std::ceil(length_m / rules_.step_m));
  const std::size_t first = samples.size();
  const auto stick_out = [&](double s, double sign, double out_m) {
    const Pose2 X_MP = section.pose_at(s);
    for (double x = rules_.step_m; x < out_m + rules_.step_m; x += rules_.step_m)
      samples.push_back({s, X_MP * Point2{sign * std::min(x, out_m), 0.0}});
  };
  if (with_ends && chunk.before_m > 0.0) stick_out(chunk.from_m, -1.0, chunk.before_m);
  for (double i = 0.0; i <= count; i += 1.0) {
    const double s = i == count ? chunk.to_m : chunk.from_m + length_m * (i / count);
    samples.push_back({s, position(section.pose_at(s))});
  }
  if (with_ends && chunk.after_m > 0.0) stick_out(chunk.to_m, 1.0, chunk.after_m);
  // What sticks out before the start goes the other way; nothing is skipped from there.
  for (std::size_t i = first; i < samples.size(); ++i) {
    if (samples[i].s_m > chunk.from_m || chunk.before_m == 0.0) samples[i].more = samples.size() - 1 - i;
  }
}

/// Grows `contact` by what a body at s touches; false when it touches nothing. What `passes` does not count.
template <typename Passes>
bool Finder::touch(Contact& contact, double& nearest_square, double s_m, const std::vector<Sample>& line, double near_m,
                   const Passes& passes) const {
  const Pose2 X_MB = circuit_.section(contact.on).pose_at(s_m);
  const auto [sine, cosine] = sincos(X_MB.heading_rad);
  bool touched = false;
  for (std::size_t i = 0; i < line.size(); ++i) {
    const Sample& sample = line[i];
    const double x = sample.p.x_m - X_MB.x_m;
    const double y = sample.p.y_m - X_MB.y_m;
    const double beyond_x = std::max(std::fabs(cosine * x + sine * y) - rules_.half_length_m, 0.0);
    const double beyond_y = std::max(std::fabs(cosine * y - sine * x) - rules_.half_width_m, 0.0);
    const double beyond_square = beyond_x * beyond_x + beyond_y * beyond_y;
    if (beyond_square > near_m * near_m) {
      // Those that follow come nearer by at most a step each. A hair less, so that rounding skips nothing.
      const double steps = (std::sqrt(beyond_square) - near_m) / rules_.step_m - 1e-6;
      if (steps > 1.0) i += std::min(static_cast<std::size_t>(steps), sample.more);
      continue;
    }
    if (passes({contact.on, s_m}, {contact.other, sample.s_m})) continue;
    touched = true;
    contact.other_from_m = std::min(contact.other_from_m, sample.s_m);
    contact.other_to_m = std::max(contact.other_to_m, sample.s_m);
    const double square = x * x + y * y;
    if (square < nearest_square) {
      nearest_square = square;
      contact.place = {0.5 * (sample.p.x_m + X_MB.x_m), 0.5 * (sample.p.y_m + X_MB.y_m)};
    }
  }
  return touched;
}

/// Goes along some chunks of one section, in their order, beside the line that `line_of` gives for each of them.
template <typename LineOf, typename Passes>
void Finder::scan(SectionId on, SectionId other, const std::vector<std::uint32_t>& chunks, const LineOf& line_of,
                  double near_m, const Passes& passes) {
  const Contact nothing{on, other, 0.0, 0.0, infinity, -infinity, {}};
  std::optional<Contact> open;
  double nearest_square = infinity;
  double before_m = -1.0;  // the last sample that touched nothing, if any
  std::vector<Sample> line_before;
  std::vector<Sample> line;
  std::vector<Sample> bodies;

  const auto boundary = [&](double outside_m, double inside_m, const std::vector<Sample>& beside) {
    while (std::fabs(outside_m - inside_m) > refined_m) {
      const double middle_m = 0.5 * (outside_m + inside_m);
      Contact scratch = nothing;
      double far = infinity;
      (touch(scratch, far, middle_m, beside, near_m, passes) ? inside_m : outside_m) = middle_m;
    }
    return outside_m;
  };
  const auto close = [&](double outside_m, const std::vector<Sample>& beside) {
    if (!open) return;
    open->to_m = boundary(outside_m, open->to_m, beside);
    contacts_.push_back(*open);
    open.reset();
  };

  double end_m = -1.0;  // of the chunk before, to see whether chunks follow each other without a hole
  for (const std::uint32_t index : chunks) {
    const Chunk& chunk = chunks_[index];
    line.clear();
    line_of(index, line);
    if (chunk.from_m != end_m) {
      close(end_m, line_before);
      before_m = -1.0;
    }
    end_m = chunk.to_m;
    bodies.clear();
    sample(chunk, false, bodies);
    for (const Sample& here : bodies) {
      Contact grown = open.value_or(nothing);
      if (!open) nearest_square = infinity;
      if (touch(grown, nearest_square, here.s_m, line, near_m, passes)) {
        if (!open) grown.from_m = before_m < 0.0 ? here.s_m : boundary(before_m, here.s_m, line);
        grown.to_m = here.s_m;
        open = grown;
      } else {
        close(here.s_m, line);
        before_m = here.s_m;
      }
    }
    std::swap(line_before, line);
  }
  if (open) close(open->to_m, line_before);
}

void Finder::scan_section(SectionId on) {
  const auto follow_each_other = [this](const Place& a, const Place& b) { return one_way(a, b); };
  std::vector<std::uint32_t> mine;
  for (std::size_t i = 0; i < neighbours_.size();) {
    const SectionId other = neighbours_[i].section;
    const std::size_t first = i;
    mine.clear();
    for (; i < neighbours_.size() && neighbours_[i].section == other; ++i) {
      if (mine.empty() || mine.back() != neighbours_[i].mine) mine.push_back(neighbours_[i].mine);
    }
    std::size_t at = first;
    const auto line_of = [&](std::uint32_t chunk, std::vector<Sample>& line) {
      for (; at < i && neighbours_[at].mine == chunk; ++at) sample(chunks_[neighbours_[at].theirs], true, line);
    };
    scan(on, other, mine, line_of, rules_.near_m, follow_each_other);
  }
}

/// Fills `near_turn_` with the chunks near a section's end where vehicles turn on the spot; none where none does.
/// False: too many in all.
bool Finder::find_near_turn(SectionId turning) {
  near_turn_.clear();
  const auto next = circuit_.next(turning);
  if (!circuit_.part(turning).pivots ||
      std::all_of(next.begin(), next.end(), [&](SectionId after) { return circuit_.turn_at(turning, after) == 0.0; }))
    return true;
  const Point2 middle = position(circuit_.section(turning).end());
  const double reach_m = rules_.disc_m + norm(rules_.half_length_m, rules_.half_width_m);
  bool few = true;
  visit_cells_around(middle, [&](std::uint32_t index) {
    if (near_left_-- == 0) return few = false;
    const Chunk& chunk = chunks_[index];
    if (distance(chunk.middle, middle) > chunk.radius_m() + reach_m) return true;
    if (scans_left_-- == 0) return few = false;
    near_turn_.push_back(index);
    return true;
  });
  std::sort(near_turn_.begin(), near_turn_.end());
  return few;
}

/// Whoever turns on the spot sweeps a disc: a contact of the section's end with all that comes near.
void Finder::scan_turn(SectionId turning) {
  if (near_turn_.empty()) return;
  const auto next = circuit_.next(turning);
  const bool sharp = std::any_of(next.begin(), next.end(), [&](SectionId after) { return !follows(turning, after); });
  const Section& section = circuit_.section(turning);
  const Place end{turning, section.length_m()};
  const Point2 middle = position(section.end());
  // Who comes from behind follows, who is ahead on the only way is followed; but not round a sharp corner.
  const auto passes = [&](const Place& body, const Place&) {
    return !sharp &&
           (ahead_m(body, end) <= rules_.follow_m || (next.size() == 1 && ahead_m(end, body) <= rules_.follow_m));
  };
  const auto line_of = [&](std::uint32_t, std::vector<Sample>& line) { line.push_back({end.s_m, middle}); };
  std::vector<std::uint32_t> chunks;
  for (std::size_t i = 0; i < near_turn_.size();) {
    const SectionId on = chunks_[near_turn_[i]].section;
    chunks.clear();
    for (; i < near_turn_.size() && chunks_[near_turn_[i]].section == on; ++i) chunks.push_back(near_turn_[i]);
    const std::size_t first = contacts_.size();
    scan(on, turning, chunks, line_of, rules_.disc_m, passes);
    const std::size_t last = contacts_.size();
    for (std::size_t k = first; on != turning && k < last; ++k) {
      const double from_m = std::max(end.s_m - rules_.step_m, 0.0);
      contacts_.push_back({turning, on, from_m, end.s_m, contacts_[k].from_m, contacts_[k].to_m, middle});
    }
  }
}

bool Finder::find(bool scanning) {
  if (!find_followers()) return false;
  for (SectionId id = 0; id < circuit_.size(); ++id) {
    if (!find_neighbours(id) || !find_near_turn(id)) return false;
    if (!scanning) continue;
    scan_section(id);
    scan_turn(id);
  }
  std::stable_sort(contacts_.begin(), contacts_.end(), [](const Contact& a, const Contact& b) {
    if (a.on != b.on) return a.on < b.on;
    return a.other != b.other ? a.other < b.other : a.from_m < b.from_m;
  });
  return true;
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
  // Counted first: scanning what will be given up takes a hundred times as long.
  if (too_many_contacts(circuit, rules)) return std::nullopt;
  Finder finder{circuit, rules};
  if (!finder.find(true)) return std::nullopt;
  return std::move(finder).contacts();
}

bool too_many_contacts(const Circuit& circuit, const ContactRules& rules) {
  return !Finder{circuit, rules}.find(false);
}

}  // namespace cosiva::zone
