#include "cosiva/virtual/server/view/ground_truth_comparator.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "cosiva/base/archive.h"
#include "cosiva/base/expect.h"
#include "cosiva/base/math.h"
#include "cosiva/virtual/server/registry/reordering.h"
#include "cosiva/virtual/server/view/decimetres.h"

namespace cosiva::virtual_side {
namespace {

/// To a tenth of a millimetre: further digits are noise.
double rounded(double value) { return std::nearbyint(value * 1e4) * 1e-4; }

void number_or_null(JsonWriter& json, std::string_view name, const std::optional<double>& number) {
  json.key(name);
  if (number)
    json.value(rounded(*number));
  else
    json.null();
}

/// By the number of times that a ray to the right crosses the border.
bool inside(const std::vector<Point2>& polygon, Point2 p) {
  bool odd = false;
  for (std::size_t i = 0, j = polygon.size() - 1; i < polygon.size(); j = i++) {
    const Point2& a = polygon[i];
    const Point2& b = polygon[j];
    if ((a.y_m > p.y_m) != (b.y_m > p.y_m) && p.x_m < a.x_m + (b.x_m - a.x_m) * (p.y_m - a.y_m) / (b.y_m - a.y_m))
      odd = !odd;
  }
  return odd;
}

std::string position_text(const Pose2& pose) { return "(" + decimetres(pose.x_m) + ", " + decimetres(pose.y_m) + ")"; }

}  // namespace

std::vector<std::string> GroundTruthComparator::subscriptions() {
  return {std::string(wire::gvs_detections_topic), std::string(wire::gvs_connection_topic),
          std::string(wire::reference_poses_topic)};
}

Result<std::string> GroundTruthComparator::on_message(SimTime now, const wire::Input& input) {
  now_ = now;
  if (input.source == wire::reference_poses_topic) return take_reference(input);
  if (input.source == wire::gvs_connection_topic) {
    if (input.payload.empty()) {  // the retained message was deleted from the broker
      connection_.reset();
      return std::string{};
    }
    auto connection = wire::gvs_connection_from_json(input.payload);
    if (!connection) return tl::unexpected(connection.error());
    connection_ = std::move(*connection);
    connection_at_ = now;
    return std::string(state()) + (connection_->trouble.empty() ? "" : ": " + connection_->trouble);
  }
  // A retained message would be out of date; the image itself is for the page only.
  if (input.source != wire::gvs_detections_topic || input.flag || input.payload.empty()) return std::string{};
  auto detections = wire::gvs_detections_from_json(input.payload);
  if (!detections) return tl::unexpected(detections.error());
  if (detections_ && detections->timestamp <= detections_->timestamp &&
      detections_->timestamp - detections->timestamp < reorder_max)
    return std::string{};
  const bool news = !detections_ || detections_->detections.size() != detections->detections.size();
  take(now, std::move(*detections));
  return news ? std::to_string(detections_->detections.size()) + " in the image" : std::string{};
}

void GroundTruthComparator::take(SimTime now, wire::GvsDetections detections) {
  if (!detections_ || state() != "watching") watching_since_ = now;
  const SimTime before = detections_at_;
  detections_ = std::move(detections);
  detections_at_ = now;
  for (const wire::GvsDetections::Detection& detection : detections_->detections) {
    auto found = detected_.find(detection.vehicle);
    if (found == detected_.end()) {
      if (detected_.size() >= detected_max) continue;
      found = detected_.emplace(detection.vehicle, Sighted{}).first;
      found->second.since = now;
    } else if (found->second.arrived < before - timeout) {
      found->second.since = now;
    }
    Sighted& detected = found->second;
    detected.tag = detection.tag;
    detected.at = detection.at;
    detected.arrived = now;
    detected.X_MB = detection.pose;
    detected.uncertainty_m = detection.uncertainty_m;
    COSIVA_EXPECT(detected.since <= detected.arrived);
    compare(detection, detected);
  }
  COSIVA_EXPECT(detected_.size() <= detected_max);
}

std::optional<VehicleIndex> GroundTruthComparator::twin_of(const std::string& name) const {
  const auto vehicle = registry_.find(name);
  if (!vehicle || !registry_[*vehicle].here() || registry_[*vehicle].augmented()) return std::nullopt;
  return vehicle;
}

bool GroundTruthComparator::reports(const std::string& name) const {
  const auto vehicle = registry_.find(name);
  return vehicle && !registry_[*vehicle].retired() && registry_[*vehicle].twin_link.present();
}

void GroundTruthComparator::compare(const wire::GvsDetections::Detection& detection, Sighted& detected) {
  const auto gap = measure(detection, "camera");
  detected.gap_m = gap ? std::optional{gap->m} : std::nullopt;
  detected.gap_rad = gap ? std::optional{gap->rad} : std::nullopt;
}

std::optional<GroundTruthComparator::Gap> GroundTruthComparator::measure(
    const wire::GvsDetections::Detection& detection, std::string_view reference) {
  const auto vehicle = twin_of(detection.vehicle);
  const auto X_MT = vehicle ? twin_at(*vehicle, detection.at) : std::nullopt;
  if (!X_MT) return std::nullopt;
  const Gap gap{distance(*X_MT, detection.pose), std::fabs(wrap_angle(X_MT->heading_rad - detection.pose.heading_rad))};
  simulator_.monitor().actual(registry_[*vehicle].twin_link.entity(), gap.m, gap.rad, reference);
  return gap;
}

Result<std::string> GroundTruthComparator::take_reference(const wire::Input& input) {
  if (input.flag || input.payload.empty()) return std::string{};  // retained: out of date
  const auto poses = wire::gvs_detections_from_json(input.payload);
  if (!poses) return tl::unexpected(poses.error());
  referenced_ = true;
  if (state() == "watching") return std::string{};
  for (const wire::GvsDetections::Detection& pose : poses->detections) (void)measure(pose, "instrument");
  return std::string{};
}

std::optional<Pose2> GroundTruthComparator::twin_at(VehicleIndex vehicle, SimTime at) const {
  if (vehicle >= trails_.size()) return std::nullopt;
  const auto& points = trails_[vehicle].points;
  const auto after = std::ranges::lower_bound(points, at, {}, &Trail::Point::at);
  if (after == points.end()) return std::nullopt;
  if (after->at == at) return after->X_MB;
  if (after == points.begin()) return std::nullopt;
  const Trail::Point& a = *std::prev(after);
  const Trail::Point& b = *after;
  const double ratio = to_seconds(at - a.at) / to_seconds(b.at - a.at);
  return Pose2{a.X_MB.x_m + ratio * (b.X_MB.x_m - a.X_MB.x_m), a.X_MB.y_m + ratio * (b.X_MB.y_m - a.X_MB.y_m),
               wrap_angle(a.X_MB.heading_rad + ratio * wrap_angle(b.X_MB.heading_rad - a.X_MB.heading_rad))};
}

void GroundTruthComparator::record_twins() {
  trails_.resize(registry_.size());
  for (VehicleIndex v = 0; v < registry_.size(); ++v) {
    const AivProxy& proxy = registry_[v];
    Trail& trail = trails_[v];
    if (!proxy.here() || proxy.augmented()) {
      trail = {};
      continue;
    }
    if (!trail.points.empty() && trail.points.back().at >= now_) continue;
    const Pose2 X_MT = simulator_.image(*proxy.twin(), now_).X_MB;
    const Pose2 X_MB = simulator_.zone() ? zone::body_pose(*simulator_.zone(), X_MT) : X_MT;
    trail.points.push_back({now_, X_MB});
    while (trail.points.front().at < now_ - history) trail.points.pop_front();
    if (!detections_ || !inside(detections_->field, position(X_MB)))
      trail.in_field_since.reset();
    else if (!trail.in_field_since)
      trail.in_field_since = now_;
  }
}

std::string_view GroundTruthComparator::state() const {
  if (connection_ && connection_->state != wire::ConnectionState::online)
    return connection_->state == wire::ConnectionState::offline ? "ended" : "broken";
  const SimDuration limit =
      std::max(unresponsive_after, detections_ ? from_seconds(3.0 * detections_->period_s) : unresponsive_after);
  return detections_ && now_ - detections_at_ <= limit ? "watching" : "unresponsive";
}

SimTime GroundTruthComparator::since(Finding::Kind kind, const std::string& id) const {
  for (const Finding& known : simulator_.monitor().findings())
    if (known.kind == kind && known.id == id) return known.since;
  return now_;
}

void GroundTruthComparator::find_unseen(std::vector<Finding>& findings) {
  for (VehicleIndex v = 0; v < trails_.size(); ++v) {
    const Trail& trail = trails_[v];
    if (!trail.in_field_since || trail.points.empty()) continue;
    const std::string& name = registry_[v].name();
    const auto detected = detected_.find(name);
    SimTime last = std::max(*trail.in_field_since, watching_since_);
    if (detected != detected_.end()) last = std::max(last, detected->second.arrived);
    if (now_ - last <= timeout) continue;
    findings.push_back({Finding::Kind::not_detected, name,
                        "its twin is at " + position_text(trail.points.back().X_MB) + ", where the camera sees no AIV",
                        since(Finding::Kind::not_detected, name)});
  }
}

std::optional<SimTime> GroundTruthComparator::undetected_since(VehicleIndex vehicle) const {
  if (vehicle >= trails_.size() || state() != "watching") return std::nullopt;
  const Trail& trail = trails_[vehicle];
  if (!trail.in_field_since || trail.points.empty() || !simulator_.zone()) return std::nullopt;
  const Point2 expected = position(trail.points.back().X_MB);
  SimTime since = std::max(*trail.in_field_since, watching_since_);
  for (const auto& [name, detected] : detected_) {
    const bool is_there = distance(position(detected.X_MB), expected) < simulator_.zone()->vehicle.length_m;
    if (is_there || name == registry_[vehicle].name()) since = std::max(since, detected.arrived);
  }
  return since;
}

std::vector<Finding> GroundTruthComparator::find(bool unknown_senders) {
  std::vector<Finding> findings;
  const std::string_view now_it = state();
  if (now_it == "ended") return findings;
  if (now_it != "watching") {
    // The camera's program may be starting up.
    if (now_it == "unresponsive" && connection_ && now_ - std::max(connection_at_, detections_at_) <= timeout &&
        connection_->trouble.empty())
      return findings;
    std::string text = now_it == "broken" ? "the camera's program is gone" : "no image arrives";
    if (connection_ && !connection_->trouble.empty()) text += ": " + connection_->trouble;
    findings.push_back(
        {Finding::Kind::no_detection, "GVS", std::move(text), since(Finding::Kind::no_detection, "GVS")});
    return findings;
  }
  for (const auto& [name, detected] : detected_) {
    if (detected.gap_m && simulator_.zone() && *detected.gap_m > simulator_.zone()->vehicle.length_m &&
        now_ - detected.arrived <= timeout)
      findings.push_back({Finding::Kind::displaced, name,
                          "the camera sees it at " + position_text(detected.X_MB) + ", " + decimetres(*detected.gap_m) +
                              " m from its twin",
                          since(Finding::Kind::displaced, name)});
    const bool is_present = now_ - detected.since > twin_expected_within && now_ - detected.arrived <= timeout;
    if (!unknown_senders || twin_of(name) || !is_present) continue;
    findings.push_back({Finding::Kind::no_twin, name,
                        "the camera sees it (tag " + std::to_string(detected.tag) + ") at " +
                            position_text(detected.X_MB) + ", and it has no twin",
                        since(Finding::Kind::no_twin, name), !reports(name)});
  }
  find_unseen(findings);
  return findings;
}

void GroundTruthComparator::tick(SimTime now, bool unknown_senders) {
  now_ = now;
  if (received() || referenced_) record_twins();
  if (!received()) return;
  std::erase_if(detected_, [&](const auto& one) { return now_ - one.second.arrived > timeout + timeout; });
  simulator_.monitor().set_findings(Observer::camera, find(unknown_senders));
}

void GroundTruthComparator::write(JsonWriter& json) const {
  if (!received()) {
    json.null();
    return;
  }
  json.begin_object().field("state", state());
  json.field("source", connection_ ? connection_->source : std::string{});
  json.field("trouble", connection_ ? connection_->trouble : std::string{});
  json.key("last_ms");
  if (detections_)
    json.value(to_milliseconds_scaled(detections_at_)).key("period_s").value(detections_->period_s);
  else
    json.null().key("period_s").null();
  json.key("detections").begin_array();
  for (const auto& [name, detected] : detected_) {
    json.begin_object().field("id", name).field("tag", detected.tag).field("twin", twin_of(name).has_value());
    json.field("x", rounded(detected.X_MB.x_m)).field("y", rounded(detected.X_MB.y_m));
    json.field("heading", rounded(detected.X_MB.heading_rad)).field("uncertainty_m", rounded(detected.uncertainty_m));
    json.field("at_ms", to_milliseconds_scaled(detected.at));
    number_or_null(json, "gap_m", detected.gap_m);
    number_or_null(json, "gap_rad", detected.gap_rad);
    json.end_object();
  }
  json.end_array().end_object();
}

void GroundTruthComparator::fold(Digest& digest) const {
  // The digest of a run without a camera contains nothing of this component.
  if (!received()) return;
  digest.add(state());
  digest.add(detections_at_);
  for (const auto& [name, detected] : detected_) {
    digest.add(std::string_view{name});
    digest.add(detected.X_MB.x_m);
    digest.add(detected.X_MB.y_m);
    digest.add(detected.gap_m.value_or(-1.0));
  }
}

void GroundTruthComparator::archive(Archive& archive) {
  archive(now_, connection_, connection_at_, detections_, detections_at_, watching_since_, referenced_, detected_,
          trails_);
}

}  // namespace cosiva::virtual_side
