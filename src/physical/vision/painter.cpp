#include "cosiva/physical/vision/painter.h"

#include <algorithm>
#include <cmath>

#include "cosiva/base/random.h"
#include "cosiva/physical/vision/tags.h"

namespace cosiva::vision {
namespace {

constexpr float floor_light = 150.0F;
constexpr float line_light = 45.0F;
constexpr float roof_light = 100.0F;
constexpr float black = 25.0F;
constexpr float white = 215.0F;
/// No floor there: the lens folds, or the pixel is above the horizon.
constexpr float nowhere = 1e9F;

double smooth(double t) { return t * t * (3.0 - 2.0 * t); }

/// Patches of light and dark, as real floors have: value noise over squares of 0.4 m.
class Patches {
 public:
  explicit Patches(std::uint64_t seed) {
    Random random{seed, "gvs/floor"};
    for (float& value : values_) value = static_cast<float>(random.uniform(-1.0, 1.0));
  }
  [[nodiscard]] float at(double x_m, double y_m) const {
    constexpr double side_m = 0.4;
    const double x = x_m / side_m;
    const double y = y_m / side_m;
    const double i = std::floor(x);
    const double j = std::floor(y);
    const double s = smooth(x - i);
    const double t = smooth(y - j);
    return static_cast<float>((1.0 - t) * ((1.0 - s) * value(i, j) + s * value(i + 1, j)) +
                              t * ((1.0 - s) * value(i, j + 1) + s * value(i + 1, j + 1)));
  }

 private:
  static constexpr std::int64_t size = 32;
  [[nodiscard]] double value(double i, double j) const {
    const auto wrapped = [](double at) {
      return static_cast<std::size_t>(((static_cast<std::int64_t>(at) % size) + size) % size);
    };
    return values_[wrapped(j) * static_cast<std::size_t>(size) + wrapped(i)];
  }
  std::array<float, static_cast<std::size_t>(size* size)> values_{};
};

double distance_to(Point2 p, Point2 a, Point2 b) {
  const double dx = b.x_m - a.x_m;
  const double dy = b.y_m - a.y_m;
  const double square = dx * dx + dy * dy;
  const double along =
      square > 0.0 ? std::clamp(((p.x_m - a.x_m) * dx + (p.y_m - a.y_m) * dy) / square, 0.0, 1.0) : 0.0;
  return norm(p.x_m - a.x_m - along * dx, p.y_m - a.y_m - along * dy);
}

/// A pose with known sine and cosine: each is used for thousands of positions.
struct Frame {
  explicit Frame(const Pose2& pose) : at{position(pose)}, turn{sincos(pose.heading_rad)} {}
  Frame() = default;
  [[nodiscard]] Point2 operator*(Point2 p) const {
    return {at.x_m + turn.cos * p.x_m - turn.sin * p.y_m, at.y_m + turn.sin * p.x_m + turn.cos * p.y_m};
  }
  Point2 at{};
  SinCos turn{0.0, 1.0};
};

}  // namespace

Painter::Painter(const SceneCamera& camera, const std::vector<SceneLine>& lines, std::uint64_t seed)
    : camera_{camera}, seed_{seed} {
  survey_neighbours();
  draw_floor(lines, seed);
  Random random{seed, "gvs/noise"};
  constexpr std::size_t draws = std::size_t{1} << 16U;
  noise_.resize(draws);
  for (float& value : noise_) value = static_cast<float>(camera.noise_grey * random.gaussian());
}

void Painter::survey_neighbours() {
  const auto [width, height] = camera_.frame;
  corner_.resize((width + 1) * (height + 1));
  for (std::size_t row = 0; row <= height; ++row) {
    for (std::size_t column = 0; column <= width; ++column) {
      const auto floor = camera_.floor_of({static_cast<double>(column), static_cast<double>(row)});
      corner_[row * (width + 1) + column] = floor ? Sighted{static_cast<float>(floor->x_m - camera_.foot.x_m),
                                                            static_cast<float>(floor->y_m - camera_.foot.y_m)}
                                                  : Sighted{nowhere, nowhere};
    }
  }
}

Point2 Painter::detected_at(double u, double v) const {
  const auto column = static_cast<std::size_t>(u);
  const auto row = static_cast<std::size_t>(v);
  const double s = u - static_cast<double>(column);
  const double t = v - static_cast<double>(row);
  const std::size_t wide = camera_.frame.width + 1;
  const Sighted& a = corner_[row * wide + column];
  const Sighted& b = corner_[row * wide + column + 1];
  const Sighted& c = corner_[(row + 1) * wide + column];
  const Sighted& d = corner_[(row + 1) * wide + column + 1];
  const auto mixed = [&](double p, double q, double r, double w) {
    return (1.0 - t) * ((1.0 - s) * p + s * q) + t * ((1.0 - s) * r + s * w);
  };
  return {camera_.foot.x_m + mixed(a.x, b.x, c.x, d.x), camera_.foot.y_m + mixed(a.y, b.y, c.y, d.y)};
}

void Painter::draw_floor(const std::vector<SceneLine>& lines, std::uint64_t seed) {
  const auto [width, height] = camera_.frame;
  const Patches patches{seed};
  floor_.assign(width * height, floor_light);
  for (std::size_t i = 0; i < floor_.size(); ++i) {
    const std::size_t row = i / width;
    const Point2 there = detected_at(static_cast<double>(i % width) + 0.5, static_cast<double>(row) + 0.5);
    if (std::fabs(there.x_m) < 1e4) floor_[i] += 8.0F * patches.at(there.x_m, there.y_m);
  }
  for (const SceneLine& line : lines) {
    for (std::size_t k = 1; k < line.points.size(); ++k) {
      const auto a = camera_.pixel_of(line.points[k - 1], 0.0);
      const auto b = camera_.pixel_of(line.points[k], 0.0);
      if (!a || !b) continue;
      const double reach = 2.0 + camera_.focal_px * line.width_m / camera_.height_m;
      const auto clip = [](double at, std::size_t most) {
        return static_cast<std::size_t>(std::clamp(at, 0.0, static_cast<double>(most)));
      };
      const std::size_t low_u = clip(std::min(a->u, b->u) - reach, width);
      const std::size_t high_u = clip(std::max(a->u, b->u) + reach, width);
      const std::size_t low_v = clip(std::min(a->v, b->v) - reach, height);
      const std::size_t high_v = clip(std::max(a->v, b->v) + reach, height);
      for (std::size_t row = low_v; row < high_v; ++row) {
        for (std::size_t column = low_u; column < high_u; ++column) {
          const Point2 there = detected_at(static_cast<double>(column) + 0.5, static_cast<double>(row) + 0.5);
          const double beyond = distance_to(there, line.points[k - 1], line.points[k]) - 0.5 * line.width_m;
          const double pixel_m = camera_.height_m / camera_.focal_px;
          const auto covered = static_cast<float>(std::clamp(0.5 - beyond / pixel_m, 0.0, 1.0));
          float& light = floor_[row * width + column];
          light = std::min(light, light + covered * (line_light - light));
        }
      }
    }
  }
}

void Painter::draw_body(const SceneBody& body, std::vector<float>& light) const {
  const auto [width, height] = camera_.frame;
  const auto cells = tag_cells(body.tag);
  const double cell_m = body.side_m / 8.0;
  const double most_m = std::max({norm(0.5 * body.length_m, 0.5 * body.width_m),
                                  norm(5.0 * cell_m, 5.0 * cell_m) + norm(body.X_BT.x_m, body.X_BT.y_m)});
  const double latest_s = camera_.exposure_s + static_cast<double>(height) * camera_.line_s;
  const auto centre = camera_.pixel_of(position(body.after(0.5 * latest_s)), body.height_m);
  if (!centre) return;
  const double above = camera_.height_m - body.height_m;
  const double reach = 4.0 + 1.6 * camera_.focal_px / above * (most_m + std::fabs(body.speed_mps) * latest_s);
  const auto clip = [](double at, std::size_t most) {
    return static_cast<std::size_t>(std::clamp(at, 0.0, static_cast<double>(most)));
  };
  // Nine samples of each pixel, each at its own ninth of the exposure: sharp edges are smoothed, and moving objects are
  // blurred.
  constexpr std::size_t passes = 9;
  constexpr std::array<std::size_t, passes> moment{4, 0, 7, 2, 5, 8, 1, 6, 3};
  std::array<Frame, passes> X_TM{};
  const Frame X_BT{body.X_BT};
  // at_height, with the factors that all of them have in common.
  const double ratio = body.height_m / camera_.height_m;
  const Point2 nearer{ratio * camera_.foot.x_m, ratio * camera_.foot.y_m};
  for (std::size_t row = clip(centre->v - reach, height); row < clip(centre->v + reach, height); ++row) {
    for (std::size_t pass = 0; pass < passes; ++pass) {
      const double when = (static_cast<double>(moment[pass]) + 0.5) / static_cast<double>(passes);
      const double seconds = static_cast<double>(row) * camera_.line_s + when * camera_.exposure_s;
      X_TM[pass] = Frame{inverse(body.after(seconds) * body.X_BT)};
    }
    for (std::size_t column = clip(centre->u - reach, width); column < clip(centre->u + reach, width); ++column) {
      float sum = 0.0F;
      for (std::size_t pass = 0; pass < passes; ++pass) {
        const double u = static_cast<double>(column) + (static_cast<double>(pass % 3) + 0.5) / 3.0;
        const std::size_t sample_row = pass / 3;
        const double v = static_cast<double>(row) + (static_cast<double>(sample_row) + 0.5) / 3.0;
        const Point2 detected = detected_at(u, v);
        const Point2 there{(1.0 - ratio) * detected.x_m + nearer.x_m, (1.0 - ratio) * detected.y_m + nearer.y_m};
        const Point2 on_tag = X_TM[pass] * there;
        const double x = on_tag.x_m / cell_m + 5.0;
        const double y = 5.0 - on_tag.y_m / cell_m;
        if (x >= 0.0 && x < 10.0 && y >= 0.0 && y < 10.0) {
          sum += cells[static_cast<std::size_t>(y) * 10 + static_cast<std::size_t>(x)] ? white : black;
        } else {
          const Point2 on_body = X_BT * on_tag;
          const bool roof = std::fabs(on_body.x_m) < 0.5 * body.length_m && std::fabs(on_body.y_m) < 0.5 * body.width_m;
          sum += roof ? roof_light : light[row * width + column];
        }
      }
      light[row * width + column] = sum / static_cast<float>(passes);
    }
  }
}

Image Painter::paint(const std::vector<SceneBody>& bodies, std::uint64_t number) const {
  std::vector<float> light = floor_;
  for (const SceneBody& body : bodies) draw_body(body, light);
  const auto [width, height] = camera_.frame;
  Image image = Image::filled(camera_.frame, 0);
  Random random{seed_ + number, "gvs/picture"};
  const double far2 = camera_.principal.u * camera_.principal.u + camera_.principal.v * camera_.principal.v;
  const auto mask = noise_.size() - 1;
  for (std::size_t row = 0; row < height; ++row) {
    // Each row takes the generated noise from a position of its own on, in steps of its own.
    const std::size_t from = random.next() & mask;
    const std::size_t step = (random.next() & mask) | 1U;
    const double y = static_cast<double>(row) + 0.5 - camera_.principal.v;
    for (std::size_t column = 0; column < width; ++column) {
      const double x = static_cast<double>(column) + 0.5 - camera_.principal.u;
      const double bright = camera_.brightness * (1.0 - camera_.vignetting * (x * x + y * y) / far2);
      const float value =
          light[row * width + column] * static_cast<float>(bright) + noise_[(from + column * step) & mask];
      image.pixels[row * width + column] = static_cast<std::uint8_t>(std::clamp(value + 0.5F, 0.0F, 255.0F));
    }
  }
  return image;
}

}  // namespace cosiva::vision
