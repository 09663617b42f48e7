#include "cosiva/physical/plant/vehicle.h"

#include <algorithm>
#include <cmath>

#include "cosiva/base/archive.h"
#include "cosiva/base/expect.h"
#include "cosiva/battery/cell_table.h"
#include "cosiva/physical/plant/plant_options.h"
#include "cosiva/wire/messages/travel_frame.h"

namespace cosiva::physical {
namespace {

Random stream(std::uint64_t seed, std::uint32_t number, std::string_view purpose) {
  return {seed, "aiv" + std::to_string(number) + "/" + std::string(purpose)};
}

/// A length or speed along an axis of the travel frame, in which the motion is, in the body frame, in which the boards
/// are.
double in_body_frame(const Floor& floor, double value) { return floor.zone->circuit.indirect() ? -value : value; }

DriveCommand to_command(const wire::Drive& drive) {
  return {drive.speed_mmps * 1e-3,
          drive.acceleration_mmps2 * 1e-3,
          drive.braking_mmps2 * 1e-3,
          drive.branch,
          drive.seek,
          drive.goal};
}

}  // namespace

Vehicle::Vehicle(std::uint32_t number, std::shared_ptr<const Floor> floor, zone::TrackPosition start,
                 const PlantNoise& noise, const VehicleEquipment& equipment, std::uint64_t seed,
                 const std::shared_ptr<const battery::CellTable>& cells, SimDuration step_max)
    : number_{number},
      step_max_{step_max},
      floor_{std::move(floor)},
      motion_{floor_->zone->circuit, start, noise.line_offset_sd_m, stream(seed, number, "line")},
      odometer_{noise.odometry_scale_sd, noise.odometry_noise_m_per_sqrt_m, noise.slip_per_mps2,
                stream(seed, number, "odometry")},
      tag_reader_{
          floor_->tags, {noise.tag_miss, noise.tag_latency_min, noise.tag_latency_max}, stream(seed, number, "tags")},
      power_{cells, stream(seed, number, "gauge")},
      boards_{number, equipment, noise, stream(seed, number, "ranges")},
      trip_{floor_->loop_length_m},
      seed_{seed} {}

void Vehicle::power_up(SimTime now, std::uint64_t seed) {
  boards_.power_up(now, stream(seed ^ static_cast<std::uint64_t>(now.time_since_epoch().count()), number_, "session"));
}

void Vehicle::inject(SimTime now, const std::optional<VehicleFault>& fault) {
  if (!fault) {
    faults_.end_all();
    return end_faults(now);
  }
  faults_.begin(now, *fault);
  switch (fault->kind) {
    case VehicleFault::Kind::stuck_sensor: return motion_.parts().dems.stick(fault->sensor, fault->reading);
    case VehicleFault::Kind::dead_motor: return motion_.parts().pmot.set_dead(fault->motor);
    case VehicleFault::Kind::failed_reader: return boards_.set_reader_failed(true);
    case VehicleFault::Kind::brown_out: return boards_.power_off();
  }
}

void Vehicle::end_faults(SimTime now) {
  while (const auto ended = faults_.take_ended(now)) {
    switch (*ended) {
      case VehicleFault::Kind::stuck_sensor: motion_.parts().dems.stick(LT_SENSORS, 0); break;
      case VehicleFault::Kind::dead_motor: motion_.parts().pmot.set_dead(DeadMotor::none); break;
      case VehicleFault::Kind::failed_reader: boards_.set_reader_failed(false); break;
      case VehicleFault::Kind::brown_out:
        odometer_.restart();
        power_up(now, seed_);
        break;
    }
  }
}

void Vehicle::move(SimTime now, SimDuration dt) {
  if (faults_.any()) end_faults(now);
  for (SimDuration left = dt; left > SimDuration::zero();) {
    const SimDuration part = std::min(left, step_max_);
    left -= part;
    step(now - left, to_seconds(part));
    book_waiting(part);
  }
}

void Vehicle::step(SimTime now, double dt_s) {
  auto drive = power_.cut_off() ? std::nullopt : boards_.drive(now, odometer_.distance_m());
  if (drive && floor_->zone->circuit.indirect()) drive = turned_round(*drive);
  DriveCommand command = drive ? to_command(*drive) : DriveCommand{};
  if (awaits_floor_ && command.seek) command.speed_mps = 0.0;
  const Point2 before = position(motion_.body().X_MB);
  motion_.step(drive ? &command : nullptr, boards_.line_tracker(), dt_s);

  const double moved_m = motion_.step_distance_m();
  if (motion_.following()) {
    in_manoeuvre_ = false;
  } else {
    step_manoeuvre();
  }
  trip_.add(moved_m);
  odometer_.add(in_body_frame(*floor_, moved_m), motion_.parts().pmot.acceleration_mps2());
  if (motion_.following()) read_tags(now, before);

  const double drive_j =
      power_.cart().drive_energy_j(moved_m, motion_.speed_mps(), motion_.parts().pmot.acceleration_mps2(), dt_s);
  draw_.energy_j += drive_j;
  draw_.power_w = drive_j / dt_s;
  book_energy(dt_s);
}

void Vehicle::read_tags(SimTime now, Point2 before) {
  readings_.clear();
  tag_reader_.move(now, motion_.track_position(), before, position(motion_.body().X_MB), readings_);
  for (const auto& reading : readings_) boards_.on_tag(reading.read_at, reading.number);
}

void Vehicle::step_manoeuvre() {
  if (!in_manoeuvre_) odometer_.begin_manoeuvre();
  in_manoeuvre_ = motion_.manoeuvre() != nullptr;
  const auto [turned_rad, traversed_m] = motion_.step_manoeuvre();
  odometer_.add_manoeuvre(turned_rad, in_body_frame(*floor_, traversed_m));
  draw_.energy_j += power_.cart().manoeuvre_energy_j(turned_rad, traversed_m);
}

void Vehicle::set_zone(std::shared_ptr<const Floor> floor) {
  COSIVA_EXPECT(is_stopped());
  const bool turns = floor->zone->circuit.indirect() != floor_->zone->circuit.indirect();
  floor_ = std::move(floor);
  trip_.begin_floor(floor_->loop_length_m);
  motion_.set_zone(floor_->zone->circuit, turns);
  tag_reader_.set_zone(floor_->tags);
  in_manoeuvre_ = false;
  awaits_floor_ = false;
}

void Vehicle::book_energy(double dt_s) {
  // Evaluating the cells' exponentials ten times a second is as good as a hundred: the charge changes by a millionth.
  // RALI's monitor measures as often.
  constexpr double period_s = 0.0999;
  draw_.time_s += dt_s;
  if (draw_.time_s < period_s) return;
  power_.draw(draw_.energy_j, draw_.time_s);
  draw_.energy_j = 0.0;
  draw_.time_s = 0.0;
}

void Vehicle::book_waiting(SimDuration dt) {
  constexpr double moving_mps = 0.01;
  const auto [turned_rad, traversed_m] = motion_.step_manoeuvre();
  if (std::fabs(motion_.speed_mps()) >= moving_mps || turned_rad != 0.0 || traversed_m != 0.0)
    trip_.on_moving();
  else
    trip_.on_waiting(dt);
}

WheelReadings Vehicle::wheel_readings() const {
  // The supply's wires and plugs have some resistance.
  constexpr double supply_v = 5.0;
  constexpr double supply_ohm = 0.1;
  const LineTracker& tracker = boards_.line_tracker();
  const Pmot& pmot = motion_.parts().pmot;
  const auto wheels = pmot.wheels();
  const double current_a = draw_.power_w / supply_v;
  const auto motor = [&](double speed_mps, DeadMotor side) {
    const double part = pmot.dead() == DeadMotor::none ? 0.5 : pmot.dead() == side ? 0.0 : 1.0;
    return WheelReadings::Motor{speed_mps, part * current_a, pmot.dead() != side};
  };
  const double left_mps = in_body_frame(*floor_, wheels.left_mps);
  const double right_mps = in_body_frame(*floor_, wheels.right_mps);
  const bool turned = floor_->zone->circuit.indirect();  // what is left in the travel frame is right in the body frame
  return {odometer_.distance_m(),
          in_body_frame(*floor_, motion_.speed_mps()),
          in_body_frame(*floor_, tracker.offset_m()),
          motion_.line_lost() || (motion_.following() && tracker.line_lost()),
          in_manoeuvre_ ? &odometer_.X_SB() : nullptr,
          turned ? motor(right_mps, DeadMotor::right) : motor(left_mps, DeadMotor::left),
          turned ? motor(left_mps, DeadMotor::left) : motor(right_mps, DeadMotor::right),
          motion_.parts().dems.readings(),
          supply_v - supply_ohm * current_a,
          floor_->zone->circuit.indirect()};
}

void Vehicle::speak(SimTime now, const Scan& scan, wire::Effects& effects) {
  if (boards_.due(now)) boards_.speak(now, wheel_readings(), scan, power_.readings(), effects);
}

void Vehicle::archive(Archive& archive) {
  archive(motion_, odometer_, tag_reader_, power_, boards_, trip_, faults_, in_manoeuvre_, awaits_floor_);
  if (archive.reads() && faults_.has(VehicleFault::Kind::failed_reader)) boards_.set_reader_failed(true);
  if (archive.reads() && faults_.has(VehicleFault::Kind::brown_out)) boards_.power_off();
}

}  // namespace cosiva::physical
