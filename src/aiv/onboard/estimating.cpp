#include "cosiva/aiv/onboard/estimating.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "cosiva/aiv/estimation/next_position.h"
#include "cosiva/base/archive.h"
#include "cosiva/base/expect.h"

namespace cosiva::aiv {
namespace {

using wire::EstimateResponse;

/// A session without a request for this time is over.
constexpr SimDuration session_max = std::chrono::minutes{1};
/// An estimate may be wrong for a moment, at a crossing; a vehicle that leaves its loop is elsewhere for good.
constexpr double off_loop_m_max = 0.5;
/// The drift of quartz clocks is less than one part in this number.
constexpr std::int64_t drift_divisor = 10'000;
/// A larger change of the offset means that a clock was set, or restarted from zero.
constexpr SimDuration leap = std::chrono::seconds{1};
/// The vehicle's heading is as certain as its path's.
constexpr double start_heading_sigma_rad = 0.02;
/// Largest heading error against a path that passes a fiducial.
constexpr double along_rad_max = pi / 3.0;

std::string shortened(std::string text) {
  if (text.size() > EstimateResponse::fault_bytes_max) text.resize(EstimateResponse::fault_bytes_max);
  return text;
}

wire::EstimateSensors wire_sensors(const estimation::SensorModel& sensors) {
  return {sensors.distance_variance_per_m, sensors.turn_variance_per_m, sensors.turn_variance_per_rad,
          sensors.distance_scale_sigma,    sensors.turn_scale_sigma,    sensors.fiducial_along_sigma_m,
          sensors.fiducial_across_sigma_m, sensors.line_sigma_m,        sensors.line_heading_sigma_rad};
}

/// Position of a fiducial when it enters the antenna's field: at the rim, with the lateral offset at which the path
/// passes it.
Point2 at_rim(const zone::Circuit& circuit, Point2 fiducial_M, const Pose2& X_MB, double range_m) {
  std::vector<zone::Circuit::Located> lines;
  circuit.near(fiducial_M, range_m, lines);
  for (const auto& [track_position, left_m, distance_m] : lines) {
    if (std::fabs(wrap_angle(circuit.pose_at(track_position).heading_rad - X_MB.heading_rad)) > along_rad_max) continue;
    return {std::sqrt(std::fmax(range_m * range_m - left_m * left_m, 0.0)), left_m};
  }
  // On no path that the vehicle may follow: the mean over all points at which a fiducial may enter a disc.
  return {0.25 * pi * range_m, 0.0};
}

/// Nothing where the estimate cannot be transmitted: it has left the range of positions.
std::optional<EstimateResponse::Estimate> wire_sensors(const estimation::Estimate& estimate) {
  const Pose2& X_MB = estimate.pose;
  const auto placed = [](double v) { return std::fabs(v) <= EstimateResponse::position_m_max; };
  if (!placed(X_MB.x_m) || !placed(X_MB.y_m) || !std::isfinite(X_MB.heading_rad)) return std::nullopt;
  EstimateResponse::Estimate inputs;
  inputs.X_MB = {X_MB.x_m + 0.0, X_MB.y_m + 0.0, wrap_angle(X_MB.heading_rad) + 0.0};
  if (estimate.along_m && std::isfinite(*estimate.along_m)) inputs.along_m = *estimate.along_m;
  const auto& c = estimate.covariance;
  if (std::isnan(c(0, 0))) return inputs;
  auto& matrix = inputs.covariance.emplace();
  for (std::size_t i = 0; i < matrix.size(); ++i) {
    matrix[i] = c(static_cast<int>(i) / 3, static_cast<int>(i) % 3) + 0.0;
    if (!(std::fabs(matrix[i]) <= EstimateResponse::variance_max)) return std::nullopt;
  }
  return inputs;
}

EstimateResponse::Rectified wire_sensors(const estimation::Rectified& rectified) {
  EstimateResponse::Rectified inputs{rectified.accepted, std::nullopt, static_cast<std::uint8_t>(rectified.dimensions)};
  if (rectified.nis && *rectified.nis >= 0.0)
    inputs.nis = std::fmin(*rectified.nis, EstimateResponse::variance_max) + 0.0;
  return inputs;
}

}  // namespace

estimation::SensorModel data_sheet() {
  estimation::SensorModel sensors;
  sensors.distance_variance_per_m = 9e-6;
  sensors.distance_scale_sigma = 0.005;
  sensors.fiducial_along_sigma_m = 0.0025;
  sensors.fiducial_across_sigma_m = 0.002;
  sensors.line_sigma_m = 0.001;
  return sensors;
}

SimTime BoardClock::stamp(SimTime now, std::uint32_t board_ms) {
  const SimDuration board = std::chrono::milliseconds{board_ms};
  const SimDuration detected = now.time_since_epoch() - board;
  if (offset_) *offset_ += std::max(now - received_, SimDuration::zero()) / drift_divisor;
  if (!offset_ || detected < *offset_ || detected > *offset_ + leap) offset_ = detected;
  received_ = now;
  const SimTime at{board + *offset_};
  COSIVA_EXPECT(at <= now);
  return at;
}

void Estimating::on_request(SimTime now, wire::EstimateRequest request) {
  requested_at_ = now;
  const bool of_own = session_ && session_->id == request.session;
  if (last_response_ && last_response_->session == request.session && last_response_->sequence == request.sequence) {
    due_ = true;  // the response was lost
  } else if (of_own) {
    // Any other request was delayed for long, and has no meaning any more.
    if (request.sequence == session_->acknowledged + 1) requested_ = std::move(request);
  } else if (request.sequence == 1) {
    requested_ = std::move(request);
  } else {
    refuse(
        request, now,
        "this vehicle's program has no such session: the program was restarted, no request came for long, or another "
        "client began a session");
  }
}

void Estimating::on_odometry(SimTime now, const Step& step) {
  if (session_) roll(step);
  if (session_ && (now - requested_at_ > session_max || session_->inputs.size() > EstimateResponse::inputs_max - 2))
    session_.reset();
  if (!requested_) return;
  const wire::EstimateRequest request = *std::exchange(requested_, std::nullopt);
  if (!session_ || session_->id != request.session) {
    if (request.sequence != 1) return refuse(request, step.at, "the session ended before its response");
    if (!step.current_estimate) return refuse(request, step.at, "the vehicle's position is not known");
    begin(request, step);
    if (!session_) return;
  }
  session_->acknowledged = request.sequence;
  session_->move_m = request.move_m;
  response(step.at);
}

std::optional<Estimating::Running> Estimating::start(const std::string& name, const estimation::Setting& setting) {
  const auto known = registry_.find(name);
  if (!known) return std::nullopt;
  Running running{name, nullptr, {}, {}};
  if ((*known)->backtracks) {
    running.fault = "the algorithm needs a whole run: not for use on board";
    return running;
  }
  auto made = registry_.make(name, setting);
  if (made)
    running.algorithm = std::move(*made);
  else
    running.fault = shortened(to_string(made.error()));
  return running;
}

void Estimating::begin(const wire::EstimateRequest& request, const Step& step) {
  const CurrentEstimate& current_estimate = *step.current_estimate;
  session_.reset();
  Run run;
  run.id = request.session;
  run.map_id = current_estimate.zone->name;
  run.stepped_at = step.at;
  estimation::Setting setting;
  setting.sensors = data_sheet();
  setting.start = {current_estimate.X_MB.x_m + 0.0, current_estimate.X_MB.y_m + 0.0,
                   current_estimate.X_MB.heading_rad + 0.0};
  setting.start_sigma_m = std::fmax(current_estimate.sigma_m, setting.sensors.fiducial_along_sigma_m);
  setting.start_heading_sigma_rad = start_heading_sigma_rad;
  setting.seed = request.seed;
  setting.particles = request.particles;
  setting.horizon = request.horizon;
  if (current_estimate.position) {
    auto track = estimation::Track::round(current_estimate.zone, current_estimate.position->section);
    if (const auto along_m = track ? track->along_of(*current_estimate.position) : std::nullopt) {
      run.track = std::make_shared<const estimation::Track>(std::move(*track));
      setting.track = run.track;
      setting.start_along_m = *along_m;
      run.start.section = current_estimate.zone->circuit.part(current_estimate.position->section).name;
      run.start.along_m = *along_m;
    }
  }
  run.start.X_MB = setting.start;
  run.start.sigma_m = setting.start_sigma_m;
  run.start.heading_sigma_rad = setting.start_heading_sigma_rad;
  run.start.sensors = wire_sensors(setting.sensors);
  for (const std::string& name : request.algorithms) {
    auto running = start(name, setting);
    if (!running) return refuse(request, step.at, to_string(registry_.find(name).error()));
    run.algorithms.push_back(std::move(*running));
  }
  session_ = std::move(run);
}

void Estimating::roll(const Step& step) {
  Run& run = *session_;
  run.speed_mps = step.speed_mps;
  const double duration_s = to_seconds(step.at - run.stepped_at);
  run.stepped_at = step.at;
  if (!step.current_estimate) return;
  const std::optional<zone::TrackPosition>& track_position = step.current_estimate->position;
  const bool on_loop = !run.track || !track_position || run.track->along_of(*track_position);
  run.off_loop_m = on_loop ? 0.0 : run.off_loop_m + std::fabs(step.distance_m);
  if (run.off_loop_m > off_loop_m_max && run.fault.empty())
    run.fault = "the vehicle left the loop on which the session began";
  if (step.distance_m == 0.0 && step.turn_rad == 0.0) return;
  run.travelled_m += std::fabs(step.distance_m);
  // Bit for bit the values in the response.
  const EstimateResponse::Odometry odometry{step.distance_m + 0.0, step.turn_rad + 0.0, std::fmax(duration_s, 0.0)};
  run.inputs.emplace_back(odometry);
  for (Running& one : run.algorithms)
    if (one.algorithm) one.algorithm->predict({odometry.distance_m, odometry.turn_rad, odometry.duration_s});
}

void Estimating::on_tag(std::uint32_t number, SimTime read_at, const zone::TrafficZone& zone, const Pose2& X_MB) {
  // When driving backwards the field comes from the other side; so short a distance needs no reading.
  if (!session_ || session_->speed_mps < 0.0 || session_->inputs.size() >= EstimateResponse::inputs_max) return;
  std::optional<Point2> fiducial_M;
  if (const zone::Tag* tag = zone.find_tag(number)) fiducial_M = position(zone.circuit.pose_at(tag->position));
  if (!fiducial_M && zone.beacons) fiducial_M = zone.beacons->find(number);
  if (!fiducial_M) return;
  Point2 detected_B = at_rim(zone.circuit, *fiducial_M, X_MB, model_.antenna_range_m);
  // The algorithms are at the last odometry, which is not the moment when the fiducial came into the field.
  const double since_s = to_seconds(session_->stepped_at - read_at) + model_.reading_latency_s;
  detected_B.x_m -= session_->speed_mps * since_s;
  publish_reading(
      {number, {fiducial_M->x_m + 0.0, fiducial_M->y_m + 0.0}, {detected_B.x_m + 0.0, detected_B.y_m + 0.0}});
}

void Estimating::publish_reading(const EstimateResponse::Reading& reading) {
  session_->inputs.emplace_back(reading);
  for (Running& one : session_->algorithms) {
    if (!one.algorithm) continue;
    one.rectified.push_back(wire_sensors(
        one.algorithm->rectify(estimation::Reading{reading.fiducial, reading.fiducial_M, reading.detected_B})));
  }
}

void Estimating::response(SimTime at) {
  Run& run = *session_;
  EstimateResponse response;
  response.session = run.id;
  response.sequence = run.acknowledged;
  response.timestamp = at;
  response.map_id = run.map_id;
  response.fault = run.fault;
  response.travelled_m = run.travelled_m;
  if (run.acknowledged == 1) response.start = run.start;
  response.inputs = std::exchange(run.inputs, {});
  for (Running& one : run.algorithms) {
    auto inputs = one.algorithm ? wire_sensors(one.algorithm->estimate()) : std::nullopt;
    if (one.algorithm && !inputs) {
      one.fault = "the algorithm has diverged: its estimate is not a valid position";
      one.algorithm.reset();
    }
    EstimateResponse::Estimate estimate = inputs ? std::move(*inputs) : EstimateResponse::Estimate{};
    estimate.algorithm = one.name;
    estimate.fault = one.fault;
    if (inputs && run.move_m > 0.0)
      estimate.next =
          next_position(one.algorithm->estimate(), run.track.get(), run.start.along_m + run.travelled_m, run.move_m);
    if (inputs) estimate.rectified = std::exchange(one.rectified, {});
    response.estimates.push_back(std::move(estimate));
  }
  const bool over = !run.fault.empty();
  publish(response);
  if (over) session_.reset();
}

void Estimating::refuse(const wire::EstimateRequest& request, SimTime at, std::string why) {
  EstimateResponse response;
  response.session = request.session;
  response.sequence = request.sequence;
  response.timestamp = at;
  response.fault = shortened(std::move(why));
  publish(response);
}

void Estimating::publish(const EstimateResponse& response) {
  last_response_ = Responded{response.session, response.sequence, to_json(response)};
  due_ = true;
}

void Estimating::on_zone_switched() {
  if (session_) session_->fault = "its zone was switched";
}

std::optional<std::string> Estimating::take_response() {
  if (!std::exchange(due_, false)) return std::nullopt;
  COSIVA_EXPECT(last_response_);
  return last_response_->json;
}

void BoardClock::archive(Archive& archive) { archive(offset_, received_); }

void Estimating::archive(Archive& archive) {
  if (!archive.reads() && busy()) archive.fail("estimates are requested on board; their algorithms cannot be stored");
  if (archive.reads()) {
    session_.reset();
    requested_.reset();
  }
  archive(requested_at_, last_response_, due_);
}

}  // namespace cosiva::aiv
