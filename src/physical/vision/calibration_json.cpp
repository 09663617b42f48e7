#include "cosiva/physical/vision/calibration_json.h"

#include <array>
#include <cmath>
#include <optional>

#include "cosiva/base/json_value.h"
#include "cosiva/base/json_writer.h"
#include "cosiva/physical/vision/floor_fit.h"

namespace cosiva::vision {
namespace {

constexpr std::string_view format = "cosiva.gvs.calibration.v1";

template <class List>
void write_list(JsonWriter& json, std::string_view key, const List& numbers) {
  json.key(key).begin_array();
  for (const auto number : numbers) json.value(number);
  json.end_array();
}

void write(JsonWriter& json, std::string_view key, const Residuals& r) {
  json.key(key).begin_object().field("points", r.points).field("rms_m", r.rms_m).field("max_m", r.max_m).end_object();
}

void write(JsonWriter& json, const MarkerProfile& marker) {
  json.begin_object();
  if (marker.id >= 0) json.field("id", marker.id);
  json.field("height_m", marker.height_m);
  write_list(json, "mount", std::array{marker.X_BT.x_m, marker.X_BT.y_m, marker.X_BT.heading_rad});
  if (marker.surveyed) {
    json.key("surveyed").begin_object();
    write_list(json, "linear", marker.surveyed->linear);
    write_list(json, "shift_m", std::array{marker.surveyed->shift.x_m, marker.surveyed->shift.y_m});
    write_list(json, "lever_m", std::array{marker.surveyed->lever.x_m, marker.surveyed->lever.y_m});
    write_list(json, "lean",
               std::array{marker.surveyed->lean_per_m, marker.surveyed->lean.x_m, marker.surveyed->lean.y_m});
    json.field("turn_rad", marker.surveyed->turn_rad).end_object();
  }
  json.end_object();
}

/// Reads fields, and stores the first invalid one.
class Reader {
 public:
  explicit Reader(const std::string& file) : file_{file} {}

  double number(const JsonValue& from, std::string_view key, double low, double high) {
    const auto found = from.number(key);
    if (!found || !(*found >= low && *found <= high)) {
      record(key, "expected a number from " + phrase(low) + " to " + phrase(high));
      return low;
    }
    return *found;
  }
  std::size_t whole(const JsonValue& from, std::string_view key, std::size_t low, std::size_t high) {
    const double found = number(from, key, static_cast<double>(low), static_cast<double>(high));
    if (found != std::floor(found)) record(key, "expected a whole number");
    return static_cast<std::size_t>(found);
  }
  std::vector<double> list(const JsonValue& from, std::string_view key, std::size_t count) {
    const JsonValue* found = from.find(key);
    std::vector<double> numbers;
    if (found != nullptr && found->array() != nullptr && found->array()->size() == count) {
      for (const JsonValue& one : *found->array())
        if (one.number() != nullptr && std::fabs(*one.number()) <= biggest) numbers.push_back(*one.number());
    }
    if (numbers.size() != count) {
      record(key, "expected a list of " + std::to_string(count) + " numbers");
      numbers.assign(count, 0.0);
    }
    return numbers;
  }
  const JsonValue& object(const JsonValue& from, std::string_view key) {
    static const JsonValue nothing{JsonValue::Object{}};
    const JsonValue* found = from.find(key);
    if (found != nullptr && found->object() != nullptr) return *found;
    record(key, "expected an object");
    return nothing;
  }
  void record(std::string_view key, std::string message) {
    if (!error_) error_ = Error{"gvs.calibration", std::move(message), file_ + ": '" + std::string(key) + "'"};
  }
  [[nodiscard]] const std::optional<Error>& error() const { return error_; }

  static constexpr double biggest = 1e12;

 private:
  static std::string phrase(double number) {
    JsonWriter json;
    return json.value(number).take();
  }
  const std::string& file_;
  std::optional<Error> error_;
};

template <std::size_t count>
void copy(const std::vector<double>& from, std::array<double, count>& to) {
  for (std::size_t i = 0; i < count; ++i) to[i] = from[i];
}

Residuals read_residuals(Reader& reader, const JsonValue& from, std::string_view key) {
  const JsonValue& found = reader.object(from, key);
  return {reader.whole(found, "points", 0, 100'000'000), reader.number(found, "rms_m", 0.0, Reader::biggest),
          reader.number(found, "max_m", 0.0, Reader::biggest)};
}

FloorMap read_map(Reader& reader, const JsonValue& json) {
  FloorMap map;
  const auto size = reader.list(json, "image_px", 2);
  for (const double side : size)
    if (!(side >= 1.0 && side <= 65536.0 && side == std::floor(side)))
      reader.record("image_px", "expected width and height in pixels, 1 to 65536");
  if (!reader.error()) map.frame = {static_cast<std::size_t>(size[0]), static_cast<std::size_t>(size[1])};
  const auto centre = reader.list(json, "centre_px", 2);
  map.centre = {centre[0], centre[1]};
  map.scale_px = reader.number(json, "scale_px", 1.0, 1e6);
  copy(reader.list(json, "lens", 5), map.lens);
  copy(reader.list(json, "homography", 9), map.homography);
  map.degree = reader.whole(json, "degree", 0, degree_max);
  map.polynomial = reader.list(json, "polynomial_m", map.degree == 0 ? 0 : 2 * terms_of(map.degree));
  return map;
}

ResidualMap read_uncertainty(Reader& reader, const JsonValue& json) {
  const JsonValue& from = reader.object(json, "uncertainty");
  ResidualMap map;
  map.x0_m = reader.number(from, "x0_m", -1e6, 1e6);
  map.y0_m = reader.number(from, "y0_m", -1e6, 1e6);
  map.side_m = reader.number(from, "side_m", 1e-6, 1e6);
  map.columns = reader.whole(from, "columns", 0, 1000);
  map.rows = reader.whole(from, "rows", 0, 1000);
  map.rms_m = reader.list(from, "rms_m", map.columns * map.rows);
  for (const double count : reader.list(from, "points", map.columns * map.rows)) {
    if (!(count >= 0.0 && count <= 1e9)) reader.record("points", "expected how many points each square has");
    map.points.push_back(count >= 0.0 && count <= 1e9 ? static_cast<std::size_t>(count) : 0);
  }
  for (const double rms : map.rms_m)
    if (rms < 0.0) reader.record("rms_m", "expected no number below 0");
  return map;
}

MarkerProfile read_marker(Reader& reader, const JsonValue& from) {
  MarkerProfile marker;
  if (from.find("id") != nullptr) marker.id = static_cast<int>(reader.whole(from, "id", 0, 1'000'000));
  marker.height_m = reader.number(from, "height_m", 0.0, 1e3);
  const auto mount = reader.list(from, "mount", 3);
  marker.X_BT = {mount[0], mount[1], mount[2]};
  if (from.find("surveyed") != nullptr) {
    const JsonValue& surveyed = reader.object(from, "surveyed");
    PoseFit fit;
    copy(reader.list(surveyed, "linear", 4), fit.linear);
    const auto shift = reader.list(surveyed, "shift_m", 2);
    const auto lever = reader.list(surveyed, "lever_m", 2);
    fit.shift = {shift[0], shift[1]};
    fit.lever = {lever[0], lever[1]};
    fit.turn_rad = reader.number(surveyed, "turn_rad", -7.0, 7.0);
    if (surveyed.find("lean") != nullptr) {  // older files have none
      const auto lean = reader.list(surveyed, "lean", 3);
      fit.lean_per_m = lean[0];
      fit.lean = {lean[1], lean[2]};
    }
    marker.surveyed = fit;
  }
  return marker;
}

}  // namespace

std::string to_json(const Calibration& c) {
  JsonWriter json{1};
  json.begin_object().field("format", format).field("name", c.name).field("model", name_of(c.model));
  write_list(json, "image_px", std::array{c.map.frame.width, c.map.frame.height});
  write_list(json, "centre_px", std::array{c.map.centre.u, c.map.centre.v});
  json.field("scale_px", c.map.scale_px);
  write_list(json, "lens", c.map.lens);
  write_list(json, "homography", c.map.homography);
  json.field("degree", c.map.degree);
  write_list(json, "polynomial_m", c.map.polynomial);
  write(json, "fitted", c.fitted);
  write(json, "colours", c.colour);
  write(json, "blocks", c.block);
  json.key("uncertainty").begin_object().field("x0_m", c.uncertainty.x0_m).field("y0_m", c.uncertainty.y0_m);
  json.field("side_m", c.uncertainty.side_m).field("columns", c.uncertainty.columns).field("rows", c.uncertainty.rows);
  write_list(json, "rms_m", c.uncertainty.rms_m);
  write_list(json, "points", c.uncertainty.points);
  json.end_object();
  json.key("camera").begin_object();
  write_list(json, "foot_m", std::array{c.camera.foot.x_m, c.camera.foot.y_m});
  json.field("height_m", c.camera.height_m).end_object();
  json.key("markers").begin_array();
  for (const MarkerProfile& marker : c.markers) write(json, marker);
  json.end_array().end_object();
  return json.take() + "\n";
}

Result<Calibration> read_calibration(std::string_view text, const std::string& file) {
  const auto parsed = JsonValue::parse(text);
  if (!parsed) return fail("gvs.calibration", parsed.error().message, file);
  const JsonValue& json = *parsed;
  if (json.object() == nullptr || json.text("format") != format)
    return fail("gvs.calibration", "expected a JSON object with \"format\": \"" + std::string(format) + "\"", file);
  Reader reader{file};
  Calibration made;
  made.name = json.text("name").value_or("");
  const std::string model = json.text("model").value_or("");
  bool known = false;
  for (const FloorModel one : floor_models) {
    if (name_of(one) != model) continue;
    made.model = one;
    known = true;
  }
  if (!known) reader.record("model", "expected homography, lens, polynomial or lens_polynomial");
  made.map = read_map(reader, json);
  made.fitted = read_residuals(reader, json, "fitted");
  made.colour = read_residuals(reader, json, "colours");
  made.block = read_residuals(reader, json, "blocks");
  made.uncertainty = read_uncertainty(reader, json);
  const JsonValue& camera = reader.object(json, "camera");
  const auto foot = reader.list(camera, "foot_m", 2);
  made.camera = {{foot[0], foot[1]}, reader.number(camera, "height_m", 0.0, 1e4)};
  const JsonValue* markers = json.find("markers");
  if (markers == nullptr || markers->array() == nullptr) {
    reader.record("markers", "expected a list");
  } else {
    for (const JsonValue& marker : *markers->array()) made.markers.push_back(read_marker(reader, marker));
  }
  if (reader.error()) return tl::unexpected(*reader.error());
  return made;
}

}  // namespace cosiva::vision
