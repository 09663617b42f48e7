#include "cosiva/virtual/server/augmented/virtual_obstacle_publisher.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "cosiva/base/archive.h"
#include "cosiva/base/expect.h"
#include "cosiva/base/math.h"

namespace cosiva::virtual_side {
namespace {

constexpr std::size_t changes_max = 16;
/// CoSiVA vehicles acknowledge the first message that they receive at once. A vehicle that has not acknowledged three
/// messages within this time does not support them.
constexpr SimDuration response_timeout{std::chrono::milliseconds{300}};
constexpr std::uint32_t unanswered_max = 3;
constexpr SimDuration perceived_max{std::chrono::seconds{1}};

}  // namespace

wire::Body body_of(std::string id, const Pose2& X_MB, double speed_mps, const zone::VehicleShape& shape) {
  const SinCos turn = sincos(X_MB.heading_rad);
  return {std::move(id),
          "aiv",
          X_MB.x_m,
          X_MB.y_m,
          X_MB.heading_rad,
          std::max(0.0, shape.length_m - shape.width_m),
          0.5 * shape.width_m,
          speed_mps * turn.cos,
          speed_mps * turn.sin};
}

double distance_to(const wire::Body& body, Point2 p) {
  const SinCos turn = sincos(body.heading_rad);
  const double dx = p.x_m - body.x_m;
  const double dy = p.y_m - body.y_m;
  const double along = std::clamp(turn.cos * dx + turn.sin * dy, -0.5 * body.length_m, 0.5 * body.length_m);
  return norm(dx - along * turn.cos, dy - along * turn.sin) - body.radius_m;
}

std::optional<Pose2> VirtualObstaclePublisher::pose_of(VehicleIndex vehicle) const {
  if (const VirtualFleet::Host* host = fleet_.find(vehicle)) return host->aiv.X_MB();
  const AivProxy& proxy = registry_[vehicle];
  if (!proxy.here()) return std::nullopt;
  return simulator_.image(*proxy.twin(), publisher_.now()).X_MB;
}

bool VirtualObstaclePublisher::can_receive(VehicleIndex vehicle) const {
  const AivProxy& proxy = registry_[vehicle];
  return fleet_.find(vehicle) != nullptr ||
         (proxy.here() && proxy.online() && proxy.position.known() && !proxy.membership.handed_over());
}

void VirtualObstaclePublisher::gather() {
  world_.clear();
  const SimTime now = publisher_.now();
  for (const VirtualObject& virtual_object : simulator_.augmented().virtual_objects()) {
    const Walk::Motion at = virtual_object.at(now);
    world_.push_back({{virtual_object.id, std::string(to_string(virtual_object.kind)), at.at.x_m, at.at.y_m,
                       at.heading_rad, 0.0, virtual_object.radius_m, at.vx_mps, at.vy_mps},
                      virtual_object.handle,
                      virtual_object.started,
                      no_vehicle,
                      false});
  }
  if (!fleet_.empty()) gather_vehicles();
}

void VirtualObstaclePublisher::gather_vehicles() {
  const zone::VehicleShape& shape = simulator_.zone()->vehicle;
  const SimTime now = publisher_.now();
  for (const VirtualFleet::Host& host : fleet_.hosts()) {
    const Pose2 X_MB = host.aiv.X_MB();
    world_.push_back({body_of(registry_[host.vehicle].name(), X_MB, host.aiv.speed_mps(), shape),
                      static_cast<std::uint16_t>(host.vehicle), host.since, host.vehicle, false});
  }
  for (VehicleIndex v = 0; v < registry_.size(); ++v) {
    const AivProxy& proxy = registry_[v];
    if (!proxy.here() || proxy.augmented()) continue;
    const Twin::Image image = simulator_.image(*proxy.twin(), now);
    world_.push_back(
        {body_of(proxy.name(), image.X_MB, image.speed_mps, shape), static_cast<std::uint16_t>(v), {}, v, true});
  }
  for (const DetectedObstacle& detected : simulator_.detected().obstacles()) {
    world_.push_back(
        {{detected.id, "obstacle", detected.at.x_m, detected.at.y_m, 0.0, 0.0, detected.radius_m, 0.0, 0.0},
         detected.handle,
         detected.first,
         no_vehicle,
         true});
  }
}

void VirtualObstaclePublisher::update() {
  if (simulator_.zone() == nullptr) return;
  if (simulator_.augmented().empty() && fleet_.empty() && !busy_) return;
  busy_ = false;
  gather();
  for (VehicleIndex v = 0; v < viewers_.size(); ++v) {
    if (can_receive(v)) survey_neighbours(v);
    // A vehicle that is offline is sent the bodies when it is online again.
    const Viewer& viewer = viewers_[v];
    busy_ = busy_ || !viewer.commanded.empty() || viewer.empties > 0 || !viewer.perceives.empty() ||
            registry_[v].settings.paused_for_body();
  }
}

void VirtualObstaclePublisher::pick(VehicleIndex vehicle, const Pose2& X_MB) {
  near_.clear();
  const bool augmented = registry_[vehicle].augmented();
  const double half_length_m = 0.5 * simulator_.zone()->vehicle.length_m;
  const SinCos turn = sincos(X_MB.heading_rad);
  for (Present& present : world_) {
    if (present.vehicle == vehicle || (present.physical && !augmented)) continue;
    present.distance_m = distance_to(present.body, position(X_MB));
    if (present.distance_m > within_m) continue;
    const double centre_m = turn.cos * (present.body.x_m - X_MB.x_m) + turn.sin * (present.body.y_m - X_MB.y_m);
    const double half_m =
        0.5 * present.body.length_m * std::fabs(det_cos(present.body.heading_rad - X_MB.heading_rad)) +
        present.body.radius_m;
    if (centre_m + half_m < -half_length_m) continue;  // wholly behind the viewer
    near_.push_back(&present);
  }
  std::ranges::stable_sort(near_, {}, [](const Present* p) { return p->distance_m; });
  if (near_.size() > wire::VirtualObstacles::bodies_max) near_.resize(wire::VirtualObstacles::bodies_max);
  sent_objects_.clear();
  for (const Present* present : near_) sent_objects_.emplace_back(present->handle, present->changed);
  std::ranges::sort(sent_objects_);
}

void VirtualObstaclePublisher::survey_neighbours(VehicleIndex vehicle) {
  const auto X_MB = pose_of(vehicle);
  if (!X_MB) return;
  Viewer& viewer = viewers_[vehicle];
  const SimTime now = publisher_.now();
  pick(vehicle, *X_MB);
  if (sent_objects_ != viewer.commanded) {
    record_change(viewer);
    send(vehicle, viewer);
  } else if (now >= viewer.due && (!near_.empty() || viewer.empties > 0)) {
    if (near_.empty()) --viewer.empties;
    send(vehicle, viewer);
  }
  if (near_.empty() && viewer.empties == 0 && now - viewer.due > perceived_max) viewer.perceives.clear();

  // A vehicle that was paused before a restart of the server stays paused until it acknowledges a message.
  const bool given_up = viewer.unanswered >= unanswered_max && now - viewer.first_sent >= response_timeout;
  // An acknowledgement may be lost; but a vehicle that reports its boards runs the CoSiVA program and perceives by
  // itself.
  const AivProxy& proxy = registry_[vehicle];
  const bool is_cosiva = viewer.acknowledged || proxy.augmented() || proxy.on_board.boards();
  const bool deaf = !is_cosiva && (given_up || proxy.settings.paused_for_body());
  if (!deaf || near_.empty()) {
    pauses_.let_go(vehicle);
    return;
  }
  std::array<ThirdPartyPause::Body, wire::VirtualObstacles::bodies_max> bodies{};
  for (std::size_t i = 0; i < near_.size(); ++i) bodies[i] = {&near_[i]->body, near_[i]->vehicle != no_vehicle};
  pauses_.evaluate(vehicle, *X_MB, {bodies.data(), near_.size()});
  viewer.perceives = pauses_.paused_for(vehicle);
}

void VirtualObstaclePublisher::record_change(Viewer& viewer) {
  COSIVA_EXPECT(std::ranges::is_sorted(viewer.commanded) && std::ranges::is_sorted(sent_objects_));
  Change change{viewer.next_id, publisher_.now(), false, {}};
  for (const Present* present : near_) {
    const SentObject fiducial{present->handle, present->changed};
    if (!std::ranges::binary_search(viewer.commanded, fiducial)) change.came.push_back(present->body.id);
  }
  if (viewer.changes.size() >= changes_max) viewer.changes.erase(viewer.changes.begin());
  viewer.changes.push_back(std::move(change));
  COSIVA_EXPECT(viewer.changes.size() <= changes_max);
  viewer.empties = sent_objects_.empty() ? empty_last - 1 : 0;
  viewer.commanded = sent_objects_;
}

void VirtualObstaclePublisher::send(VehicleIndex vehicle, Viewer& viewer) {
  const SimTime now = publisher_.now();
  AivProxy& proxy = registry_[vehicle];
  COSIVA_EXPECT(near_.size() <= wire::VirtualObstacles::bodies_max);
  viewer.sent[viewer.next_id % sent_kept] = now;
  wire::VirtualObstacles ahead{viewer.next_id++, now, simulator_.zone()->name, {}};
  ahead.bodies.reserve(near_.size());
  constexpr std::string_view kind = "virtual_obstacles";
  std::string summary = near_.empty() ? "nothing" : "";
  for (const Present* present : near_) {
    ahead.bodies.push_back(present->body);
    summary += (summary.empty() ? "" : ", ") + present->body.id;
  }
  std::string topic = wire::own_topic(wire::virtual_obstacles_topic_prefix, proxy.id());
  std::string payload = wire::to_json(ahead);
  viewer.due = now + period;
  if (!near_.empty()) {
    if (viewer.unanswered++ == 0) viewer.first_sent = now;
  }
  if (fleet_.find(vehicle) == nullptr)
    return publisher_.send(proxy, kind, summary, {std::move(topic), std::move(payload), 0, false});
  proxy.pass_on(traces_, now, {kind, summary, topic, payload});
  fleet_.message(now, vehicle, topic, payload);
}

bool VirtualObstaclePublisher::on_virtual_obstacles_ack(VehicleIndex vehicle,
                                                        const wire::VirtualObstaclesAck& perceived, SimTime decided) {
  Viewer& viewer = viewers_[vehicle];
  const std::uint32_t behind = viewer.next_id - perceived.virtual_obstacles_header_id;  // counts modulo 2³²
  if (behind == 0 || behind > known_max) return false;
  viewer.acknowledged = true;
  const bool begins_to_brake = perceived.braking && viewer.perceives != perceived.body;
  viewer.perceives = perceived.braking ? perceived.body : std::string{};
  // Virtual AIVs in this server perceive everything at once; counting them would only improve the metrics.
  if (!registry_[vehicle].augmented()) measure(viewer, perceived, decided, begins_to_brake);
  return true;
}

void VirtualObstaclePublisher::measure(Viewer& viewer, const wire::VirtualObstaclesAck& perceived, SimTime decided,
                                       bool begins_to_brake) {
  BijectionMonitor& monitor = simulator_.monitor();
  const auto since_ms = [decided](SimTime then) { return std::max(0.0, to_milliseconds_by_seconds(decided - then)); };
  bool was_change = false;
  for (Change& change : viewer.changes) {
    if (perceived.virtual_obstacles_header_id - change.header_id > response_within) continue;
    if (!std::exchange(change.perceived, true)) monitor.effect(WorldEffect::perceived, since_ms(change.since));
    if (!perceived.braking || std::erase(change.came, perceived.body) == 0) continue;
    monitor.effect(WorldEffect::brakes, since_ms(change.since));
    was_change = true;
  }
  // The body was sent before, and now the distance fell below the braking distance: measure the age of the vehicle's
  // information.
  if (begins_to_brake && !was_change && viewer.next_id - perceived.virtual_obstacles_header_id <= sent_kept)
    monitor.effect(WorldEffect::brakes, since_ms(viewer.sent[perceived.virtual_obstacles_header_id % sent_kept]));
}

void VirtualObstaclePublisher::fold(Digest& digest) const {
  for (const Viewer& viewer : viewers_) {
    digest.add(std::uint64_t{viewer.next_id});
    digest.add(static_cast<std::uint64_t>(viewer.commanded.size()));
    digest.add(std::string_view{viewer.perceives});
  }
}

void VirtualObstaclePublisher::archive(Archive& archive) { archive(viewers_, busy_); }

}  // namespace cosiva::virtual_side
