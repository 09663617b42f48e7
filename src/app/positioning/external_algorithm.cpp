#include "cosiva/app/positioning/external_algorithm.h"

#include <cmath>
#include <limits>
#include <utility>

#include "cosiva/base/json_value.h"
#include "cosiva/base/json_writer.h"
#include "cosiva/base/math.h"

namespace cosiva::app {
namespace {

using estimation::Estimate;

tl::unexpected<Error> garbage(const std::string& why, const std::string& line) {
  return fail("algorithm.garbage", why + ": '" + line.substr(0, 80) + "'");
}

void write_sensors(JsonWriter& json, const estimation::SensorModel& sensors) {
  json.key("sensors").begin_object();
  json.field("distance_variance_per_m", sensors.distance_variance_per_m);
  json.field("turn_variance_per_m", sensors.turn_variance_per_m);
  json.field("turn_variance_per_rad", sensors.turn_variance_per_rad);
  json.field("turn_drift_sigma_radps", sensors.turn_drift_sigma_radps);
  json.field("fiducial_along_sigma_m", sensors.fiducial_along_sigma_m);
  json.field("fiducial_across_sigma_m", sensors.fiducial_across_sigma_m);
  json.field("line_sigma_m", sensors.line_sigma_m).field("range_sigma_m", sensors.range_sigma_m).end_object();
}

void write_track(JsonWriter& json, const estimation::Track& track) {
  json.key("track").begin_object().field("closed", track.closed()).field("length_m", track.length_m());
  json.key("sections").begin_array();
  for (double s = 0.0; s < track.length_m() - 1e-9;) {
    const zone::Section& section = track.circuit().section(track.position_at(s + 1e-9).section);
    // A shape is given in pieces, each with a curvature that is nearly linear.
    constexpr double piece_rad = 0.02;
    const double pieces = section.shape()
                              ? std::max(1.0, std::ceil(section.curvature_max_per_m() * section.length_m() / piece_rad))
                              : 1.0;
    const double piece_m = section.length_m() / pieces;
    for (double i = 0.0; i < pieces; i += 1.0) {
      const Pose2 start = section.pose_at(i * piece_m);
      const double curvature_per_m = section.curvature_at(i * piece_m);
      const double rate_per_m2 = section.shape()
                                     ? (section.curvature_at((i + 1.0) * piece_m) - curvature_per_m) / piece_m
                                     : section.curvature_rate_per_m2();
      json.begin_object().field("x_m", start.x_m).field("y_m", start.y_m).field("heading_rad", start.heading_rad);
      json.field("length_m", piece_m).field("curvature_per_m", curvature_per_m);
      json.field("curvature_rate_per_m2", rate_per_m2).end_object();
    }
    s += section.length_m();
  }
  json.end_array().end_object();
}

std::string start_line(const estimation::Setting& setting) {
  JsonWriter json;
  json.begin_object().key("start").begin_object();
  json.field("x_m", setting.start.x_m).field("y_m", setting.start.y_m).field("heading_rad", setting.start.heading_rad);
  json.field("sigma_m", setting.start_sigma_m).field("heading_sigma_rad", setting.start_heading_sigma_rad);
  json.field("along_m", setting.start_along_m).field("seed", setting.seed);
  write_sensors(json, setting.sensors);
  if (setting.track) write_track(json, *setting.track);
  json.end_object().end_object();
  return json.take();
}

}  // namespace

Result<Estimate> read_estimate(const std::string& line) {
  const auto json = JsonValue::parse(line);
  if (!json) return garbage("the response is no JSON", line);
  const auto x_m = json->number("x_m");
  const auto y_m = json->number("y_m");
  const auto heading_rad = json->number("heading_rad");
  if (!x_m || !y_m || !heading_rad) return garbage("an estimate has x_m, y_m and heading_rad", line);
  if (!(std::fabs(*x_m) < 1e9) || !(std::fabs(*y_m) < 1e9) || !(std::fabs(*heading_rad) < 1e6))
    return garbage("the response is empty", line);
  Estimate estimate{{*x_m, *y_m, wrap_angle(*heading_rad)}, {}, std::nullopt};
  estimate.covariance.fill(std::numeric_limits<double>::quiet_NaN());
  const JsonValue* covariance = json->find("covariance");
  if (covariance == nullptr || covariance->is_null()) return estimate;
  if (covariance->array() == nullptr || covariance->array()->size() != 9)
    return garbage("a covariance has nine numbers", line);
  for (std::size_t i = 0; i < 9; ++i) {
    const double* value = (*covariance->array())[i].number();
    if (value == nullptr || !std::isfinite(*value)) return garbage("a covariance has nine numbers", line);
    estimate.covariance(static_cast<Eigen::Index>(i / 3), static_cast<Eigen::Index>(i % 3)) = *value;
  }
  return estimate;
}

ExternalAlgorithm::ExternalAlgorithm(std::string name, std::unique_ptr<adapters::LineProcess> process,
                                     std::chrono::milliseconds timeout)
    : name_{std::move(name)}, process_{std::move(process)}, timeout_{timeout} {}

Result<std::unique_ptr<estimation::Algorithm>> ExternalAlgorithm::start(const std::string& name,
                                                                        const std::string& command,
                                                                        const estimation::Setting& setting,
                                                                        std::chrono::milliseconds timeout) {
  auto process = adapters::LineProcess::start(command);
  if (!process) return tl::unexpected(process.error());
  std::unique_ptr<ExternalAlgorithm> algorithm{new ExternalAlgorithm(name, std::move(*process), timeout)};
  algorithm->send_line(start_line(setting));
  return algorithm;
}

void ExternalAlgorithm::blame(const Error& error) const {
  if (!fault_) fault_ = Error{error.code, error.message, name_};
}

void ExternalAlgorithm::send_line(const std::string& line) {
  if (fault_) return;
  if (auto inputs = process_->send_line(line, timeout_); !inputs) blame(inputs.error());
}

void ExternalAlgorithm::predict(const estimation::Odometry& odometry) {
  JsonWriter json;
  json.begin_object().key("odometry").begin_object().field("distance_m", odometry.distance_m);
  json.field("turn_rad", odometry.turn_rad).field("duration_s", odometry.duration_s);
  // Fields that few recordings have are sent only where present, so that all other messages stay unchanged.
  if (odometry.left_m != 0.0) json.field("left_m", odometry.left_m);
  if (odometry.distance_variance_m2 > 0.0) json.field("distance_variance_m2", odometry.distance_variance_m2);
  if (odometry.turn_variance_rad2 > 0.0) json.field("turn_variance_rad2", odometry.turn_variance_rad2);
  json.end_object().end_object();
  send_line(json.text());
}

estimation::Rectified ExternalAlgorithm::rectify(const estimation::Reading& reading) {
  JsonWriter json;
  json.begin_object().key("reading").begin_object().field("fiducial", reading.fiducial);
  json.field("x_m", reading.fiducial_M.x_m).field("y_m", reading.fiducial_M.y_m);
  json.field("ahead_m", reading.detected_B.x_m).field("left_m", reading.detected_B.y_m).end_object().end_object();
  send_line(json.text());
  return {true, std::nullopt, 0};
}

estimation::Rectified ExternalAlgorithm::rectify(const estimation::Range& range) {
  JsonWriter json;
  json.begin_object().key("range").begin_object().field("station", range.station);
  json.field("x_m", range.station_M.x_m).field("y_m", range.station_M.y_m);
  json.field("range_m", range.range_m).end_object().end_object();
  send_line(json.text());
  return {true, std::nullopt, 0};
}

Estimate ExternalAlgorithm::estimate() const {
  if (fault_) return {};
  const auto response = process_->send_request(R"({"estimate":{}})", timeout_);
  if (!response) {
    blame(response.error());
    return {};
  }
  const auto estimate = read_estimate(*response);
  if (!estimate) {
    blame(estimate.error());
    return {};
  }
  return *estimate;
}

}  // namespace cosiva::app
