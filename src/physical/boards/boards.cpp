#include "cosiva/physical/boards/boards.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "cosiva/aiv/motion/formulas.h"
#include "cosiva/base/expect.h"

namespace cosiva::physical {
namespace {

/// The board brakes for the end of its room as it does when it receives no more Drives, and knows the motors' lag.
constexpr double room_braking_mps2 = 1.0;
constexpr double room_late_s = 0.05;

/// The nearest value that the frame's field can hold.
template <typename T>
T quantise(double value, double unit) {
  const double counts = std::nearbyint(value / unit);
  const double low = static_cast<double>(std::numeric_limits<T>::min());
  const double high = static_cast<double>(std::numeric_limits<T>::max());
  return static_cast<T>(std::clamp(counts, low, high));
}

}  // namespace

void PilsBoard::power_up(SimTime now, std::uint32_t session, SimDuration phase) {
  link_.power_up(now, session);
  odometry_.start(now + phase);
  parts_.start(now + phase);
  drive_.reset();
  line_tracker_.restart();
  uneven_cycles_ = 0;
}

void PilsBoard::on_bytes(SimTime now, std::string_view bytes) {
  for (const auto& message : link_.receive(bytes)) on_message(now, message);
}

void PilsBoard::on_frame(SimTime now, const wire::BoardFrames::Frame& frame) {
  link_.receive(frame);
  on_message(now, frame.message);
}

void PilsBoard::on_message(SimTime now, const wire::BoardMessage& message) {
  const auto* drive = std::get_if<wire::Drive>(&message);
  if (drive == nullptr) return;
  drive_ = *drive;
  driven_at_ = now;
  received_at_m_.reset();
}

void PilsBoard::tick(SimTime now, const WheelReadings& readings, BoardOutput out) {
  if (const auto number = link_.take_self_test()) {
    link_.finish_self_test(*number, test_parts(readings), out);
    line_tracker_.restart();
    uneven_cycles_ = 0;
  }
  link_.tick(now, out);
  if (!odometry_.take(now)) return;
  watch_parts(readings);
  send_odometry(now, readings, out);
  if (parts_.take(now)) send_parts(now, readings, out);
}

void PilsBoard::send_odometry(SimTime now, const WheelReadings& readings, BoardOutput out) {
  wire::Odometry odometry;
  odometry.board_ms = link_.board_ms(now);
  odometry.distance_um = static_cast<std::int64_t>(std::nearbyint(readings.distance_m * 1e6));
  odometry.speed_mmps = quantise<std::int16_t>(readings.speed_mps, 1e-3);
  odometry.line_offset_01mm = quantise<std::int16_t>(readings.line_offset_m, 1e-4);
  odometry.line_lost = readings.line_lost;
  if (const Pose2* moved = readings.manoeuvre) {
    odometry.speed_mmps = 0;
    odometry.manoeuvre = {quantise<std::int16_t>(moved->x_m, 1e-3), quantise<std::int16_t>(moved->y_m, 1e-3),
                          quantise<std::int16_t>(moved->heading_rad, 1e-3)};
  }
  link_.send(odometry, out);
}

void PilsBoard::send_parts(SimTime now, const WheelReadings& readings, BoardOutput out) {
  const auto motor = [](const WheelReadings::Motor& of) {
    return wire::PilsParts::Motor{quantise<std::int16_t>(of.speed_mps, 1e-3),
                                  quantise<std::int16_t>(of.current_a, 1e-3)};
  };
  constexpr std::uint8_t all_plugs = 7;
  link_.send(wire::PilsParts{link_.board_ms(now), quantise<std::uint16_t>(readings.supply_v, 1e-3), all_plugs,
                             readings.dems, motor(readings.left), motor(readings.right)},
             out);
}

void PilsBoard::watch_parts(const WheelReadings& readings) {
  if (line_tracker_.implausible()) link_.report_fault({wire::BoardPart::DEMS, wire::Finding::implausible});
  // On the tightest curve of a line tracker the inner wheel turns at a third of the outer one's speed.
  constexpr double turning_mps = 0.05;
  constexpr int uneven_cycles_max = 10;
  const auto [slow_mps, fast_mps] =
      std::minmax({std::fabs(readings.left.speed_mps), std::fabs(readings.right.speed_mps)});
  uneven_cycles_ = fast_mps > turning_mps && slow_mps < 0.25 * fast_mps ? uneven_cycles_ + 1 : 0;
  if (uneven_cycles_ >= uneven_cycles_max) link_.report_fault({wire::BoardPart::PMOT, wire::Finding::does_not_turn});
}

std::vector<wire::PartFinding> PilsBoard::test_parts(const WheelReadings& readings) {
  using wire::Finding;
  constexpr double supply_v_min = 4.5;
  const bool plausible = lt_implausible(&dems_geometry, readings.dems.data()) == 0;
  const bool turns = readings.left.turns && readings.right.turns;
  return {{wire::BoardPart::controller, Finding::passed},
          {wire::BoardPart::BRAC, readings.supply_v >= supply_v_min ? Finding::passed : Finding::low_supply},
          {wire::BoardPart::DEMS, plausible ? Finding::passed : Finding::implausible},
          {wire::BoardPart::PMOT, turns ? Finding::passed : Finding::does_not_turn}};
}

std::optional<wire::Drive> PilsBoard::drive(SimTime now, double distance_m) {
  if (!driven(now) || link_.faulty()) return std::nullopt;
  if (!drive_->room_mm || drive_->speed_mmps == 0) return drive_;
  if (!received_at_m_) received_at_m_ = distance_m;
  const double left_m = 1e-3 * *drive_->room_mm - std::fabs(distance_m - *received_at_m_);
  const double limit_mmps = 1e3 * aiv::plain::stoppable_speed(left_m, room_braking_mps2, room_late_s);
  if (std::fabs(drive_->speed_mmps) <= limit_mmps) return drive_;
  wire::Drive limited = *drive_;
  limited.speed_mmps = static_cast<std::int16_t>(std::copysign(limit_mmps, drive_->speed_mmps));
  limited.braking_mmps2 = std::max(limited.braking_mmps2, static_cast<std::uint16_t>(1e3 * room_braking_mps2));
  return limited;
}

void PravBoard::power_up(SimTime now, std::uint32_t session) {
  link_.power_up(now, session);
  readings_.clear();
  display_.clear();
}

void PravBoard::on_bytes(SimTime /*now*/, std::string_view bytes) {
  for (const auto& message : link_.receive(bytes)) on_message(message);
}

void PravBoard::on_frame(SimTime /*now*/, const wire::BoardFrames::Frame& frame) {
  link_.receive(frame);
  on_message(frame.message);
}

void PravBoard::on_message(const wire::BoardMessage& message) {
  if (const auto* display = std::get_if<wire::Display>(&message)) display_ = display->text;
}

void PravBoard::on_tag(SimTime read_at, std::uint32_t number) {
  if (!reader_failed_) readings_.push_back({read_at, number});
}

SimTime PravBoard::next_due() const {
  SimTime next = link_.next_due();
  for (const Reading& reading : readings_) next = std::min(next, reading.read_at);
  return next;
}

void PravBoard::tick(SimTime now, BoardOutput out) {
  // PRAV polls its reader all the time, so a reader that does not respond is found at once.
  const wire::PartFinding reader{wire::BoardPart::RFID,
                                 reader_failed_ ? wire::Finding::no_response : wire::Finding::passed};
  link_.report_fault(reader);
  if (const auto number = link_.take_self_test())
    link_.finish_self_test(*number, {{wire::BoardPart::controller}, reader, {wire::BoardPart::AFFI}}, out);
  link_.tick(now, out);
  std::erase_if(readings_, [&](const Reading& reading) {
    if (reading.read_at > now) return false;
    const double age_ms = 1e3 * to_seconds(now - reading.read_at);
    link_.send(wire::TagRead{link_.board_ms(now), reading.number, quantise<std::uint16_t>(age_ms, 1.0)}, out);
    return true;
  });
}

void DobsBoard::power_up(SimTime now, std::uint32_t session, SimDuration phase) {
  link_.power_up(now, session);
  scan_.start(now + phase);
  auto& ranges = std::get<wire::Ranges>(ranges_);
  ranges.first_bearing_crad = first_bearing_crad;
  ranges.beam_width_crad = beam_width_crad;
  ranges.range_mm.assign(beams, wire::no_echo);
}

void DobsBoard::on_bytes(SimTime /*now*/, std::string_view bytes) { static_cast<void>(link_.receive(bytes)); }
void DobsBoard::on_frame(SimTime /*now*/, const wire::BoardFrames::Frame& frame) { link_.receive(frame); }

void DobsBoard::tick(SimTime now, std::span<const double, beams> range_m, BoardOutput out) {
  if (const auto number = link_.take_self_test())
    link_.finish_self_test(*number, {{wire::BoardPart::controller}, {wire::BoardPart::ranging}}, out);
  link_.tick(now, out);
  if (!scan_.take(now)) return;
  auto& ranges = std::get<wire::Ranges>(ranges_);
  COSIVA_EXPECT(ranges.range_mm.size() == beams);
  ranges.board_ms = link_.board_ms(now);
  ranges.first_bearing_crad = static_cast<std::int16_t>(first_bearing_crad + (at_rear_ ? half_turn_crad : 0));
  for (std::size_t i = 0; i < beams; ++i)
    ranges.range_mm[i] = range_m[i] < 0.0 ? wire::no_echo : quantise<std::uint16_t>(range_m[i], 1e-3);
  link_.send(ranges_, out);
}

void RaliBoard::power_up(SimTime now, std::uint32_t session, SimDuration phase) {
  link_.power_up(now, session);
  report_.start(now + phase);
}

void RaliBoard::on_bytes(SimTime /*now*/, std::string_view bytes) { static_cast<void>(link_.receive(bytes)); }
void RaliBoard::on_frame(SimTime /*now*/, const wire::BoardFrames::Frame& frame) { link_.receive(frame); }

void RaliBoard::tick(SimTime now, const PowerReadings& readings, BoardOutput out) {
  if (const auto number = link_.take_self_test())
    link_.finish_self_test(*number, {{wire::BoardPart::controller}, {wire::BoardPart::regulator}}, out);
  link_.tick(now, out);
  if (!report_.take(now)) return;
  const double charge = std::clamp(readings.charge, 0.0, 1.0);
  wire::Power power{quantise<std::uint16_t>(readings.voltage_v, 1e-3), quantise<std::int16_t>(readings.current_a, 1e-3),
                    quantise<std::int16_t>(readings.temperature_c, 0.1), quantise<std::uint16_t>(charge, 1e-3)};
  if (readings.charge_sd > 0.0)
    power.gauge = {quantise<std::uint32_t>(charge, 1e-6), quantise<std::uint16_t>(readings.charge_sd, 1e-4)};
  link_.send(power, out);
}

}  // namespace cosiva::physical
