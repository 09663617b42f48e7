#include "cosiva/physical/plant/vehicle_boards.h"

#include <algorithm>
#include <chrono>
#include <cstddef>

#include "cosiva/base/archive.h"
#include "cosiva/base/expect.h"

namespace cosiva::physical {
namespace {

constexpr SimDuration phase_step = std::chrono::milliseconds{10};

/// The boards of a fleet are not switched on in step: each vehicle reports in its own 10 ms of a cycle, which also
/// spreads the work over the ticks.
SimDuration phase(std::uint32_t number, std::uint32_t ticks) { return phase_step * (number % ticks); }

}  // namespace

VehicleBoards::VehicleBoards(std::uint32_t number, const VehicleEquipment& equipment, const PlantNoise& noise,
                             Random range_random)
    : number_{number},
      range_sd_m_{noise.range_sd_m},
      range_dropout_{noise.range_dropout},
      range_random_{range_random},
      pils_{equipment.line_tracking},
      rali_fitted_{equipment.rali} {
  for (const wire::Board board : wire::all_boards)
    ports_[static_cast<std::size_t>(board) - 1] = wire::port_name(number, board);
}

void VehicleBoards::power_up(SimTime now, Random sessions) {
  next_event_ = SimTime::min();
  powered_ = true;
  const auto session = [&] { return static_cast<std::uint32_t>(sessions.next() >> 32U); };
  pils_.power_up(now, session(), phase(number_, 2));
  prav_.power_up(now, session());
  dobs_.power_up(now, session(), phase(number_, 6));
  rali_.power_up(now, session(), phase(number_, 50));
}

void VehicleBoards::connect(wire::Board board, bool up) {
  next_event_ = SimTime::min();
  link(board).connect(up);
}

void VehicleBoards::set_reader_failed(bool failed) { prav_.set_reader_failed(failed); }

void VehicleBoards::on_tag(SimTime read_at, std::uint32_t number) {
  if (!powered_) return;
  next_event_ = std::min(next_event_, read_at);
  prav_.on_tag(read_at, number);
}

BoardLink& VehicleBoards::link(wire::Board board) {
  switch (board) {
    case wire::Board::PILS: return pils_.link();
    case wire::Board::PRAV: return prav_.link();
    case wire::Board::DOBS: return dobs_.link();
    case wire::Board::RALI: break;
  }
  return rali_.link();
}

void VehicleBoards::on_bytes(SimTime now, wire::Board board, std::string_view bytes) {
  if (!powered_) return;
  next_event_ = SimTime::min();  // a request may be among them
  switch (board) {
    case wire::Board::PILS: return pils_.on_bytes(now, bytes);
    case wire::Board::PRAV: return prav_.on_bytes(now, bytes);
    case wire::Board::DOBS: return dobs_.on_bytes(now, bytes);
    case wire::Board::RALI: return rali_.on_bytes(now, bytes);
  }
}

void VehicleBoards::on_frames(SimTime now, const wire::BoardFrames& frames) {
  COSIVA_EXPECT(frames.vehicle() == number_);
  if (!powered_) return;
  for (const wire::BoardFrames::Frame& frame : frames.frames()) {
    if (std::holds_alternative<wire::Hello>(frame.message) ||
        std::holds_alternative<wire::SelfTestRequest>(frame.message))
      next_event_ = SimTime::min();
    switch (frame.board) {
      case wire::Board::PILS: pils_.on_frame(now, frame); break;
      case wire::Board::PRAV: prav_.on_frame(now, frame); break;
      case wire::Board::DOBS: dobs_.on_frame(now, frame); break;
      case wire::Board::RALI: rali_.on_frame(now, frame); break;
    }
  }
}

void VehicleBoards::speak(SimTime now, const WheelReadings& wheels, const Scan& scan, const PowerReadings& power,
                          wire::Effects& effects) {
  dobs_.select_rear(wheels.rear_leads);
  COSIVA_EXPECT(due(now));
  if (batch_)
    speak_values(now, wheels, scan, power, effects);
  else
    speak_bytes(now, wheels, scan, power, effects);
  next_event_ = std::min({pils_.next_due(), prav_.next_due(), dobs_.next_due()});
  if (rali_fitted_) next_event_ = std::min(next_event_, rali_.next_due());
  COSIVA_EXPECT(next_event_ > now && out_.empty());
}

void VehicleBoards::speak_bytes(SimTime now, const WheelReadings& wheels, const Scan& scan, const PowerReadings& power,
                                wire::Effects& effects) {
  pils_.tick(now, wheels, out_);
  send(wire::Board::PILS, effects);
  prav_.tick(now, out_);
  send(wire::Board::PRAV, effects);
  tick_dobs(now, scan, out_);
  send(wire::Board::DOBS, effects);
  if (!rali_fitted_) return;
  rali_.tick(now, power, out_);
  send(wire::Board::RALI, effects);
}

void VehicleBoards::speak_values(SimTime now, const WheelReadings& wheels, const Scan& scan, const PowerReadings& power,
                                 wire::Effects& effects) {
  // After a connection or a request, and else only the boards whose time has come: most often one.
  const bool all = next_event_ == SimTime::min();
  const auto is_due = [&](const auto& board) { return all || board.next_due() <= now; };
  if (is_due(pils_)) pils_.tick(now, wheels, *batch_);
  if (is_due(prav_)) prav_.tick(now, *batch_);
  if (is_due(dobs_)) tick_dobs(now, scan, *batch_);
  if (rali_fitted_ && is_due(rali_)) rali_.tick(now, power, *batch_);
  batch_->flush(port(wire::Board::PILS), effects);
}

void VehicleBoards::tick_dobs(SimTime now, const Scan& scan, BoardOutput out) {
  if (wants_scan(now))
    dobs_.tick(now, RangeFan::measured(scan, range_sd_m_, range_dropout_, range_random_), out);
  else
    dobs_.tick(now, scan, out);
}

void VehicleBoards::send(wire::Board board, wire::Effects& effects) {
  if (out_.empty()) return;
  effects.emplace_back(wire::SendBytes{port(board), out_});
  out_.clear();  // keeps its capacity
}

void VehicleBoards::archive(Archive& archive) {
  archive(pils_.link(), prav_.link(), dobs_.link(), rali_.link());
  next_event_ = SimTime::min();
}

}  // namespace cosiva::physical
