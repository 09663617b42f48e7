#include "cosiva/app/gvs/camera_pipeline.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <span>
#include <utility>

#include "cosiva/base/json_writer.h"
#include "cosiva/base/text.h"
#include "cosiva/physical/vision/image.h"
#include "cosiva/wire/messages/topics.h"

namespace cosiva::app {
namespace {

/// The search for unknown tags, one band of the image at a time, covers the whole image in this time [s].
constexpr double search_s = 2.0;
/// A tag closer to the image's border than this may be cut off, and is not reported as missing.
constexpr double border_px = 40.0;
/// Beyond this number vehicles are indistinguishable for an operator, and exceed a broker's longest message.
constexpr std::size_t shown_max = 100;

/// The border of the observed floor, a few points on each side, because a lens bends the border.
std::vector<Point2> field_of(const vision::Calibration& calibration) {
  constexpr int per_side = 6;
  const double width = static_cast<double>(calibration.map.frame.width) - 2.0 * border_px;
  const double height = static_cast<double>(calibration.map.frame.height) - 2.0 * border_px;
  const double height_m = vision::profile_of(-1, calibration.markers).height_m;
  std::vector<Point2> field;
  for (int side = 0; side < 4; ++side) {
    for (int i = 0; i < per_side; ++i) {
      const double along = static_cast<double>(i) / per_side;
      const std::array<std::array<double, 2>, 4> at{
          {{along, 0.0}, {1.0, along}, {1.0 - along, 1.0}, {0.0, 1.0 - along}}};
      const auto [u, v] = at[static_cast<std::size_t>(side)];
      // Where the map ends the border is left out, and the observed area is smaller.
      if (const auto floor = calibration.map.floor_at({border_px + u * width, border_px + v * height}))
        field.push_back(vision::at_height(*floor, height_m, calibration.camera));
    }
  }
  return field;
}

void write_pixel(JsonWriter& json, const vision::PixelPoint& pixel) {
  const auto tenth = [](double value) { return std::nearbyint(10.0 * value) / 10.0; };
  json.begin_array().value(tenth(pixel.u)).value(tenth(pixel.v)).end_array();
}

/// Each pixel is the mean of a square of `by` × `by` pixels.
vision::Image smaller(const vision::Image& image, std::size_t by) {
  const vision::ImageSize size{image.size.width / by, image.size.height / by};
  vision::Image small = vision::Image::filled(size, 0);
  const auto count = static_cast<unsigned>(by * by);
  for (std::size_t row = 0; row < size.height; ++row) {
    for (std::size_t column = 0; column < size.width; ++column) {
      unsigned sum = count / 2;
      for (std::size_t y = 0; y < by; ++y)
        for (std::size_t x = 0; x < by; ++x) sum += image.at(column * by + x, row * by + y);
      small.pixels[row * size.width + column] = static_cast<std::uint8_t>(sum / count);
    }
  }
  return small;
}

}  // namespace

Result<std::map<int, std::string>> read_vehicle_names(const std::vector<std::string>& given) {
  std::map<int, std::string> names;
  for (const std::string& one : given) {
    const std::size_t equals = one.find('=');
    const auto tag = number_of<int>(std::string_view{one}.substr(0, equals));
    const std::string name = equals == std::string::npos ? "" : one.substr(equals + 1);
    const std::size_t slash = name.find('/');
    const bool named = slash != std::string::npos && wire::valid_serial_number(name.substr(0, slash)) &&
                       wire::valid_serial_number(name.substr(slash + 1));
    if (!tag || *tag < 0 || *tag >= vision::tags_in_family || !named)
      return fail(
          "gvs.vehicle",
          "expected TAG=MANUFACTURER/SERIAL such as 7=CoSiVA/AIV1, with a tag from 0 to 586; found '" + one + "'");
    if (!names.emplace(*tag, name).second)
      return fail("gvs.vehicle", "tag " + std::to_string(*tag) + " is assigned to two vehicles");
  }
  return names;
}

vision::TrackerOptions tracker_options(const GvsSource& source) {
  vision::TrackerOptions options;
  options.exposure_s = 1e-3 * source.exposure_ms;
  options.line_s = 1e-6 * source.line_us;
  options.side_m = source.tag_side_m;
  options.bands = static_cast<std::size_t>(std::clamp(std::nearbyint(search_s * source.rate_hz), 1.0, 16.0));
  return options;
}

GvsCamera::GvsCamera(vision::Calibration calibration, const vision::TrackerOptions& options,
                     std::map<int, std::string> names)
    : calibration_{std::move(calibration)},
      tracker_{calibration_, options},
      names_{std::move(names)},
      field_{field_of(calibration_)} {}

std::string GvsCamera::name_of(int tag) const {
  const auto named = names_.find(tag);
  if (named != names_.end()) return named->second;
  std::string usual = std::string(wire::our_manufacturer) + "/AIV" + std::to_string(tag);
  // The usual AIV of this tag has another tag: the carrier of this tag is unknown.
  const bool taken = std::ranges::any_of(names_, [&](const auto& one) { return one.second == usual; });
  return taken ? "tag " + std::to_string(tag) : usual;
}

Result<wire::GvsDetections> GvsCamera::see(const vision::Image& image, SimTime began, double period_s) {
  wire::GvsDetections detections{header_id_, began, period_s, {}, field_};
  if (first_ && began <= last_) return detections;
  if (!first_) first_ = began;
  // Counted from the first image: of a time since 1970 a double would resolve a quarter of a microsecond only.
  const auto fixes = tracker_.see(image, to_seconds(began - *first_));
  if (!fixes) return tl::unexpected(fixes.error());
  last_ = began;
  ++header_id_;
  for (const vision::Fix& fix : *fixes) {
    if (detections.detections.size() >= wire::GvsDetections::detections_max) break;
    detections.detections.push_back({name_of(fix.tag), static_cast<std::uint32_t>(fix.tag),
                                     *first_ + from_seconds(fix.t_s), fix.X_MB, fix.uncertainty_m});
  }
  return detections;
}

std::optional<vision::PixelPoint> GvsCamera::pixel_of(Point2 position, int tag) const {
  const double height_m = vision::profile_of(tag, calibration_.markers).height_m;
  return calibration_.map.pixel_at(vision::detected_from(position, height_m, calibration_.camera));
}

std::string GvsCamera::shown(const vision::Image& image, const wire::GvsDetections& detections,
                             const zone::VehicleShape& body) const {
  const std::size_t longest = std::max(image.size.width, image.size.height);
  const std::size_t by = std::max<std::size_t>(1, (longest + shown_px_max - 1) / shown_px_max);
  const auto ratio = 1.0 / static_cast<double>(by);
  JsonWriter json;
  json.begin_object().field("timestamp", to_iso8601(detections.timestamp)).key("detections").begin_array();
  const double x = 0.5 * body.length_m;
  const double y = 0.5 * body.width_m;
  for (const wire::GvsDetections::Detection& detection :
       std::span{detections.detections}.first(std::min(shown_max, detections.detections.size()))) {
    json.begin_object().field("vehicle", detection.vehicle).field("tag", detection.tag);
    json.field("x", detection.pose.x_m).field("y", detection.pose.y_m).field("heading", detection.pose.heading_rad);
    const auto drawn = [&](Point2 p_B) {
      const auto pixel = pixel_of(detection.pose * p_B, static_cast<int>(detection.tag));
      if (pixel) write_pixel(json, {ratio * pixel->u, ratio * pixel->v});
    };
    json.key("outline").begin_array();
    for (const Point2 corner : {Point2{x, y}, Point2{-x, y}, Point2{-x, -y}, Point2{x, -y}}) drawn(corner);
    json.end_array().key("nose").begin_array();
    for (const Point2 end : {Point2{0.0, 0.0}, Point2{2.0 * x, 0.0}}) drawn(end);
    json.end_array().end_object();
  }
  json.end_array().end_object();
  const vision::Image small = by == 1 ? image : smaller(image, by);
  std::string bytes = vision::write_pgm(small);
  return bytes.insert(3, "# " + json.take() + "\n");  // after "P5\n"
}

}  // namespace cosiva::app
