#include "cosiva/wire/own/estimate_exchange.h"

#include <cmath>

#include "cosiva/base/json_writer.h"
#include "cosiva/wire/own/own_fields.h"

namespace cosiva::wire {

using own::Fields;
using own::read_message;

namespace {

/// The size of a response with inputs_max inputs.
constexpr std::size_t response_bytes_max = 2U << 20U;
constexpr double distance_m_max = 1e9;
constexpr double variance_max = EstimateResponse::variance_max;
constexpr double seconds_max = 1e6;

/// The fields of one object inside the message.
template <typename Read>
void inside(Fields& in, const JsonValue& json, const std::string& name, const Read& read) {
  Fields fields{json, name + "."};
  read(fields);
  in.take_over(fields.error());
}

void read_pose(Fields& in, Pose2& pose) {
  in.number("x", -own::position_m_max, own::position_m_max, pose.x_m);
  in.number("y", -own::position_m_max, own::position_m_max, pose.y_m);
  in.number("theta", -own::heading_rad_max, own::heading_rad_max, pose.heading_rad);
}

void read_sensors(Fields& in, EstimateSensors& sensors) {
  const auto take = [&in](const char* field, double& out) { in.number(field, 0.0, variance_max, out); };
  take("distance_variance_per_m", sensors.distance_variance_per_m);
  take("turn_variance_per_m", sensors.turn_variance_per_m);
  take("turn_variance_per_rad", sensors.turn_variance_per_rad);
  take("distance_scale_sigma", sensors.distance_scale_sigma);
  take("turn_scale_sigma", sensors.turn_scale_sigma);
  take("fiducial_along_sigma_m", sensors.fiducial_along_sigma_m);
  take("fiducial_across_sigma_m", sensors.fiducial_across_sigma_m);
  take("line_sigma_m", sensors.line_sigma_m);
  take("line_heading_sigma_rad", sensors.line_heading_sigma_rad);
}

void read_start(Fields& in, EstimateResponse::Start& start) {
  read_pose(in, start.X_MB);
  in.number("sigma_m", 0.0, variance_max, start.sigma_m);
  in.number("thetaSigma", 0.0, variance_max, start.heading_sigma_rad);
  if (in.optional("section") != nullptr) in.text("section", start.section.emplace());
  in.number("along_m", -distance_m_max, distance_m_max, start.along_m);
  const JsonValue* sensors = in.optional("sensors");
  if (sensors == nullptr) return in.report_fault("sensors", "this field");
  inside(in, *sensors, "start.sensors", [&](Fields& fields) { read_sensors(fields, start.sensors); });
}

void read_odometry(Fields& in, EstimateResponse::Odometry& odometry) {
  in.number("distance_m", -distance_m_max, distance_m_max, odometry.distance_m);
  in.number("turn_rad", -own::heading_rad_max, own::heading_rad_max, odometry.turn_rad);
  in.number("duration_s", 0.0, seconds_max, odometry.duration_s);
}

void read_reading(Fields& in, EstimateResponse::Reading& reading) {
  in.whole("fiducial", reading.fiducial);
  in.number("x_m", -own::position_m_max, own::position_m_max, reading.fiducial_M.x_m);
  in.number("y_m", -own::position_m_max, own::position_m_max, reading.fiducial_M.y_m);
  in.number("ahead_m", -own::position_m_max, own::position_m_max, reading.detected_B.x_m);
  in.number("left_m", -own::position_m_max, own::position_m_max, reading.detected_B.y_m);
}

void read_input(Fields& in, const std::string& name, std::vector<EstimateResponse::Input>& inputs) {
  if (const JsonValue* odometry = in.optional("odometry")) {
    EstimateResponse::Odometry read;
    inside(in, *odometry, name + ".odometry", [&](Fields& fields) { read_odometry(fields, read); });
    inputs.emplace_back(read);
  } else if (const JsonValue* reading = in.optional("reading")) {
    EstimateResponse::Reading read;
    inside(in, *reading, name + ".reading", [&](Fields& fields) { read_reading(fields, read); });
    inputs.emplace_back(read);
  } else {
    in.report_fault("", "odometry or reading");
  }
}

void read_rectified(Fields& in, EstimateResponse::Rectified& rectified) {
  in.flag("accepted", rectified.accepted);
  in.number("nis", 0.0, variance_max, rectified.nis);
  in.whole("dimensions", rectified.dimensions);
}

void read_covariance(Fields& in, EstimateResponse::Estimate& estimate) {
  if (in.optional("covariance") == nullptr) return;
  std::array<double, 9>& matrix = estimate.covariance.emplace();
  std::size_t count = 0;
  in.list("covariance", matrix.size(), [&](const JsonValue& item, const std::string& name) {
    const double* number = item.number();
    if (number == nullptr || !(std::fabs(*number) <= variance_max)) return in.report_fault(name, "a number");
    matrix[count++] = *number + 0.0;  // no minus zero, as in take_number
  });
  if (count != matrix.size()) in.report_fault("covariance", "nine numbers");
}

void read_estimate(Fields& in, const std::string& name, EstimateResponse::Estimate& estimate) {
  in.text("algorithm", estimate.algorithm);
  in.text("fault", estimate.fault, EstimateResponse::fault_bytes_max);
  if (!estimate.fault.empty()) return;
  read_pose(in, estimate.X_MB);
  read_covariance(in, estimate);
  in.number("along_m", -distance_m_max, distance_m_max, estimate.along_m);
  own::read_part(in, "next", estimate.next, [](Fields& fields, Pose2& pose) { read_pose(fields, pose); });
  in.list("rectified", EstimateResponse::inputs_max, [&](const JsonValue& item, const std::string& which) {
    inside(in, item, name + "." + which,
           [&](Fields& fields) { read_rectified(fields, estimate.rectified.emplace_back()); });
  });
}

void write(JsonWriter& json, const Pose2& pose) {
  json.field("x", pose.x_m).field("y", pose.y_m).field("theta", pose.heading_rad);
}

void write(JsonWriter& json, const EstimateSensors& sensors) {
  json.key("sensors").begin_object();
  json.field("distance_variance_per_m", sensors.distance_variance_per_m);
  json.field("turn_variance_per_m", sensors.turn_variance_per_m);
  json.field("turn_variance_per_rad", sensors.turn_variance_per_rad);
  json.field("distance_scale_sigma", sensors.distance_scale_sigma);
  json.field("turn_scale_sigma", sensors.turn_scale_sigma);
  json.field("fiducial_along_sigma_m", sensors.fiducial_along_sigma_m);
  json.field("fiducial_across_sigma_m", sensors.fiducial_across_sigma_m);
  json.field("line_sigma_m", sensors.line_sigma_m);
  json.field("line_heading_sigma_rad", sensors.line_heading_sigma_rad).end_object();
}

void write(JsonWriter& json, const EstimateResponse::Start& start) {
  json.key("start").begin_object();
  write(json, start.X_MB);
  json.field("sigma_m", start.sigma_m).field("thetaSigma", start.heading_sigma_rad);
  if (start.section) json.field("section", *start.section);
  json.field("along_m", start.along_m);
  write(json, start.sensors);
  json.end_object();
}

void write(JsonWriter& json, const EstimateResponse::Input& input) {
  json.begin_object();
  if (const auto* odometry = std::get_if<EstimateResponse::Odometry>(&input)) {
    json.key("odometry").begin_object().field("distance_m", odometry->distance_m);
    json.field("turn_rad", odometry->turn_rad).field("duration_s", odometry->duration_s).end_object();
  } else {
    const auto& reading = std::get<EstimateResponse::Reading>(input);
    json.key("reading").begin_object().field("fiducial", reading.fiducial);
    json.field("x_m", reading.fiducial_M.x_m).field("y_m", reading.fiducial_M.y_m);
    json.field("ahead_m", reading.detected_B.x_m).field("left_m", reading.detected_B.y_m).end_object();
  }
  json.end_object();
}

void write(JsonWriter& json, const EstimateResponse::Estimate& estimate) {
  json.begin_object().field("algorithm", estimate.algorithm).field("fault", estimate.fault);
  if (estimate.fault.empty()) {
    write(json, estimate.X_MB);
    if (estimate.covariance) {
      json.key("covariance").begin_array();
      for (const double number : *estimate.covariance) json.value(number);
      json.end_array();
    }
    if (estimate.along_m) json.field("along_m", *estimate.along_m);
    if (estimate.next) {
      json.key("next").begin_object();
      write(json, *estimate.next);
      json.end_object();
    }
    json.key("rectified").begin_array();
    for (const EstimateResponse::Rectified& one : estimate.rectified) {
      json.begin_object().field("accepted", one.accepted);
      if (one.nis) json.field("nis", *one.nis);
      json.field("dimensions", one.dimensions).end_object();
    }
    json.end_array();
  }
  json.end_object();
}

}  // namespace

std::string to_json(const EstimateRequest& request) {
  JsonWriter json;
  json.begin_object().field("session", request.session).field("sequence", request.sequence);
  json.key("algorithms").begin_array();
  for (const std::string& name : request.algorithms) json.value(name);
  json.end_array().field("seed", request.seed).field("particles", request.particles);
  json.field("horizon", request.horizon);
  if (request.move_m > 0.0) json.field("move_m", request.move_m);
  return json.end_object().take();
}

Result<EstimateRequest> estimate_request_from_json(std::string_view text) {
  return read_message<EstimateRequest>(text, [](Fields& in, EstimateRequest& request) {
    in.text("session", request.session);
    if (request.session.empty()) in.report_fault("session", "a name");
    in.whole("sequence", request.sequence);
    if (request.sequence == 0) in.report_fault("sequence", "a number from 1 on");
    in.list("algorithms", EstimateRequest::algorithms_max, [&](const JsonValue& item, const std::string& name) {
      if (item.text() == nullptr || item.text()->size() > own::text_bytes_max) return in.report_fault(name, "a name");
      request.algorithms.push_back(*item.text());
    });
    in.whole("seed", request.seed);
    in.whole("particles", request.particles);
    if (request.particles == 0 || request.particles > EstimateRequest::particles_max)
      in.report_fault("particles", "a number from 1 to " + std::to_string(EstimateRequest::particles_max));
    in.whole("horizon", request.horizon);
    if (request.horizon == 0 || request.horizon > EstimateRequest::horizon_max)
      in.report_fault("horizon", "a number from 1 to " + std::to_string(EstimateRequest::horizon_max));
    if (in.has("move_m")) in.number("move_m", 0.0, EstimateRequest::move_m_max, request.move_m);
  });
}

std::string to_json(const EstimateResponse& response) {
  JsonWriter json;
  json.begin_object().field("session", response.session).field("sequence", response.sequence);
  json.field("timestamp", to_iso8601(response.timestamp)).field("mapId", response.map_id);
  json.field("fault", response.fault).field("travelled_m", response.travelled_m);
  if (response.start) write(json, *response.start);
  json.key("inputs").begin_array();
  for (const EstimateResponse::Input& input : response.inputs) write(json, input);
  json.end_array().key("estimates").begin_array();
  for (const EstimateResponse::Estimate& estimate : response.estimates) write(json, estimate);
  return json.end_array().end_object().take();
}

Result<EstimateResponse> estimate_response_from_json(std::string_view text) {
  const auto read = [](Fields& in, EstimateResponse& response) {
    in.text("session", response.session);
    in.whole("sequence", response.sequence);
    in.time("timestamp", response.timestamp);
    in.text("mapId", response.map_id);
    in.text("fault", response.fault, EstimateResponse::fault_bytes_max);
    in.number("travelled_m", -distance_m_max, distance_m_max, response.travelled_m);
    own::read_part(in, "start", response.start, [](Fields& fields, auto& start) { read_start(fields, start); });
    in.list("inputs", EstimateResponse::inputs_max, [&](const JsonValue& item, const std::string& name) {
      inside(in, item, name, [&](Fields& fields) { read_input(fields, name, response.inputs); });
    });
    in.list("estimates", EstimateRequest::algorithms_max, [&](const JsonValue& item, const std::string& name) {
      inside(in, item, name, [&](Fields& fields) { read_estimate(fields, name, response.estimates.emplace_back()); });
    });
  };
  return read_message<EstimateResponse>(text, read, response_bytes_max);
}

}  // namespace cosiva::wire
