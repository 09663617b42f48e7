#include "cosiva/physical/vision/tags.h"

#include <algorithm>
#include <cmath>
#include <tuple>

extern "C" {
#include <apriltag/apriltag.h>
#include <apriltag/tag36h11.h>
}

#include "cosiva/base/expect.h"
#include "cosiva/base/math.h"

namespace cosiva::vision {
namespace {

/// Two tags nearer to each other than this ratio of the tag's size are the same one.
bool same(const DetectedTag& a, const DetectedTag& b) {
  const PixelPoint p = a.centre();
  const PixelPoint q = b.centre();
  const double side = norm(a.corners[1].u - a.corners[0].u, a.corners[1].v - a.corners[0].v);
  return a.id == b.id && norm(p.u - q.u, p.v - q.v) < 0.5 * side;
}

/// Twice as wide and high, smoothly: a tag of 12 px has too few pixels along an edge for a line fit, and enough after
/// that.
Image doubled(const Image& image) {
  const auto [width, height] = image.size;
  Image twice = Image::filled({2 * width, 2 * height}, 0);
  // Centres of the new pixels lie a quarter pixel from the old ones': three parts of the nearer, one of the further.
  const auto neighbour = [](std::size_t at, std::size_t count) {
    return at % 2 == 0 ? (at == 0 ? 0 : at / 2 - 1) : std::min(count - 1, at / 2 + 1);
  };
  for (std::size_t row = 0; row < 2 * height; ++row) {
    const std::size_t near_row = row / 2;
    const std::size_t far_row = neighbour(row, height);
    for (std::size_t column = 0; column < 2 * width; ++column) {
      const std::size_t near = column / 2;
      const std::size_t far = neighbour(column, width);
      const unsigned sum = 9U * image.at(near, near_row) + 3U * image.at(far, near_row) + 3U * image.at(near, far_row) +
                           image.at(far, far_row);
      twice.pixels[row * 2 * width + column] = static_cast<std::uint8_t>((sum + 8U) / 16U);
    }
  }
  return twice;
}

void sort_from_above(std::vector<DetectedTag>& tags) {
  std::ranges::sort(tags, [](const DetectedTag& a, const DetectedTag& b) {
    const PixelPoint p = a.centre();
    const PixelPoint q = b.centre();
    return std::tie(p.v, p.u, a.id) < std::tie(q.v, q.u, b.id);
  });
}

}  // namespace

PixelPoint DetectedTag::centre() const {
  const auto& [a, b, c, d] = corners;
  const double ux = c.u - a.u;
  const double uy = c.v - a.v;
  const double vx = d.u - b.u;
  const double vy = d.v - b.v;
  const double determinant = ux * vy - uy * vx;
  if (determinant == 0.0) return {0.25 * (a.u + b.u + c.u + d.u), 0.25 * (a.v + b.v + c.v + d.v)};
  const double along = ((b.u - a.u) * vy - (b.v - a.v) * vx) / determinant;
  return {a.u + along * ux, a.v + along * uy};
}

struct TagFinder::Impl {
  Impl() : family{tag36h11_create()}, detector{apriltag_detector_create()} {
    apriltag_detector_add_family_bits(detector, family, 2);
    detector->nthreads = 1;
    detector->refine_edges = true;
  }
  Impl(const Impl&) = delete;
  Impl& operator=(const Impl&) = delete;
  ~Impl() {
    apriltag_detector_destroy(detector);
    tag36h11_destroy(family);
  }
  apriltag_family_t* family;
  apriltag_detector_t* detector;
};

TagFinder::TagFinder() : in_{std::make_unique<Impl>()} {}
TagFinder::TagFinder(TagFinder&&) noexcept = default;
TagFinder& TagFinder::operator=(TagFinder&&) noexcept = default;
TagFinder::~TagFinder() = default;

std::vector<DetectedTag> TagFinder::find(const Image& image, const Window& window, const How& how) {
  COSIVA_EXPECT(window.column + window.size.width <= image.size.width &&
                window.row + window.size.height <= image.size.height);
  constexpr std::size_t least_px = 16;
  if (window.size.width < least_px || window.size.height < least_px) return {};
  in_->detector->quad_decimate = static_cast<float>(how.decimate);
  in_->detector->quad_sigma = static_cast<float>(how.sigma);
  // The library reads only; its type has no constant image.
  // NOLINTNEXTLINE(cppcoreguidelines-pro-type-const-cast)
  auto* const first = const_cast<std::uint8_t*>(image.pixels.data()) + window.row * image.size.width + window.column;
  image_u8_t part = {static_cast<std::int32_t>(window.size.width), static_cast<std::int32_t>(window.size.height),
                     static_cast<std::int32_t>(image.size.width), first};
  zarray_t* const found = apriltag_detector_detect(in_->detector, &part);
  std::vector<DetectedTag> tags;
  for (int i = 0; i < zarray_size(found); ++i) {
    apriltag_detection_t* one = nullptr;
    zarray_get(found, i, static_cast<void*>(&one));
    if (one->hamming > how.corrected_max || one->decision_margin < how.margin_min) continue;
    DetectedTag tag{one->id, one->hamming, one->decision_margin, {}};
    for (std::size_t k = 0; k < 4; ++k) {
      tag.corners[k] = {one->p[k][0] + static_cast<double>(window.column),
                        one->p[k][1] + static_cast<double>(window.row)};
    }
    tags.push_back(tag);
  }
  apriltag_detections_destroy(found);
  sort_from_above(tags);
  return tags;
}

std::vector<DetectedTag> TagFinder::find(const Image& image, const How& how) {
  return find(image, {0, 0, image.size}, how);
}

std::vector<DetectedTag> TagFinder::find_all(const Image& image) {
  How how;
  how.corrected_max = 2;
  how.margin_min = 0.0;
  std::vector<DetectedTag> tags = find(image, how);
  for (DetectedTag more : find(doubled(image), how)) {
    for (PixelPoint& corner : more.corners) corner = {0.5 * corner.u, 0.5 * corner.v};
    const bool known = std::ranges::any_of(tags, [&](const DetectedTag& tag) { return same(tag, more); });
    if (!known) tags.push_back(more);
  }
  sort_from_above(tags);
  return tags;
}

std::array<bool, 100> tag_cells(int id) {
  COSIVA_EXPECT(id >= 0 && id < tags_in_family);
  apriltag_family_t* const family = tag36h11_create();
  std::array<bool, 100> cells{};
  for (std::size_t i = 0; i < 10; ++i)
    cells[i] = cells[90 + i] = cells[10 * i] = cells[10 * i + 9] = true;  // the white margin round the black border
  for (std::uint32_t bit = 0; bit < family->nbits; ++bit) {
    const bool is_white = (family->codes[id] >> (family->nbits - 1U - bit) & 1U) != 0;
    cells[(family->bit_y[bit] + 1U) * 10U + family->bit_x[bit] + 1U] = is_white;
  }
  tag36h11_destroy(family);
  return cells;
}

}  // namespace cosiva::vision
