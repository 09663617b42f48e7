#include "cosiva/virtual/vehicle/simulated_boards.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "cosiva/base/archive.h"
#include "cosiva/base/expect.h"
#include "cosiva/wire/messages/travel_frame.h"

namespace cosiva::virtual_side {
namespace {

/// Replaces the hash of the image that a real board would carry.
std::uint32_t firmware_hash(wire::Board board) {
  Digest digest;
  digest.add(std::string_view{"simulated board 1"});
  digest.add(to_string(board));
  return static_cast<std::uint32_t>(digest.value() >> 32U);
}

/// True once per period; late calls are not made up for in a burst.
bool take(SimTime now, SimTime& next, SimDuration period) {
  if (now < next) return false;
  next = next + period > now ? next + period : now + period;
  return true;
}

}  // namespace

void SimulatedBoards::power_up(SimTime now) {
  powered_at_ = now;
  heartbeat_next_ = ranges_next_ = power_next_ = now;
}

void SimulatedBoards::on_bytes(SimTime now, wire::Board board, std::string_view bytes) {
  Line& of = line(board);
  received_.clear();
  of.decoder.feed(bytes, received_);
  COSIVA_EXPECT(of.decoder.counters().frames_bad == 0);
  for (const wire::BoardMessage& message : received_) {
    if (std::holds_alternative<wire::Hello>(message)) of.hello_due = true;
    if (const auto* request = std::get_if<wire::SelfTestRequest>(&message)) of.self_test_due = request->number;
    const auto* drive = std::get_if<wire::Drive>(&message);
    if (drive == nullptr || board != wire::Board::PILS) continue;
    drive_ = *drive;
    driven_at_ = now;
  }
}

void SimulatedBoards::send(wire::Board board, const wire::BoardMessage& message) {
  Line& to = line(board);
  to.encoder.append(to.out, message);
}

void SimulatedBoards::speak(SimTime now, const Measured& measured) {
  const bool heartbeat = take(now, heartbeat_next_, std::chrono::milliseconds{100});
  for (const wire::Board board : wire::all_boards) {
    Line& of = line(board);
    of.out.clear();
    if (of.hello_due) send(board, wire::Hello{board, wire::module_link::version, firmware_hash(board), session_});
    of.hello_due = false;
    // A simulated board has no parts that could fail.
    if (const auto number = std::exchange(of.self_test_due, std::nullopt))
      send(board, wire::SelfTestResult{*number, {{wire::BoardPart::controller}}});
    const auto& counters = of.decoder.counters();
    if (heartbeat) send(board, wire::Heartbeat{board_ms(now), counters.frames_bad, counters.frames_missed, 0});
  }
  send_odometry(now, measured);
  send_readings(now);
  if (take(now, ranges_next_, std::chrono::milliseconds{60})) {
    wire::Ranges& ranges = std::get<wire::Ranges>(no_echoes_);
    ranges.board_ms = board_ms(now);
    if (points_forwards(ranges) == measured.indirect) ranges = turned_round(ranges);
    send(wire::Board::DOBS, no_echoes_);
  }
  // Two full cells at rest: a virtual AIV does not discharge its battery.
  if (take(now, power_next_, std::chrono::milliseconds{500})) send(wire::Board::RALI, wire::Power{8400, 0, 220, 1000});
}

void SimulatedBoards::send_odometry(SimTime now, const Measured& measured) {
  const auto quantise = [](double value, double unit) {
    return static_cast<std::int16_t>(std::clamp(std::nearbyint(value / unit), -32768.0, 32767.0));
  };
  wire::Odometry odometry;
  odometry.board_ms = board_ms(now);
  odometry.speed_mmps = quantise(measured.speed_mps, 1e-3);
  odometry.line_lost = measured.line_lost;
  if (const Pose2* moved = measured.manoeuvre) {
    odometry.speed_mmps = 0;
    odometry.manoeuvre = {quantise(moved->x_m, 1e-3), quantise(moved->y_m, 1e-3), quantise(moved->heading_rad, 1e-3)};
  }
  if (measured.indirect) odometry = turned_round(odometry);
  odometry.distance_um = static_cast<std::int64_t>(std::nearbyint(measured.odometer_m * 1e6));
  send(wire::Board::PILS, odometry);
}

void SimulatedBoards::send_readings(SimTime now) {
  // The on-board program accounts for the reading time of 20 ms, one tick; the age is the additional delay.
  constexpr SimDuration reading = std::chrono::milliseconds{20};
  std::erase_if(readings_, [&](const Reading& tag) {
    const SimDuration age = now - tag.read_at - reading;
    if (age < SimDuration::zero()) return false;
    const double age_ms = std::min(std::nearbyint(1e3 * to_seconds(age)), 65535.0);
    send(wire::Board::PRAV, wire::TagRead{board_ms(now), tag.number, static_cast<std::uint16_t>(age_ms)});
    return true;
  });
}

void SimulatedBoards::fold(Digest& digest) const {
  digest.add(std::uint64_t{session_});
  digest.add(std::uint64_t{drive_.has_value()});
  if (drive_) {
    digest.add(std::int64_t{drive_->speed_mmps});
    digest.add(std::uint64_t{drive_->acceleration_mmps2});
    digest.add(std::uint64_t{drive_->braking_mmps2});
    digest.add(std::uint64_t{drive_->branch});
    digest.add(std::uint64_t{drive_->seek});
    digest.add(driven_at_);
  }
  for (const Reading& reading : readings_) digest.add(std::uint64_t{reading.number});
}

void SimulatedBoards::archive(Archive& archive) {
  archive(session_, powered_at_, lines_, heartbeat_next_, ranges_next_, power_next_, drive_, driven_at_, readings_,
          received_, no_echoes_);
}

}  // namespace cosiva::virtual_side
