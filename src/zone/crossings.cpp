// find_crossings: where the bodies of vehicles on different ways could touch.
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <limits>
#include <numeric>
#include <optional>

#include "base/expect.h"
#include "zone/traffic_zone.h"

namespace cosiva::zone {
namespace {

constexpr double step_max_m = 0.005;  // between samples along a way
constexpr double chunk_max_m = 0.25;  // ways are compared chunk by chunk
constexpr double refined_m = 1e-5;    // a span's ends are found to this, outward
// Pairs of chunks to look at, and to scan sample by sample: a few seconds' work.
constexpr std::size_t near_max = 20'000'000;
constexpr std::size_t scan_max = 500'000;
constexpr double infinity = std::numeric_limits<double>::infinity();

/// A short stretch of a section, and beyond an open end what a vehicle standing there sticks out.
struct Chunk {
  SectionId section;
  double from_m;
  double to_m;
  double before_m;  ///< straight on before from_m, 0 but at an open start
  double after_m;
  Point2 middle;

  /// All of it lies within this of its middle.
  [[nodiscard]] double radius_m() const { return 0.5 * (to_m - from_m) + std::max(before_m, after_m); }
};

/// A sample of a centre line.
struct Sample {
  double s_m;
  Point2 p;
};

/// Where on `on` the body of a vehicle comes too near to the centre line of `other`.
struct Contact {
  SectionId on;
  SectionId other;
  double from_m;
  double to_m;
  double other_from_m;  ///< the part of the other centre line that is touched
  double other_to_m;
  Point2 place;  ///< halfway between the two centre lines, where they are nearest
};

/// Groups of indices that only ever grow together.
class Groups {
 public:
  explicit Groups(std::size_t size) : parent_(size) { std::iota(parent_.begin(), parent_.end(), std::size_t{0}); }
  std::size_t find(std::size_t i) {
    while (parent_[i] != i) i = parent_[i] = parent_[parent_[i]];
    return i;
  }
  void join(std::size_t a, std::size_t b) {
    a = find(a);
    b = find(b);
    parent_[std::max(a, b)] = std::min(a, b);  // the lowest index stands for the group, so order never matters
  }

 private:
  std::vector<std::size_t> parent_;
};

class Finder {
 public:
  Finder(const Circuit& circuit, const VehicleShape& shape, double clearance_m)
      : circuit_{circuit},
        half_length_m_{0.5 * shape.length_m},
        half_width_m_{0.5 * shape.width_m},
        near_m_{0.5 * shape.width_m + clearance_m},
        reach_m_{norm(half_length_m_, half_width_m_) + near_m_},
        follow_m_{shape.length_m + shape.width_m + 2.0 * clearance_m} {}

  std::vector<Crossing> find();
  [[nodiscard]] bool too_crowded() {
    cut_chunks();
    return !find_neighbours();
  }

 private:
  void cut_chunks();
  void find_followers();
  [[nodiscard]] bool one_gentle_way(const Chunk& a, const Chunk& b) const;
  [[nodiscard]] bool find_neighbours();
  [[nodiscard]] bool one_way(const Place& a, const Place& b) const;
  [[nodiscard]] double ahead_m(const Place& a, const Place& b) const;
  [[nodiscard]] std::vector<Sample> sample(const Chunk& chunk) const;
  void scan_section(SectionId on);
  void scan_pair(SectionId on, SectionId other, const std::vector<std::pair<std::uint32_t, std::uint32_t>>& pairs);
  /// Grows `contact` by what a body at s touches; false when it touches nothing.
  bool touch(Contact& contact, double& nearest_m, double s_m, const std::vector<Sample>& line) const;
  void group(Groups& groups) const;
  void answer(Crossing& crossing, const Contact& contact) const;
  [[nodiscard]] std::vector<Crossing> gather();

  const Circuit& circuit_;
  double half_length_m_;
  double half_width_m_;
  double near_m_;    ///< a body's edge this near to a centre line may touch a vehicle there
  double reach_m_;   ///< further than this from a body's middle nothing is that near
  double follow_m_;  ///< along one way, vehicles this near follow each other; that is no crossing

  struct Follower {
    SectionId section;
    double gap_m;  ///< from the end of one section to the start of the other
  };
  std::vector<std::vector<Follower>> followers_;
  std::vector<Chunk> chunks_;
  std::vector<std::vector<std::uint32_t>> neighbours_;
  std::vector<std::uint32_t> first_chunk_;  ///< of each section, and one past the last
  std::vector<Contact> contacts_;
};

void Finder::cut_chunks() {
  for (SectionId id = 0; id < circuit_.size(); ++id) {
    first_chunk_.push_back(static_cast<std::uint32_t>(chunks_.size()));
    const Section& section = circuit_.section(id);
    // On a large zone with large vehicles, chunks grow with the vehicle.
    const double chunk_m = std::max(chunk_max_m, half_length_m_);
    const double count = std::max(1.0, std::ceil(section.length_m() / chunk_m));
    for (double i = 0.0; i < count; i += 1.0) {
      Chunk chunk{id, section.length_m() * (i / count), section.length_m() * ((i + 1.0) / count), 0.0, 0.0, {}};
      if (i == 0.0 && circuit_.previous(id).empty()) chunk.before_m = half_length_m_;
      if (i + 1.0 == count && circuit_.next(id).empty()) chunk.after_m = half_length_m_;
      chunk.middle = position(section.pose_at(0.5 * (chunk.from_m + chunk.to_m)));
      chunks_.push_back(chunk);
    }
  }
  first_chunk_.push_back(static_cast<std::uint32_t>(chunks_.size()));
}

/// For each section, those that begin within `follow_m_` of its end, and how far after it.
void Finder::find_followers() {
  followers_.resize(circuit_.size());
  for (SectionId id = 0; id < circuit_.size(); ++id) {
    auto& found = followers_[id];
    for (const SectionId after : circuit_.next(id)) found.push_back({after, 0.0});
    for (std::size_t i = 0; i < found.size(); ++i) {
      const double gap_m = found[i].gap_m + circuit_.section(found[i].section).length_m();
      if (gap_m > follow_m_) continue;
      for (const SectionId after : circuit_.next(found[i].section)) {
        const auto known =
            std::find_if(found.begin(), found.end(), [&](const Follower& f) { return f.section == after; });
        if (known == found.end())
          found.push_back({after, gap_m});
        else
          known->gap_m = std::min(known->gap_m, gap_m);
      }
    }
  }
}

/// Distance to travel from a to b, when it is within `follow_m_`; else infinity.
double Finder::ahead_m(const Place& a, const Place& b) const {
  double best_m = a.section == b.section && b.s_m >= a.s_m ? b.s_m - a.s_m : infinity;
  const double rest_m = circuit_.section(a.section).length_m() - a.s_m;
  for (const Follower& follower : followers_[a.section]) {
    if (follower.section == b.section) best_m = std::min(best_m, rest_m + follower.gap_m + b.s_m);
  }
  return best_m;
}

bool Finder::one_way(const Place& a, const Place& b) const {
  return ahead_m(a, b) <= follow_m_ || ahead_m(b, a) <= follow_m_;
}

/// Whether all of both chunks lies on one way that turns so little that whoever is near follows: then chord ≥
/// arc·cos(turn/2) keeps those apart that are further than `follow_m_` along it, and there is nothing to scan.
bool Finder::one_gentle_way(const Chunk& a, const Chunk& b) const {
  const auto bend = [&](const Chunk& chunk) { return circuit_.section(chunk.section).curvature_max_per_m(); };
  const auto gentle = [&](double turn_rad) { return (1.0 - turn_rad * turn_rad / 8.0) * follow_m_ > reach_m_; };
  if (a.section == b.section) return gentle(bend(a) * (std::max(a.to_m, b.to_m) - std::min(a.from_m, b.from_m)));
  const auto joined = [&](const Chunk& first, const Chunk& second) {
    const auto next = circuit_.next(first.section);
    if (std::find(next.begin(), next.end(), second.section) == next.end()) return false;
    const double rest_m = circuit_.section(first.section).length_m() - first.from_m;
    return gentle(bend(first) * rest_m + bend(second) * second.to_m);
  };
  return joined(a, b) || joined(b, a);
}

/// Fills `neighbours_`: for each chunk the chunks near enough to scan. False, and unfinished, when there are too many.
bool Finder::find_neighbours() {
  double radius_max_m = 0.0;
  for (const Chunk& chunk : chunks_) radius_max_m = std::max(radius_max_m, chunk.radius_m());
  // Cells so large that neighbours are in the same cell or in one of the eight around it.
  const double cell_m = 2.0 * radius_max_m + reach_m_;
  using Cell = std::pair<std::int64_t, std::int64_t>;
  const auto cell_of = [&](Point2 p) {
    return Cell{static_cast<std::int64_t>(std::floor(p.x_m / cell_m)),
                static_cast<std::int64_t>(std::floor(p.y_m / cell_m))};
  };
  std::vector<std::pair<Cell, std::uint32_t>> cells;
  for (std::uint32_t i = 0; i < chunks_.size(); ++i) cells.emplace_back(cell_of(chunks_[i].middle), i);
  std::sort(cells.begin(), cells.end());

  std::size_t near = 0;
  std::size_t to_scan = 0;
  neighbours_.resize(chunks_.size());
  for (std::uint32_t i = 0; i < chunks_.size(); ++i) {
    const Chunk& a = chunks_[i];
    const Cell home = cell_of(a.middle);
    for (std::int64_t column = home.first - 1; column <= home.first + 1; ++column) {
      const Cell low{column, home.second - 1};
      const Cell high{column, home.second + 1};
      auto at = std::lower_bound(cells.begin(), cells.end(), std::pair{low, std::uint32_t{0}});
      for (; at != cells.end() && at->first <= high; ++at) {
        const Chunk& b = chunks_[at->second];
        if (++near > near_max) return false;
        if (distance(a.middle, b.middle) > a.radius_m() + b.radius_m() + reach_m_ || one_gentle_way(a, b)) continue;
        if (++to_scan > scan_max) return false;
        neighbours_[i].push_back(at->second);
      }
    }
    std::sort(neighbours_[i].begin(), neighbours_[i].end());
  }
  return true;
}

std::vector<Sample> Finder::sample(const Chunk& chunk) const {
  const Section& section = circuit_.section(chunk.section);
  const double length_m = chunk.to_m - chunk.from_m;
  const double step_m = std::max(step_max_m, half_width_m_ / 20.0);
  const double count = std::max(1.0, std::ceil(length_m / step_m));
  std::vector<Sample> samples;
  samples.reserve(static_cast<std::size_t>(count) + 1);
  const auto stick_out = [&](double s, double sign, double out_m) {
    const Pose2 X_MP = section.pose_at(s);
    for (double x = step_m; x < out_m + step_m; x += step_m)
      samples.push_back({s, X_MP * Point2{sign * std::min(x, out_m), 0.0}});
  };
  if (chunk.before_m > 0.0) stick_out(chunk.from_m, -1.0, chunk.before_m);
  for (double i = 0.0; i <= count; i += 1.0) {
    const double s = i == count ? chunk.to_m : chunk.from_m + length_m * (i / count);
    samples.push_back({s, position(section.pose_at(s))});
  }
  if (chunk.after_m > 0.0) stick_out(chunk.to_m, 1.0, chunk.after_m);
  return samples;
}

bool Finder::touch(Contact& contact, double& nearest_m, double s_m, const std::vector<Sample>& line) const {
  const Pose2 X_MB = circuit_.section(contact.on).pose_at(s_m);
  const auto [sine, cosine] = sincos(X_MB.heading_rad);
  bool touched = false;
  for (const Sample& sample : line) {
    const double x = sample.p.x_m - X_MB.x_m;
    const double y = sample.p.y_m - X_MB.y_m;
    const double beyond_x = std::max(std::fabs(cosine * x + sine * y) - half_length_m_, 0.0);
    const double beyond_y = std::max(std::fabs(cosine * y - sine * x) - half_width_m_, 0.0);
    if (beyond_x * beyond_x + beyond_y * beyond_y > near_m_ * near_m_) continue;
    if (one_way({contact.on, s_m}, {contact.other, sample.s_m})) continue;
    touched = true;
    contact.other_from_m = std::min(contact.other_from_m, sample.s_m);
    contact.other_to_m = std::max(contact.other_to_m, sample.s_m);
    const double apart_m = norm(x, y);
    if (apart_m < nearest_m) {
      nearest_m = apart_m;
      contact.place = {0.5 * (sample.p.x_m + X_MB.x_m), 0.5 * (sample.p.y_m + X_MB.y_m)};
    }
  }
  return touched;
}

void Finder::scan_section(SectionId on) {
  // (other section, own chunk, other chunk), so that each pair of sections is scanned once, along its own.
  std::vector<std::array<std::uint32_t, 3>> near;
  for (std::uint32_t mine = first_chunk_[on]; mine < first_chunk_[on + 1]; ++mine) {
    for (const std::uint32_t theirs : neighbours_[mine]) near.push_back({chunks_[theirs].section, mine, theirs});
  }
  std::sort(near.begin(), near.end());
  for (std::size_t i = 0; i < near.size();) {
    std::vector<std::pair<std::uint32_t, std::uint32_t>> pairs;
    const SectionId other = near[i][0];
    for (; i < near.size() && near[i][0] == other; ++i) pairs.emplace_back(near[i][1], near[i][2]);
    scan_pair(on, other, pairs);
  }
}

void Finder::scan_pair(SectionId on, SectionId other,
                       const std::vector<std::pair<std::uint32_t, std::uint32_t>>& pairs) {
  const Contact nothing{on, other, 0.0, 0.0, infinity, -infinity, {}};
  std::optional<Contact> open;
  double nearest_m = infinity;
  double before_m = -1.0;  // the last sample that touched nothing, if any
  std::vector<Sample> line_before;

  const auto boundary = [&](double outside_m, double inside_m, const std::vector<Sample>& line) {
    while (std::fabs(outside_m - inside_m) > refined_m) {
      const double middle_m = 0.5 * (outside_m + inside_m);
      Contact scratch = nothing;
      double far_m = infinity;
      (touch(scratch, far_m, middle_m, line) ? inside_m : outside_m) = middle_m;
    }
    return outside_m;
  };
  const auto close = [&](double outside_m, const std::vector<Sample>& line) {
    if (!open) return;
    open->to_m = boundary(outside_m, open->to_m, line);
    contacts_.push_back(*open);
    open.reset();
  };

  double end_m = -1.0;  // of the chunk before, to see whether chunks follow each other without a hole
  for (std::size_t i = 0; i < pairs.size();) {
    const Chunk& chunk = chunks_[pairs[i].first];
    std::vector<Sample> line;
    for (const std::uint32_t mine = pairs[i].first; i < pairs.size() && pairs[i].first == mine; ++i) {
      const auto samples = sample(chunks_[pairs[i].second]);
      line.insert(line.end(), samples.begin(), samples.end());
    }
    if (chunk.from_m != end_m) {
      close(end_m, line_before);
      before_m = -1.0;
    }
    end_m = chunk.to_m;
    for (const Sample& here : sample({chunk.section, chunk.from_m, chunk.to_m, 0.0, 0.0, chunk.middle})) {
      Contact grown = open.value_or(nothing);
      if (!open) nearest_m = infinity;
      if (touch(grown, nearest_m, here.s_m, line)) {
        if (!open) grown.from_m = before_m < 0.0 ? here.s_m : boundary(before_m, here.s_m, line);
        grown.to_m = here.s_m;
        open = grown;
      } else {
        close(here.s_m, line);
        before_m = here.s_m;
      }
    }
    line_before = std::move(line);
  }
  if (open) close(open->to_m, line_before);
}

/// Contacts belong together when each is the other's counterpart, or when they lie at one place.
void Finder::group(Groups& groups) const {
  const auto pair_of = [](const Contact& contact) { return std::pair{contact.on, contact.other}; };
  for (std::size_t i = 0; i < contacts_.size(); ++i) {
    const Contact& a = contacts_[i];
    const std::pair wanted{a.other, a.on};
    auto at = std::lower_bound(contacts_.begin(), contacts_.end(), wanted,
                               [&](const Contact& contact, const auto& pair) { return pair_of(contact) < pair; });
    for (; at != contacts_.end() && pair_of(*at) == wanted; ++at) {
      if (a.other_from_m <= at->to_m && at->from_m <= a.other_to_m && at->other_from_m <= a.to_m &&
          a.from_m <= at->other_to_m)
        groups.join(i, static_cast<std::size_t>(at - contacts_.begin()));
    }
  }

  const double one_place_m = 2.0 * near_m_;
  std::vector<std::size_t> by_x(contacts_.size());
  std::iota(by_x.begin(), by_x.end(), std::size_t{0});
  std::sort(by_x.begin(), by_x.end(), [&](std::size_t a, std::size_t b) {
    const double x = contacts_[a].place.x_m;
    const double y = contacts_[b].place.x_m;
    return x != y ? x < y : a < b;
  });
  for (std::size_t i = 0; i < by_x.size(); ++i) {
    const Point2 p = contacts_[by_x[i]].place;
    for (std::size_t j = i + 1; j < by_x.size() && contacts_[by_x[j]].place.x_m - p.x_m <= one_place_m; ++j) {
      if (distance(p, contacts_[by_x[j]].place) <= one_place_m) groups.join(by_x[i], by_x[j]);
    }
  }
}

/// A way that ends beside another is touched there without its own vehicles ever touching back with their middle's
/// reach: then what is touched, and half a vehicle around it, is the span.
void Finder::answer(Crossing& crossing, const Contact& contact) const {
  const double length_m = circuit_.section(contact.other).length_m();
  const bool answered = std::any_of(crossing.spans.begin(), crossing.spans.end(), [&](const CrossingSpan& span) {
    return span.section == contact.other && span.from_m <= contact.other_to_m && contact.other_from_m <= span.to_m;
  });
  if (answered) return;
  crossing.spans.push_back({contact.other, std::max(contact.other_from_m - half_length_m_, 0.0),
                            std::min(contact.other_to_m + half_length_m_, length_m)});
}

std::vector<Crossing> Finder::gather() {
  Groups groups{contacts_.size()};
  group(groups);

  std::vector<std::vector<std::size_t>> members(contacts_.size());
  for (std::size_t i = 0; i < contacts_.size(); ++i) members[groups.find(i)].push_back(i);

  std::vector<Crossing> crossings;
  for (const auto& together : members) {
    if (together.empty()) continue;
    Crossing crossing;
    for (const std::size_t i : together) {
      const Contact& contact = contacts_[i];
      crossing.spans.push_back({contact.on, contact.from_m, contact.to_m});
      crossing.centre.x_m += contact.place.x_m / static_cast<double>(together.size());
      crossing.centre.y_m += contact.place.y_m / static_cast<double>(together.size());
    }
    for (const std::size_t i : together) answer(crossing, contacts_[i]);
    crossings.push_back(std::move(crossing));
  }
  return crossings;
}

std::vector<Crossing> Finder::find() {
  cut_chunks();
  find_followers();
  COSIVA_EXPECT(find_neighbours());
  for (SectionId id = 0; id < circuit_.size(); ++id) scan_section(id);
  auto crossings = gather();

  for (Crossing& crossing : crossings) {
    auto& spans = crossing.spans;
    std::sort(spans.begin(), spans.end(), [](const CrossingSpan& a, const CrossingSpan& b) {
      return a.section != b.section ? a.section < b.section : a.from_m < b.from_m;
    });
    std::vector<CrossingSpan> united;
    for (const CrossingSpan& span : spans) {
      if (!united.empty() && united.back().section == span.section && span.from_m <= united.back().to_m)
        united.back().to_m = std::max(united.back().to_m, span.to_m);
      else
        united.push_back(span);
    }
    spans = std::move(united);
  }
  // Named in the order in which the sections come to them.
  std::sort(crossings.begin(), crossings.end(), [](const Crossing& a, const Crossing& b) {
    const CrossingSpan& x = a.spans.front();
    const CrossingSpan& y = b.spans.front();
    return x.section != y.section ? x.section < y.section : x.from_m < y.from_m;
  });
  for (std::size_t i = 0; i < crossings.size(); ++i) crossings[i].name = "X" + std::to_string(i + 1);
  return crossings;
}

}  // namespace

std::vector<Crossing> find_crossings(const Circuit& circuit, const VehicleShape& shape, double clearance_m) {
  COSIVA_EXPECT(shape.length_m > 0.0 && shape.width_m > 0.0 && clearance_m >= 0.0);
  return Finder{circuit, shape, clearance_m}.find();
}

bool too_crowded(const Circuit& circuit, const VehicleShape& shape, double clearance_m) {
  return Finder{circuit, shape, clearance_m}.too_crowded();
}

}  // namespace cosiva::zone
