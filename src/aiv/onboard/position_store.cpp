#include "cosiva/aiv/onboard/position_store.h"

#include <array>
#include <cmath>
#include <utility>

#include "cosiva/base/archive.h"
#include "cosiva/base/expect.h"

namespace cosiva::aiv {
namespace {

constexpr SimDuration save_period = std::chrono::milliseconds{100};
/// A saved position whose odometer differs by more is not of this drive.
constexpr double saved_distance_m_max = 100.0;
/// An off-path body that has moved further than this is no longer where it was.
constexpr double off_line_distance_m_max = 0.005;
/// A zone that has not arrived by then, where the broker retains it, is no longer the vehicle's.
constexpr SimDuration zone_arrives_within = std::chrono::seconds{3};
/// A section within these tolerances lies where it lay when the position was saved.
constexpr double same_position_m = 0.02;
constexpr double same_heading_rad = 0.05;

/// What is saved is in the body frame, what the vehicle computes with in the travel frame: the one as the other.
PersistedPosition in_other_frame(const zone::TrafficZone& zone, PersistedPosition position) {
  if (!zone.circuit.indirect()) return position;
  position.odometer_um = -position.odometer_um;
  if (position.pose) position.pose = turned_round(*position.pose);
  if (position.manoeuvre)
    position.manoeuvre = Pose2{-position.manoeuvre->x_m, -position.manoeuvre->y_m, position.manoeuvre->heading_rad};
  return position;
}

PersistedPosition position_of(const DrivingContext& context, std::int64_t odometer_um, std::uint32_t pils_session) {
  const Agent& agent = context.agent();
  const PositionEstimator& position = agent.vehicle().position();
  PersistedPosition now_here;
  now_here.zone = context.zone().name;
  now_here.odometer_um = odometer_um;
  now_here.session = pils_session;
  now_here.paused = agent.vehicle().holds().has(Hold::paused);
  now_here.imposed = agent.instructions().imposed;
  now_here.off_path = (position.pose_known() && !position.known()) || position.near_path();
  const OffPathEstimator& off_path = position.off_path_estimator();
  now_here.manoeuvre = off_path.manoeuvred();
  now_here.pose = off_path.left_line_at() ? *off_path.left_line_at() : position.pose();
  if (position.known()) {
    const zone::TrackPosition at = position.track_position();
    now_here.section = context.zone().circuit.part(at.section).name;
    now_here.s_m = at.s_m;
  }
  if (const auto remaining = position.on_path_estimator().path().course().remaining(); !remaining.empty())
    now_here.next = context.zone().circuit.part(remaining.front()).name;
  return in_other_frame(context.zone(), std::move(now_here));
}

}  // namespace

PositionStore::PositionStore(const OnboardOptions& options)
    : start_{options.start}, as_values_{options.as_values}, timer_{save_period} {}

void PositionStore::restore(PersistedPosition restored, DrivingContext* context) {
  restored_ = std::move(restored);
  if (context == nullptr) return;
  restrict(context->agent());
  find_position(*context);
}

void PositionStore::restrict(Agent& agent) const {
  agent.vehicle().hold(Hold::paused, restored_->paused);
  agent.instructions().imposed = restored_->imposed;
}

bool PositionStore::on_pils_hello(std::uint32_t session) {
  const bool powered_up_anew = pils_session_ && *pils_session_ != session;
  pils_session_ = session;
  return powered_up_anew;
}

void PositionStore::on_first_zone(DrivingContext& context, wire::Effects& effects) {
  if (restored_) restrict(context.agent());
  const std::string& zone = context.zone().name;
  if (start_ && !context.zone().circuit.find(start_->section))
    effects.emplace_back(wire::Log{'e', "start: no section '" + start_->section + "' in zone '" + zone + "'"});
}

void PositionStore::on_zone_switched(DrivingContext& context) {
  start_counts_ = false;
  if (restored_ && restored_->zone == context.zone().name) find_position(context);
  request_save();
}

void PositionStore::find_position(DrivingContext& context) {
  VehicleState& vehicle = context.vehicle();
  const bool of_this_zone = restored_ && restored_->zone == context.zone().name;
  if (vehicle.position().pose_known() && !(of_this_zone && !start_counts_)) return;
  // A position in another zone is preserved: that zone may be the broker's, and arrive later.
  if (restored_ && (!pils_session_ || !vehicle.position().counter().reading_um())) return;  // not yet comparable
  if (of_this_zone) {
    const bool placed = restore_position(context);
    restored_.reset();
    if (placed) return;
  }
  if (vehicle.position().pose_known() || !start_ || !start_counts_) return;
  if (const auto section = context.zone().circuit.find(start_->section))
    vehicle.estimator().position_at({*section, start_->s_m});
}

bool PositionStore::restore_position(DrivingContext& context) {
  const PersistedPosition restored = in_other_frame(context.zone(), *restored_);
  if (restored.session != *pils_session_) return false;
  VehicleState& vehicle = context.vehicle();
  const zone::Circuit& circuit = context.zone().circuit;
  const std::int64_t reading_um = *vehicle.position().counter().reading_um();
  const double distance_m = 1e-6 * (static_cast<double>(reading_um) - static_cast<double>(restored.odometer_um));
  if (!(std::fabs(distance_m) <= saved_distance_m_max)) return false;
  // A position that was known before and has driven on since is no longer where it was saved.
  if (vehicle.position().pose_known() && std::fabs(distance_m) > off_line_distance_m_max) return false;
  if (!restored.off_path) {
    if (const auto track_position = restored_position(circuit, restored, distance_m)) {
      vehicle.estimator().position_at(*track_position);
      const auto next = restored.next ? circuit.find(*restored.next) : std::nullopt;
      if (restored.manoeuvre) vehicle.estimator().resume_manoeuvre(*restored.manoeuvre, next);
      return true;
    }
  }
  if (!restored.pose || std::fabs(distance_m) > off_line_distance_m_max) return false;
  // PILS's present report of a manoeuvre is newer than the saved one.
  const auto& manoeuvred = vehicle.position().off_path_estimator().manoeuvred();
  const Pose2 X_OB = manoeuvred ? *manoeuvred : restored.manoeuvre.value_or(Pose2{});
  vehicle.estimator().set_off_path(*restored.pose * X_OB);
  if (restored.manoeuvre) vehicle.estimator().resume_manoeuvre(*restored.manoeuvre, std::nullopt);
  return true;
}

std::optional<zone::TrackPosition> PositionStore::restored_position(const zone::Circuit& circuit,
                                                                    const PersistedPosition& restored,
                                                                    double distance_m) {
  const auto section = circuit.find(restored.section);
  if (!section || !std::isfinite(restored.s_m)) return std::nullopt;
  const zone::TrackPosition track_position{*section, restored.s_m};
  if (restored.pose) {
    // The section of the same name may lie elsewhere by now.
    if (!(restored.s_m >= 0.0 && restored.s_m <= circuit.section(*section).length_m() + same_position_m))
      return std::nullopt;
    const Pose2 X_MP = circuit.pose_at(circuit.advance(track_position, 0.0));
    if (distance(X_MP, *restored.pose) > same_position_m ||
        std::fabs(wrap_angle(X_MP.heading_rad - restored.pose->heading_rad)) > same_heading_rad)
      return std::nullopt;
  }
  const auto next = restored.next ? circuit.find(*restored.next) : std::nullopt;
  if (!next) return circuit.advance(track_position, distance_m);
  return circuit.advance(track_position, distance_m, std::array{*next});
}

void PositionStore::restore_in_another_zone(SimTime now, DrivingContext& context) {
  const PositionEstimator& position = context.vehicle().position();
  if (!restored_ || restored_->zone == context.zone().name || position.pose_known()) return;
  if (!pils_session_ || !position.counter().reading_um()) return;
  if (!other_zone_since_) other_zone_since_ = now;
  if (now - *other_zone_since_ < zone_arrives_within) return;
  if (restored_->session != *pils_session_) return restored_.reset();
  // Without a pose, nothing shows that a section of the same name is the same one. A vehicle that has moved, and whose
  // section is not in this zone, finds its position in the saved zone alone, which may still arrive.
  if (restored_->pose) (void)restore_position(context);
}

void PositionStore::discard_restored() {
  restored_.reset();
  request_save();
}

void PositionStore::keep_loads(const std::vector<wire::Load>& loads) {
  if (loads == loads_) return;
  loads_ = loads;
  request_save();
}

void PositionStore::on_tick(SimTime now, DrivingContext& context, wire::Effects& effects) {
  restore_in_another_zone(now, context);
  save(timer_.take(now), context, effects);
  was_stopped_ = context.vehicle().motion().stopped();
}

void PositionStore::save_now(const DrivingContext& context, wire::Effects& effects) {
  request_save();
  save(true, context, effects);
}

void PositionStore::save(bool due, const DrivingContext& context, wire::Effects& effects) {
  const PositionEstimator& position = context.vehicle().position();
  if (!position.pose_known() || !pils_session_) return;
  const auto odometer_um = position.counter().reading_um();
  if (!odometer_um) return;
  const auto& manoeuvred = position.off_path_estimator().manoeuvred();
  if (odometer_um == saved_um_ && manoeuvred == saved_manoeuvre_ && !requested_) return;
  const bool stopped = context.vehicle().motion().stopped();
  if (!due && !(stopped && !was_stopped_) && !requested_) return;
  PersistedPosition now_here = position_of(context, *odometer_um, *pils_session_);
  COSIVA_EXPECT(now_here.session == *pils_session_);
  now_here.loads = loads_;
  if (as_values_)
    saved_ = std::move(now_here);
  else
    effects.emplace_back(wire::Persist{to_json(now_here)});
  saved_um_ = odometer_um;
  saved_manoeuvre_ = manoeuvred;
  requested_ = false;
}

std::string PositionStore::saved_json() const { return saved_ ? to_json(*saved_) : std::string{}; }

void PositionStore::archive(Archive& archive) {
  archive(start_counts_, restored_, other_zone_since_, saved_, pils_session_, timer_, saved_um_, saved_manoeuvre_,
          loads_, requested_, was_stopped_);
}

}  // namespace cosiva::aiv
