#include "cosiva/aiv/onboard/boards_link.h"

#include <utility>

#include "cosiva/base/archive.h"
#include "cosiva/base/expect.h"

namespace cosiva::aiv {
namespace {

constexpr SimDuration heartbeat_period = std::chrono::milliseconds{100};

}  // namespace

BoardsLink::BoardsLink(std::uint32_t vehicle_number, bool as_values, bool rali)
    : boards_(wire::all_boards.begin(), wire::all_boards.end()), heartbeat_timer_{heartbeat_period} {
  if (!rali) std::erase(boards_, wire::Board::RALI);
  if (as_values) batch_.emplace(vehicle_number);
  for (const wire::Board board : wire::all_boards) link(board).port = wire::port_name(vehicle_number, board);
}

std::optional<wire::Board> BoardsLink::board_of(std::string_view port) const {
  for (const wire::Board board : boards_) {
    if (link(board).port == port) return board;
  }
  return std::nullopt;
}

std::vector<std::string> BoardsLink::ports() const {
  std::vector<std::string> names;
  for (const wire::Board board : boards_) names.push_back(link(board).port);
  return names;
}

void BoardsLink::on_port(wire::Board board, bool up) {
  Link& of = link(board);
  of.health = {};
  of.health.connected = up;
  of.decoder.restart();
}

const std::vector<wire::BoardMessage>& BoardsLink::on_bytes(wire::Board board, std::string_view bytes) {
  Link& of = link(board);
  of.health.connected = true;  // a board that sends is connected, whatever the shell reported
  received_.clear();
  of.decoder.feed(bytes, received_);
  of.frames_good += received_.size();
  for (const wire::BoardMessage& message : received_) take(of, message);
  return received_;
}

void BoardsLink::on_frames(std::span<const wire::BoardFrames::Frame> frames) {
  COSIVA_EXPECT(!frames.empty() && frames.front().board == frames.back().board);
  Link& of = link(frames.front().board);
  of.health.connected = true;
  of.frames_good += frames.size();
  for (const wire::BoardFrames::Frame& frame : frames) {
    of.decoder.count(frame.sequence, frame.message);
    take(of, frame.message);
  }
}

void BoardsLink::take(Link& of, const wire::BoardMessage& message) {
  if (const auto* hello = std::get_if<wire::Hello>(&message)) {
    if (of.health.hello && of.health.hello->session != hello->session) restarted_ = hello->board;
    of.health.hello = *hello;
  }
  if (const auto* pils = std::get_if<wire::PilsParts>(&message)) pils_ = *pils;
  if (const auto* result = std::get_if<wire::SelfTestResult>(&message))
    self_tests_.on_result(wire::all_boards[static_cast<std::size_t>(&of - links_.data())], *result);
  if (const auto* power = std::get_if<wire::Power>(&message)) power_ = *power;
  if (const auto* ranges = std::get_if<wire::Ranges>(&message)) {
    ranges_ = *ranges;
    new_ranges_ = true;
  }
  if (const auto* heartbeat = std::get_if<wire::Heartbeat>(&message)) {
    of.health.self_test = heartbeat->self_test;
    of.health.uptime_ms = heartbeat->uptime_ms;
    of.health.frames_bad = heartbeat->frames_bad;
    of.health.frames_missed = heartbeat->frames_missed;
  }
}

void BoardsLink::request_self_test(SimTime now, wire::Effects& effects) {
  const wire::SelfTestRequest request = self_tests_.begin(now, boards_);
  for (const wire::Board board : boards_) send(board, request, effects);
}

BoardsLink::Frames BoardsLink::frames(wire::Board board) const {
  const Link& of = link(board);
  const auto& counters = of.decoder.counters();
  return {of.frames_good, std::uint32_t{counters.frames_bad} + of.health.frames_bad,
          std::uint32_t{counters.frames_missed} + of.health.frames_missed};
}

void BoardsLink::send(wire::Board board, const wire::BoardMessage& message, wire::Effects& effects) {
  Link& to = link(board);
  if (!to.health.connected) return;
  if (batch_) return batch_->add(board, to.encoder.next_sequence(), message);
  effects.emplace_back(wire::SendBytes{to.port, to.encoder.encode(message)});
}

void BoardsLink::flush(wire::Effects& effects) {
  if (batch_) batch_->flush(links_.front().port, effects);
}

bool BoardsLink::take_new_ranges() {
  COSIVA_EXPECT(ranges_ || !new_ranges_);
  return std::exchange(new_ranges_, false);
}

void BoardsLink::on_tick(SimTime now, wire::Effects& effects) {
  self_tests_.on_tick(now);
  if (!heartbeat_timer_.take(now)) return;
  const auto uptime_ms = static_cast<std::uint32_t>(uptime(now) / std::chrono::milliseconds{1});
  for (const wire::Board board : wire::all_boards) {
    Link& to = link(board);
    if (!to.health.connected) continue;
    const auto& counters = to.decoder.counters();
    send(board, wire::Heartbeat{uptime_ms, counters.frames_bad, counters.frames_missed, 0}, effects);
    if (!to.health.hello) send(board, wire::Hello{board, wire::module_link::version, 0, 0}, effects);
  }
}

void BoardsLink::archive(Archive& archive) {
  archive(links_, received_, started_, heartbeat_timer_, power_, ranges_, new_ranges_, pils_, restarted_, self_tests_);
}

}  // namespace cosiva::aiv
