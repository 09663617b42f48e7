#include "cosiva/physical/vision/tracker.h"

#include <algorithm>
#include <cmath>
#include <optional>
#include <set>

#include "cosiva/base/expect.h"

namespace cosiva::vision {
namespace {

constexpr int missed_max = 5;  ///< consecutive images; then the whole image is searched again
/// Standard deviation of a tag's centre by libapriltag with refined edges, 24 to 40 px wide, noise of two grey levels.
constexpr double tag_noise_px = 0.08;

TagFinder::How closely() { return {}; }
TagFinder::How from_afar(double decimate) {
  TagFinder::How how;
  how.decimate = decimate;
  how.sigma = 0.8;  // otherwise noise makes thousands of tiny regions, and the search takes ten times as long
  return how;
}

/// Tags need some 16 px in the smaller image; the library supports these steps. Unknown tags are assumed to be 36 px or
/// more.
double decimate_for(const FloorMap& map, double side_m) {
  const double u = 0.5 * static_cast<double>(map.frame.width);
  const double v = 0.5 * static_cast<double>(map.frame.height);
  const auto here = map.floor_at({u, v});
  const auto neighbour = map.floor_at({u + 1.0, v});
  if (side_m <= 0.0 || !here || !neighbour) return 2.0;
  const double side_px = side_m / std::max(1e-9, distance(*here, *neighbour));
  if (side_px >= 60.0) return 3.0;
  if (side_px >= 34.0) return 2.0;
  return side_px >= 24.0 ? 1.5 : 1.0;
}

double radius_of(const DetectedTag& tag) {
  const PixelPoint centre = tag.centre();
  double radius = 0.0;
  for (const PixelPoint& corner : tag.corners)
    radius = std::max(radius, norm(corner.u - centre.u, corner.v - centre.v));
  return radius;
}

}  // namespace

std::optional<TagOnFloor> tag_on_floor(const DetectedTag& tag, const FloorMap& map) {
  std::array<Point2, 4> corners{};
  Point2 centre;
  for (std::size_t i = 0; i < 4; ++i) {
    const auto corner = map.floor_at(tag.corners[i]);
    if (!corner) return std::nullopt;
    corners[i] = *corner;
    centre.x_m += 0.25 * corner->x_m;
    centre.y_m += 0.25 * corner->y_m;
  }
  // The square nearest to the four corners: its turn is the mean of theirs, its side the mean of their distances along
  // it.
  constexpr std::array<Point2, 4> square{Point2{-1, -1}, Point2{1, -1}, Point2{1, 1}, Point2{-1, 1}};
  double along = 0.0;
  double across = 0.0;
  for (std::size_t i = 0; i < 4; ++i) {
    const double x = corners[i].x_m - centre.x_m;
    const double y = corners[i].y_m - centre.y_m;
    along += square[i].x_m * x + square[i].y_m * y;
    across += square[i].x_m * y - square[i].y_m * x;
  }
  if (along == 0.0 && across == 0.0) return std::nullopt;
  return TagOnFloor{{centre.x_m, centre.y_m, det_atan2(across, along)}, 0.25 * norm(along, across)};
}

Tracker::Tracker(const Calibration& calibration, const TrackerOptions& options)
    : calibration_{calibration}, options_{options} {
  COSIVA_EXPECT(options.bands >= 1 && options.search_decimate >= 0.0);
  if (options_.search_decimate == 0.0) options_.search_decimate = decimate_for(calibration.map, options.side_m);
}

std::vector<int> Tracker::followed() const {
  std::vector<int> ids;
  for (const auto& [id, one] : followed_) ids.push_back(id);
  return ids;
}

Window Tracker::around(const Followed& followed, double stamp_s, double margin) const {
  const double dt_s = stamp_s - followed.detected_s;
  const double u = followed.centre.u + dt_s * followed.per_s.u;
  const double v = followed.centre.v + dt_s * followed.per_s.v;
  // The white margin is a quarter of the side; the rest covers the prediction's uncertainty.
  const double half = 1.25 * followed.radius_px + margin;
  const auto low = [&](double at, std::size_t most) {
    return static_cast<std::size_t>(std::clamp(at - half, 0.0, static_cast<double>(most)));
  };
  const auto high = [&](double at, std::size_t most) {
    return static_cast<std::size_t>(std::clamp(at + half, 0.0, static_cast<double>(most)));
  };
  const ImageSize all = calibration_.map.frame;
  Window window{low(u, all.width), low(v, all.height), {}};
  window.size = {high(u, all.width) - window.column, high(v, all.height) - window.row};
  return window;
}

std::optional<DetectedTag> Tracker::find_again(const Image& image, int id, const Followed& followed, double stamp_s) {
  const double dt_s = stamp_s - followed.detected_s;
  // First at the predicted position. Then in the region that the tag can have reached since.
  const double px_per_m = options_.side_m > 0.0 ? followed.radius_px / (0.7071 * options_.side_m) : 1000.0;
  const double farthest = std::min(px_per_m * options_.speed_mps_max * dt_s, 400.0);
  const double near =
      followed.moving ? 6.0 + 0.1 * dt_s * norm(followed.per_s.u, followed.per_s.v) : 0.25 * farthest + 6.0;
  for (const double margin : {near, farthest + 6.0}) {
    Followed from = followed;
    if (margin != near) from.per_s = {};
    for (const DetectedTag& tag : finder_.find(image, around(from, stamp_s, margin), closely()))
      if (tag.id == id) return tag;
  }
  return std::nullopt;
}

bool Tracker::is_welcome(const DetectedTag& tag) const {
  if (!options_.expected.empty() && std::ranges::find(options_.expected, tag.id) == options_.expected.end())
    return false;
  if (options_.side_m <= 0.0) return true;
  const auto there = tag_on_floor(tag, calibration_.map);
  // A tag above the floor appears larger, by at most a third; a larger deviation is another system's tag.
  return there && there->side_m > 0.85 * options_.side_m && there->side_m < 1.4 * options_.side_m;
}

void Tracker::search(const Image& image, double stamp_s, std::map<int, DetectedTag>& detected) {
  const bool everybody = !options_.expected.empty() &&
                         std::ranges::all_of(options_.expected, [&](int id) { return detected.contains(id); });
  if (everybody) return;
  Window window{0, 0, image.size};
  if (metrics_.images > 0) {
    // Bands overlap by the width of a tag, so that no tag lies between two.
    const std::size_t step = (image.size.height + options_.bands - 1) / options_.bands;
    constexpr std::size_t overlap = 80;
    window.row = std::min(band_ * step, image.size.height);
    window.size.height = std::min(image.size.height - window.row, step + overlap);
    band_ = (band_ + 1) % options_.bands;
  }
  std::set<int> found;
  for (const DetectedTag& far : finder_.find(image, window, from_afar(options_.search_decimate))) {
    if (detected.contains(far.id) && !found.contains(far.id)) continue;  // followed already
    if (!is_welcome(far) || found.contains(far.id)) {
      ++metrics_.strange;
      continue;
    }
    // Corners of the smaller image are coarser: a second detection at full resolution.
    Followed there{far.centre(), {}, radius_of(far), stamp_s, false, 0};
    for (const DetectedTag& near : finder_.find(image, around(there, stamp_s, 8.0), closely())) {
      if (near.id != far.id) continue;
      detected[near.id] = near;
      found.insert(near.id);
    }
  }
}

std::optional<Fix> Tracker::fix_of(const DetectedTag& tag, double stamp_s) const {
  const auto there = tag_on_floor(tag, calibration_.map);
  if (!there) return std::nullopt;
  Fix fix;
  fix.tag = tag.id;
  fix.centre = tag.centre();
  fix.t_s = stamp_s + 0.5 * options_.exposure_s + fix.centre.v * options_.line_s;
  fix.X_MB = vehicle_at(there->pose, profile_of(tag.id, calibration_.markers), calibration_.camera);
  const double px_m =
      options_.side_m > 0.0 ? 0.7071 * options_.side_m / radius_of(tag) : 0.7071 * there->side_m / radius_of(tag);
  const double map_m = calibration_.uncertainty.at(position(there->pose));
  fix.uncertainty_m = norm(map_m, tag_noise_px * px_m);
  return fix;
}

Result<std::vector<Fix>> Tracker::see(const Image& image, double stamp_s) {
  if (image.size != calibration_.map.frame) {
    const auto phrase = [](ImageSize size) { return std::to_string(size.width) + " x " + std::to_string(size.height); };
    return fail("gvs.image", "is " + phrase(image.size) + " pixels large, and the calibration is for " +
                                 phrase(calibration_.map.frame));
  }
  COSIVA_EXPECT(metrics_.images == 0 || stamp_s > stamp_s_);
  std::map<int, DetectedTag> detected;
  for (auto& [id, followed] : followed_) {
    if (const auto tag = find_again(image, id, followed, stamp_s)) {
      detected.emplace(id, *tag);
    } else {
      ++followed.missed;
      ++metrics_.lost;
    }
  }
  std::erase_if(followed_, [](const auto& one) { return one.second.missed > missed_max; });
  search(image, stamp_s, detected);
  ++metrics_.images;
  stamp_s_ = stamp_s;

  std::vector<Fix> fixes;
  for (const auto& [id, tag] : detected) {
    const PixelPoint centre = tag.centre();
    Followed now{centre, {}, radius_of(tag), stamp_s, false, 0};
    if (const auto before = followed_.find(id); before != followed_.end()) {
      const double dt_s = stamp_s - before->second.detected_s;
      now.per_s = {(centre.u - before->second.centre.u) / dt_s, (centre.v - before->second.centre.v) / dt_s};
      now.moving = true;
    }
    followed_[id] = now;
    if (const auto fix = fix_of(tag, stamp_s)) fixes.push_back(*fix);
  }
  metrics_.fixes += fixes.size();
  return fixes;
}

}  // namespace cosiva::vision
