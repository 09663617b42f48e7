#include "cosiva/zone/generate/generate.h"

#include <algorithm>
#include <cmath>
#include <string_view>
#include <utility>
#include <vector>

#include "cosiva/base/expect.h"
#include "cosiva/base/random.h"
#include "cosiva/zone/check/check.h"
#include "cosiva/zone/generate/generated_text.h"
#include "cosiva/zone/generate/plant_size.h"
#include "cosiva/zone/geometry/section.h"

namespace cosiva::zone {
namespace {

constexpr double deg_per_rad = 180.0 / pi;
constexpr std::size_t sections_max = 200'000;

/// At most 0.6 m/s, and slow enough for loads, in whole centimetres per second.
double bend_mps(double curvature_per_m) {
  const double borne_mps = std::sqrt(CheckLimits{}.lateral_mps2 / std::fabs(curvature_per_m));
  return std::min(0.6, std::floor(borne_mps * 100.0) / 100.0);
}

/// One section of the file to be written.
struct Track {
  std::string name;
  Pose2 start;
  Pose2 end;
  double length_m;
  double curvature_start_per_m;
  double curvature_end_per_m;
  double speed_mps_max;  ///< 0: none
  std::vector<std::size_t> next{};
};

struct Spot {
  std::size_t track;
  double s_m;
};
struct Stop {
  std::string name;
  Spot spot;
  bool charger;
};

/// All dimensions are in proportion to the vehicle's.
struct Scale {
  explicit Scale(const VehicleShape& vehicle)
      : unit_m{std::max(vehicle.length_m, 1.2 * vehicle.width_m)},
        bay_offset_m{rounded(vehicle.width_m + generated_clearance_m + 0.4 * unit_m)},
        ease_radius_m{bay_offset_m / (2.0 - std::sqrt(2.0))},
        ease_m{std::sqrt(2.0) * ease_radius_m},
        turn_curvature_per_m{1.0 / (1.2 * unit_m)},
        turn_half_m{0.5 * pi / turn_curvature_per_m} {}

  double unit_m;
  double bay_offset_m;          ///< from the centre of an aisle to that of a bay
  double ease_radius_m;         ///< two arcs of 45° lead into a bay
  double ease_m;                ///< and occupy this much of the aisle
  double turn_curvature_per_m;  ///< a quarter turn is two clothoids, up to this and back
  double turn_half_m;           ///< the length of each
  [[nodiscard]] double bay_m() const { return 3.5 * unit_m; }
  [[nodiscard]] double bay_pitch_m() const { return bay_m() + 0.5 * unit_m + 2.0 * ease_m + 3.0 * unit_m; }
  [[nodiscard]] double lane_gap_m() const { return 3.4 * unit_m; }
};

/// Lays the sections, stations and tags, and writes them. Invariant: every section laid is one that a zone accepts.
class Plant {
 public:
  explicit Plant(const PlantOptions& options)
      : options_{options}, scale_{options.vehicle}, random_{options.seed, "zone/generate"} {}

  std::string text();

 private:
  /// Where a branch leaves or joins a lane: the section that leaves or the last one that joins.
  struct Junction {
    double x_m;
    bool joins;
    std::size_t track;
  };
  struct Strip {
    std::size_t first;
    std::size_t last;
  };
  struct Row {
    std::vector<Junction> top;
    std::vector<Junction> bottom;
    // first and last section of the branch that joins the lanes at either end
    std::size_t east_in, east_out, west_in, west_out;
    std::vector<std::size_t> top_tracks, bottom_tracks, west_tracks, east_tracks;
  };

  std::size_t add(std::string name, const Pose2& start, double length_m, double from_per_m, double to_per_m,
                  double speed_mps);
  std::size_t straight(std::string name, const Pose2& start, double length_m);
  std::size_t arc(std::string name, const Pose2& start, double radius_m, double angle_rad);
  Strip quarter_right(const std::string& name, const Pose2& start);
  void join(std::size_t from, std::size_t to) { tracks_[from].next.push_back(to); }
  [[nodiscard]] Pose2 along(const Pose2& start, double distance_m) const { return start * Pose2{distance_m, 0.0, 0.0}; }

  Strip strip(const std::string& name, const Pose2& start, double length_m, std::uint32_t bays, double ratio,
              bool chargers);
  Strip bay(const std::string& name, const Pose2& start, double straight_m, bool left, bool charger);
  void aisle(Row& row, std::uint32_t number, double x_m, double bottom_m, bool north);
  void ends(Row& row, std::size_t number, double bottom_m);
  void lane(std::vector<Junction> junctions, const std::string& name, const Pose2& start, double length_m,
            std::vector<std::size_t>& tracks);
  void row(std::size_t number);
  void lay_tags();

  void write_head(std::string& out) const;
  void write_tracks(std::string& out) const;
  void write_spots(std::string& out) const;
  void write_loops(std::string& out) const;
  void write_position(std::string& out, const Spot& spot) const;

  const PlantOptions& options_;
  Scale scale_;
  Random random_;
  double turn_m_{};   ///< the part of either lane that a quarter turn occupies
  double aisle_m_{};  ///< from lane to lane
  double west_m_{};   ///< where the sections at the ends of the rows lie
  double east_m_{};
  double cross_west_m_{};  ///< where neighbouring rows lead to each other
  double cross_east_m_{};
  std::vector<Track> tracks_;
  std::vector<Stop> stops_;
  std::vector<Spot> tags_;
  std::vector<Row> rows_;
};

std::size_t Plant::add(std::string name, const Pose2& start, double length_m, double from_per_m, double to_per_m,
                       double speed_mps) {
  const auto section = Section::make(start, length_m, from_per_m, (to_per_m - from_per_m) / length_m);
  COSIVA_EXPECT(section.has_value());
  tracks_.push_back({std::move(name), start, section->end(), length_m, from_per_m, to_per_m, speed_mps});
  return tracks_.size() - 1;
}

std::size_t Plant::straight(std::string name, const Pose2& start, double length_m) {
  return add(std::move(name), start, length_m, 0.0, 0.0, 0.0);
}

std::size_t Plant::arc(std::string name, const Pose2& start, double radius_m, double angle_rad) {
  const double bend_per_m = (angle_rad < 0.0 ? -1.0 : 1.0) / radius_m;
  return add(std::move(name), start, radius_m * std::fabs(angle_rad), bend_per_m, bend_per_m, bend_mps(bend_per_m));
}

Plant::Strip Plant::quarter_right(const std::string& name, const Pose2& start) {
  const double bend_per_m = -scale_.turn_curvature_per_m;
  const std::size_t in = add(name + "i", start, scale_.turn_half_m, 0.0, bend_per_m, bend_mps(bend_per_m));
  const std::size_t out = add(name + "o", tracks_[in].end, scale_.turn_half_m, bend_per_m, 0.0, bend_mps(bend_per_m));
  join(in, out);
  return {in, out};
}

/// A lay-by: two arcs aside, a straight with the station in its centre, two arcs back.
Plant::Strip Plant::bay(const std::string& name, const Pose2& start, double straight_m, bool left, bool charger) {
  const double turn_rad = left ? 0.25 * pi : -0.25 * pi;
  const double radius_m = scale_.ease_radius_m;
  const std::size_t first = arc(name + "p", start, radius_m, turn_rad);
  const std::size_t in = arc(name + "q", tracks_[first].end, radius_m, -turn_rad);
  const std::size_t stop = straight(name + "s", tracks_[in].end, straight_m);
  const std::size_t out = arc(name + "t", tracks_[stop].end, radius_m, -turn_rad);
  const std::size_t last = arc(name + "u", tracks_[out].end, radius_m, turn_rad);
  tracks_[stop].speed_mps_max = 0.4;
  join(first, in);
  join(in, stop);
  join(stop, out);
  join(out, last);
  const double centre_m = rounded(0.5 * straight_m);
  stops_.push_back({name, {stop, centre_m}, charger});
  return {first, last};
}

/// A straight aisle of `length_m` with bays on its side: "a1b2" passes bay 2 of strip a1, "a1c2" leads up to it.
Plant::Strip Plant::strip(const std::string& name, const Pose2& start, double length_m, std::uint32_t bays,
                          double ratio, bool chargers) {
  Strip all{tracks_.size(), tracks_.size()};
  double done_m = 0.0;
  std::vector<std::size_t> joining;
  const auto lead_up = [&](std::uint32_t number, double to_m) {
    all.last = straight(name + "c" + std::to_string(number), along(start, done_m), to_m - done_m);
    for (const std::size_t track : joining) join(track, all.last);
    joining.clear();
    done_m = to_m;
  };
  for (std::uint32_t i = 0; i < bays; ++i) {
    const double at_m = rounded(2.0 * scale_.unit_m + i * scale_.bay_pitch_m());
    const bool there = random_.uniform() < ratio;
    const bool left = random_.chance(0.5);
    const double straight_m = rounded(scale_.bay_m() + random_.uniform(0.0, 0.5) * scale_.unit_m);
    if (!there) continue;
    lead_up(i + 1, at_m);
    const std::string bay_name = name + "b" + std::to_string(i + 1);
    const double pass_m = straight_m + 2.0 * scale_.ease_m;
    const std::size_t pass = straight(bay_name, along(start, at_m), pass_m);
    const Strip aside = bay(bay_name, along(start, at_m), straight_m, left, chargers);
    join(all.last, pass);
    join(all.last, aside.first);
    joining = {pass, aside.last};
    done_m = at_m + pass_m;
  }
  lead_up(bays + 1, length_m);
  return all;
}

void Plant::aisle(Row& row, std::uint32_t number, double x_m, double bottom_m, bool north) {
  const double top_m = bottom_m + aisle_m_;
  const std::string name = "a" + std::to_string(number);
  const Pose2 leaves = north ? Pose2{x_m + turn_m_, bottom_m, pi} : Pose2{x_m - turn_m_, top_m, 0.0};
  const Pose2 begins = north ? Pose2{x_m, bottom_m + turn_m_, 0.5 * pi} : Pose2{x_m, top_m - turn_m_, -0.5 * pi};
  const Strip in = quarter_right(name + "x", leaves);
  const double length_m = aisle_m_ - 2.0 * turn_m_;
  const Strip inside = strip(name, begins, length_m, options_.bays, options_.bay_ratio, false);
  const Strip out = quarter_right(name + "y", along(begins, length_m));
  join(in.last, inside.first);
  join(inside.last, out.first);
  auto& from = north ? row.bottom : row.top;
  auto& to = north ? row.top : row.bottom;
  from.push_back({leaves.x_m, false, in.first});
  to.push_back({north ? x_m + turn_m_ : x_m - turn_m_, true, out.last});
}

/// The sections from lane to lane at both ends of a row, the eastern one with chargers.
void Plant::ends(Row& row, std::size_t number, double bottom_m) {
  const double top_m = bottom_m + aisle_m_;
  const double length_m = aisle_m_ - 2.0 * turn_m_;
  const auto lay = [&](const std::string& name, const Pose2& leaves, const Pose2& begins, std::uint32_t chargers,
                       std::vector<std::size_t>& round) {
    const Strip in = quarter_right(name + "x", leaves);
    const Strip inside = strip(name, begins, length_m, chargers, 1.0, true);
    const Strip out = quarter_right(name + "y", along(begins, length_m));
    join(in.last, inside.first);
    join(inside.last, out.first);
    // The loop round the row bypasses the chargers.
    for (std::size_t track = in.first; track != out.last; track = tracks_[track].next.front()) round.push_back(track);
    round.push_back(out.last);
    return Strip{in.first, out.last};
  };
  const std::string suffix = std::to_string(number);
  const Strip east = lay("e" + suffix, {east_m_ - turn_m_, top_m, 0.0}, {east_m_, top_m - turn_m_, -0.5 * pi},
                         std::min(options_.bays, 2U), row.east_tracks);
  const Strip west =
      lay("w" + suffix, {west_m_ + turn_m_, bottom_m, pi}, {west_m_, bottom_m + turn_m_, 0.5 * pi}, 0, row.west_tracks);
  row.east_in = east.first;
  row.east_out = east.last;
  row.west_in = west.first;
  row.west_out = west.last;
}

/// A lane, cut at every branch that leaves or joins it.
void Plant::lane(std::vector<Junction> junctions, const std::string& name, const Pose2& start, double length_m,
                 std::vector<std::size_t>& tracks) {
  const bool east = start.heading_rad == 0.0;
  std::sort(junctions.begin(), junctions.end(),
            [east](const Junction& a, const Junction& b) { return east ? a.x_m < b.x_m : a.x_m > b.x_m; });
  double done_m = 0.0;
  const auto go_on = [&](double to_m) {
    const std::size_t track = straight(name + std::to_string(tracks.size() + 1), along(start, done_m), to_m - done_m);
    if (!tracks.empty()) tracks_[tracks.back()].next.insert(tracks_[tracks.back()].next.begin(), track);
    tracks.push_back(track);
    done_m = to_m;
  };
  constexpr std::size_t none = ~std::size_t{0};
  std::size_t joining = none;
  for (const Junction& junction : junctions) {
    go_on(std::fabs(junction.x_m - start.x_m));
    if (joining != none) join(joining, tracks.back());
    joining = none;
    if (junction.joins)
      joining = junction.track;
    else
      join(tracks.back(), junction.track);
  }
  go_on(length_m);
  if (joining != none) join(joining, tracks.back());
}

/// At equal distances along every section, so that no vehicle drives further than `unread_max_m` without a tag: half a
/// pitch lies before a section's first tag and behind its last, and a section too short for one lies between two that
/// are not.
void Plant::lay_tags() {
  const double pitch_m = std::min(0.8 * CheckLimits{}.unread_max_m, 4.0 * scale_.unit_m);
  const double too_short_m = 0.25 * pitch_m;
  for (std::size_t track = 0; track < tracks_.size(); ++track) {
    const double length_m = tracks_[track].length_m;
    if (length_m < too_short_m) continue;
    const double number = std::ceil(length_m / pitch_m);
    for (double i = 0.5; i < number; ++i) tags_.push_back({track, rounded(i * length_m / number)});
  }
}

/// Rows are laid from south to north; each is joined to the one before it.
void Plant::row(std::size_t number) {
  const double bottom_m = rounded(static_cast<double>(number) * (aisle_m_ + scale_.lane_gap_m()));
  rows_.emplace_back();
  Row& here = rows_.back();
  for (std::uint32_t i = 0; i < options_.aisles; ++i) {
    const double x_m = rounded((i + 1.0) * 9.0 * scale_.unit_m);
    aisle(here, static_cast<std::uint32_t>(number) * options_.aisles + i + 1, x_m, bottom_m, i % 2 == 0);
  }
  ends(here, number + 1, bottom_m);
  if (number == 0) return;
  Row& south = rows_[number - 1];
  const double radius_m = 0.5 * scale_.lane_gap_m();
  const double south_top_m = bottom_m - scale_.lane_gap_m();
  const std::string suffix = std::to_string(number);
  const std::size_t up = arc("n" + suffix, {cross_east_m_, south_top_m, 0.0}, radius_m, pi);
  const std::size_t down = arc("s" + suffix, {cross_west_m_, bottom_m, pi}, radius_m, pi);
  south.top.push_back({cross_east_m_, false, up});
  here.bottom.push_back({cross_east_m_, true, up});
  here.bottom.push_back({cross_west_m_, false, down});
  south.top.push_back({cross_west_m_, true, down});
}

std::string Plant::text() {
  const double unit_m = scale_.unit_m;
  const Strip turn = quarter_right("", {});
  turn_m_ = tracks_[turn.last].end.x_m;
  tracks_.clear();
  aisle_m_ = rounded(2.0 * turn_m_ + 4.0 * unit_m + std::max(options_.bays, 1U) * scale_.bay_pitch_m());
  cross_west_m_ = 9.0 * unit_m - turn_m_ - 5.0 * unit_m;
  west_m_ = cross_west_m_ - turn_m_ - 5.0 * unit_m;
  cross_east_m_ = options_.aisles * 9.0 * unit_m + turn_m_ + 5.0 * unit_m;
  east_m_ = cross_east_m_ + turn_m_ + 5.0 * unit_m;

  for (std::size_t i = 0; i < options_.rows; ++i) row(i);
  const double lane_m = east_m_ - west_m_ - 2.0 * turn_m_;
  for (std::size_t i = 0; i < rows_.size(); ++i) {
    Row& here = rows_[i];
    const std::string suffix = std::to_string(i + 1);
    const double bottom_m = rounded(static_cast<double>(i) * (aisle_m_ + scale_.lane_gap_m()));
    lane(here.top, "t" + suffix + "l", {west_m_ + turn_m_, bottom_m + aisle_m_, 0.0}, lane_m, here.top_tracks);
    lane(here.bottom, "b" + suffix + "l", {east_m_ - turn_m_, bottom_m, pi}, lane_m, here.bottom_tracks);
    join(here.top_tracks.back(), here.east_in);
    join(here.east_out, here.bottom_tracks.front());
    join(here.bottom_tracks.back(), here.west_in);
    join(here.west_out, here.top_tracks.front());
  }
  lay_tags();
  std::string out;
  out.reserve(256 * tracks_.size());
  write_head(out);
  write_tracks(out);
  write_spots(out);
  write_loops(out);
  return out;
}

void Plant::write_head(std::string& out) const {
  const auto number = [](auto value) { return std::to_string(value); };
  out.append("# A synthetic plant: ").append(number(options_.rows)).append(" rows of ").append(number(options_.aisles));
  out.append(" aisles with up to ").append(number(options_.bays)).append(" bays each, ");
  out.append(number(tracks_.size())).append(" sections, seed ").append(number(options_.seed)).append(".\n");
  out.append("# Made by `cosiva zone generate`; docs/guide/zones.md explains every field.\n");
  zone::write_head(out, options_.name, options_.vehicle);
  out.append("[waypoints]\nspacing_m = ").append(text_of(2.0 * scale_.unit_m)).append("\n");
}

void Plant::write_tracks(std::string& out) const {
  Pose2 before{};
  for (std::size_t i = 0; i < tracks_.size(); ++i) {
    const Track& track = tracks_[i];
    out.append("\n[[section]]\nname = \"").append(track.name).append("\"\n");
    if (track.curvature_start_per_m != track.curvature_end_per_m) {
      out.append("kind = \"clothoid\"\nlength_m = ").append(text_of(track.length_m));
      out.append("\ncurvature_start_per_m = ").append(text_of(track.curvature_start_per_m));
      out.append("\ncurvature_end_per_m = ").append(text_of(track.curvature_end_per_m)).append("\n");
    } else if (track.curvature_start_per_m != 0.0) {
      out.append("kind = \"arc\"\nradius_m = ").append(text_of(std::fabs(1.0 / track.curvature_start_per_m)));
      out.append("\nangle_deg = ")
          .append(text_of(track.length_m * track.curvature_start_per_m * deg_per_rad))
          .append("\n");
    } else {
      out.append("kind = \"straight\"\nlength_m = ").append(text_of(track.length_m)).append("\n");
    }
    if (track.speed_mps_max > 0.0) out.append("speed_mps_max = ").append(text_of(track.speed_mps_max)).append("\n");
    if (i == 0 || distance(before, track.start) > 1e-9 ||
        std::fabs(wrap_angle(before.heading_rad - track.start.heading_rad)) > 1e-9) {
      out.append("start = { x = ").append(text_of(track.start.x_m)).append(", y = ").append(text_of(track.start.y_m));
      out.append(", heading_deg = ").append(text_of(track.start.heading_rad * deg_per_rad)).append(" }\n");
    }
    before = track.end;
    if (track.next.size() == 1 && track.next.front() == i + 1) continue;
    out.append("next = [");
    for (std::size_t k = 0; k < track.next.size(); ++k)
      out.append(k == 0 ? "\"" : ", \"").append(tracks_[track.next[k]].name).append("\"");
    out.append("]\n");
  }
}

void Plant::write_position(std::string& out, const Spot& spot) const {
  out.append("section = \"")
      .append(tracks_[spot.track].name)
      .append("\"\ns_m = ")
      .append(text_of(spot.s_m))
      .append("\n");
}

void Plant::write_spots(std::string& out) const {
  for (std::size_t i = 0; i < tags_.size(); ++i) {
    out.append("\n[[tag]]\nnumber = ").append(std::to_string(i + 1)).append("\n");
    write_position(out, tags_[i]);
  }
  for (const Stop& stop : stops_) {
    out.append("\n[[station]]\nname = \"").append(stop.charger ? "charger " : "bay ").append(stop.name);
    out.append(stop.charger ? "\"\nkind = \"charger\"\n" : "\"\nkind = \"stop\"\n");
    write_position(out, stop.spot);
  }
  const std::size_t starts = std::min<std::size_t>(options_.starts, stops_.size());
  for (std::size_t i = 0; i < starts; ++i) {
    out.append("\n[[start]]\n");
    write_position(out, stops_[i * stops_.size() / starts].spot);
  }
}

void Plant::write_loops(std::string& out) const {
  for (std::size_t i = 0; i < rows_.size(); ++i) {
    const Row& here = rows_[i];
    out.append("\n[[loop]]\nname = \"row ").append(std::to_string(i + 1)).append("\"\nsections = [");
    bool first = true;
    for (const auto* part : {&here.bottom_tracks, &here.west_tracks, &here.top_tracks, &here.east_tracks}) {
      for (const std::size_t track : *part) {
        out.append(first ? "\"" : ", \"").append(tracks_[track].name).append("\"");
        first = false;
      }
    }
    out.append("]\n");
  }
}

}  // namespace

Result<std::string> generate_plant(const PlantOptions& options) {
  const auto out_of_range = [](std::string_view what) { return fail("generate.options", std::string(what)); };
  if (options.rows < 1 || options.rows > 1000) return out_of_range("expected 1 to 1000 rows of aisles");
  if (options.aisles < 1 || options.aisles > 10'000) return out_of_range("expected 1 to 10000 aisles per row");
  if (options.bays > 10'000) return out_of_range("expected at most 10000 bays per aisle");
  if (!(options.bay_ratio >= 0.0 && options.bay_ratio <= 1.0))
    return out_of_range("expected a ratio of bays from 0 to 1");
  if (plant_sections_max(options) > sections_max) {
    return out_of_range("these rows, aisles and bays may make " + std::to_string(plant_sections_max(options)) +
                        " sections; expected at most " + std::to_string(sections_max));
  }
  if (auto checked = check_vehicle_and_name(options.vehicle, options.name); !checked)
    return tl::unexpected(std::move(checked).error());
  return Plant{options}.text();
}

}  // namespace cosiva::zone
