#include "cosiva/physical/boards/boards.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <array>

#include "cosiva/wire/module_link/module_link.h"

namespace cosiva::physical {
namespace {

using namespace std::chrono_literals;
using ::testing::ElementsAre;
using ::testing::IsEmpty;
using ::testing::SizeIs;
using wire::module_link::Decoder;
using wire::module_link::encode;

constexpr SimTime start = virtual_epoch;

/// The other end of a board's link.
struct Listener {
  Decoder decoder;
  std::vector<wire::BoardMessage> received;

  void receive(const std::string& bytes) { decoder.feed(bytes, received); }
  template <typename T>
  [[nodiscard]] std::vector<T> all() const {
    std::vector<T> found;
    for (const auto& message : received) {
      if (const T* one = std::get_if<T>(&message)) found.push_back(*one);
    }
    return found;
  }
};

/// Runs a PRAV, the board with the fewest messages, over [from, to) in ticks of 10 ms.
void run(PravBoard& board, Listener& listener, SimTime from, SimTime to) {
  for (SimTime now = from; now < to; now += 10ms) {
    std::string out;
    board.tick(now, out);
    listener.receive(out);
  }
}

TEST(Board, sends_hello_first_when_the_other_side_connects) {
  PravBoard board;
  board.power_up(start, 77);
  board.link().connect(true);
  Listener listener;
  listener.receive("half a frame of the past");
  run(board, listener, start, start + 50ms);
  ASSERT_THAT(listener.received, SizeIs(2));
  const auto& hello = std::get<wire::Hello>(listener.received[0]);
  EXPECT_EQ(hello.board, wire::Board::PRAV);
  EXPECT_EQ(hello.protocol_version, wire::module_link::version);
  EXPECT_EQ(hello.session, 77U);
  EXPECT_EQ(std::get<wire::Heartbeat>(listener.received[1]).uptime_ms, 0U);
}

TEST(Board, sends_nothing_while_its_cable_is_unplugged) {
  PravBoard board;
  board.power_up(start, 77);
  Listener listener;
  run(board, listener, start, start + 1s);
  EXPECT_THAT(listener.received, IsEmpty());
}

TEST(Board, keeps_its_session_and_clock_over_a_reconnection) {
  PravBoard board;
  board.power_up(start, 77);
  board.link().connect(true);
  Listener first;
  run(board, first, start, start + 1s);
  board.link().connect(false);
  Listener second;
  run(board, second, start + 1s, start + 2s);
  EXPECT_THAT(second.received, IsEmpty());
  board.link().connect(true);
  run(board, second, start + 2s, start + 3s);
  EXPECT_THAT(second.all<wire::Hello>(), ElementsAre(first.all<wire::Hello>().front()));
  EXPECT_EQ(second.all<wire::Heartbeat>().front().uptime_ms, 2000U);
}

TEST(Board, takes_another_session_when_powered_again) {
  PravBoard board;
  board.power_up(start, 77);
  board.power_up(start + 1s, 78);
  board.link().connect(true);
  Listener listener;
  run(board, listener, start + 1s, start + 1s + 10ms);
  EXPECT_EQ(listener.all<wire::Hello>().front().session, 78U);
}

TEST(Board, sends_its_own_hello_in_response_to_a_hello) {
  PravBoard board;
  board.power_up(start, 77);
  board.link().connect(true);
  Listener listener;
  run(board, listener, start, start + 10ms);
  listener.received.clear();
  board.on_bytes(start + 10ms, encode(wire::Hello{wire::Board::PRAV, 1, 0, 0}, 0));
  run(board, listener, start + 10ms, start + 30ms);
  EXPECT_THAT(listener.all<wire::Hello>(), SizeIs(1));
}

TEST(Board, sends_ten_heartbeats_a_second_and_reports_damaged_frames) {
  PravBoard board;
  board.power_up(start, 77);
  board.link().connect(true);
  Listener listener;
  run(board, listener, start, start + 500ms);
  std::string damaged = encode(wire::Heartbeat{}, 0);
  damaged[3] = static_cast<char>(damaged[3] ^ 0x40);
  board.on_bytes(start + 500ms, damaged + encode(wire::Heartbeat{}, 1) + encode(wire::Heartbeat{}, 4));
  run(board, listener, start + 500ms, start + 1s);
  const auto heartbeats = listener.all<wire::Heartbeat>();
  ASSERT_THAT(heartbeats, SizeIs(10));
  EXPECT_EQ(heartbeats[4].frames_bad, 0);
  EXPECT_EQ(heartbeats[5].frames_bad, 1);
  EXPECT_EQ(heartbeats[5].frames_missed, 2);
  EXPECT_EQ(heartbeats[9].uptime_ms, 900U);
}

TEST(Every, does_not_catch_up_in_a_burst) {
  Every every{100ms};
  every.start(start);
  EXPECT_TRUE(every.take(start + 950ms));
  EXPECT_FALSE(every.take(start + 960ms));
  EXPECT_FALSE(every.take(start + 1040ms));
  EXPECT_TRUE(every.take(start + 1050ms));
}

TEST(Pils, reports_odometry_fifty_times_a_second) {
  PilsBoard board;
  board.power_up(start, 1, 0ms);
  board.link().connect(true);
  Listener listener;
  for (SimTime now = start; now < start + 1s; now += 10ms) {
    std::string out;
    board.tick(now, {1.2345678, -0.25, 0.0013, false}, out);
    listener.receive(out);
  }
  const auto odometry = listener.all<wire::Odometry>();
  ASSERT_THAT(odometry, SizeIs(50));
  EXPECT_EQ(odometry[3], (wire::Odometry{60, 1'234'568, -250, 13, false}));
}

TEST(Pils, reports_the_end_of_its_scale_for_values_beyond_it) {
  PilsBoard board;
  board.power_up(start, 1, 0ms);
  board.link().connect(true);
  Listener listener;
  std::string out;
  board.tick(start, {0.0, -40.0, 5.0, true}, out);
  listener.receive(out);
  const auto odometry = listener.all<wire::Odometry>().front();
  EXPECT_EQ(odometry.speed_mmps, -32768);
  EXPECT_EQ(odometry.line_offset_01mm, 32767);
  EXPECT_TRUE(odometry.line_lost);
}

TEST(Pils, drives_for_300_ms_after_the_last_valid_command_and_no_longer) {
  PilsBoard board;
  board.power_up(start, 1, 0ms);
  EXPECT_EQ(board.drive(start, 0.0), std::nullopt);
  const wire::Drive drive{500, 800, 1000, 0};
  board.on_bytes(start, encode(drive, 0));
  EXPECT_EQ(board.drive(start, 0.0), drive);
  std::string damaged = encode(drive, 1);
  damaged[4] = static_cast<char>(damaged[4] ^ 1);
  board.on_bytes(start + 200ms, damaged);                       // not valid
  board.on_bytes(start + 200ms, encode(wire::Heartbeat{}, 2));  // alive, but no command
  EXPECT_TRUE(board.driven(start + 300ms));
  EXPECT_EQ(board.drive(start + 300ms, 0.15), drive);
  EXPECT_FALSE(board.driven(start + 301ms));
  EXPECT_EQ(board.drive(start + 301ms, 0.15), std::nullopt);
}

TEST(Pils, lets_the_motors_run_no_faster_than_they_can_stop_within_the_room_of_the_last_drive) {
  PilsBoard board;
  board.power_up(start, 1, 0ms);
  const wire::Drive drive{500, 800, 600, 0, false, std::nullopt, 200};
  board.on_bytes(start, encode(drive, 0));
  EXPECT_EQ(board.drive(start, 7.0), drive) << "0.5 m/s stop within 0.125 m, and 0.025 m of lag";
  EXPECT_EQ(board.drive(start + 10ms, 7.049), drive);
  const auto limited = board.drive(start + 20ms, 7.1);
  ASSERT_TRUE(limited);
  // v²/2 + 0.05·v = 0.1
  EXPECT_EQ(limited->speed_mmps, 400);
  EXPECT_EQ(limited->braking_mmps2, 1000) << "harder than commanded";
  EXPECT_EQ(board.drive(start + 30ms, 7.2)->speed_mmps, 0);
  EXPECT_EQ(board.drive(start + 30ms, 7.3)->speed_mmps, 0) << "beyond it";
  board.on_bytes(start + 40ms, encode(drive, 1));
  EXPECT_EQ(board.drive(start + 40ms, 7.3), drive) << "the next Drive counts from where it arrives";
}

TEST(Pils, stops_within_the_room_of_a_drive_backwards_as_well) {
  PilsBoard board;
  board.power_up(start, 1, 0ms);
  const wire::Drive drive{-500, 800, 600, 0, false, std::nullopt, 200};
  board.on_bytes(start, encode(drive, 0));
  EXPECT_EQ(board.drive(start, -7.0), drive);
  EXPECT_EQ(board.drive(start + 20ms, -7.1)->speed_mmps, -400) << "v²/2 + 0.05·v = 0.1";
  EXPECT_EQ(board.drive(start + 30ms, -7.2)->speed_mmps, 0);
}

TEST(Prav, sends_a_tag_with_its_age_once_the_reader_has_it) {
  PravBoard board;
  board.power_up(start, 1);
  board.link().connect(true);
  Listener listener;
  board.on_tag(start + 13ms, 42);
  run(board, listener, start, start + 100ms);
  EXPECT_THAT(listener.all<wire::TagRead>(), ElementsAre(wire::TagRead{20, 42, 7}));
}

TEST(Prav, drops_a_tag_that_could_not_be_sent) {
  PravBoard board;
  board.power_up(start, 1);
  Listener listener;
  board.on_tag(start, 42);
  run(board, listener, start, start + 100ms);
  board.link().connect(true);
  run(board, listener, start + 100ms, start + 200ms);
  EXPECT_THAT(listener.all<wire::TagRead>(), IsEmpty());
}

TEST(Prav, shows_the_last_text) {
  PravBoard board;
  board.power_up(start, 1);
  board.on_bytes(start, encode(wire::Display{"AIV 1"}, 0) + encode(wire::Display{"0.5 m/s"}, 1));
  EXPECT_EQ(board.display(), "0.5 m/s");
}

TEST(Dobs, sends_the_bearings_of_the_sensor_at_the_rear_while_that_end_leads) {
  DobsBoard board;
  board.power_up(start, 1, 0ms);
  board.link().connect(true);
  std::array<double, DobsBoard::beams> ranges;
  ranges.fill(-1.0);
  Listener listener;
  for (const bool at_rear : {false, true}) {
    board.select_rear(at_rear);
    std::string out;
    board.tick(start + (at_rear ? 60ms : 0ms), ranges, out);
    listener.receive(out);
  }
  const auto scans = listener.all<wire::Ranges>();
  ASSERT_EQ(scans.size(), 2U);
  EXPECT_EQ(scans[0].first_bearing_crad, -84);
  EXPECT_EQ(scans[1].first_bearing_crad, -84 + 314) << "its centre beam, the seventh, points at π";
}

TEST(Dobs, sends_its_fan_every_60_ms) {
  DobsBoard board;
  board.power_up(start, 1, 20ms);
  board.link().connect(true);
  Listener listener;
  std::array<double, DobsBoard::beams> ranges;
  ranges.fill(-1.0);
  ranges[6] = 0.3504;
  int scans = 0;
  for (SimTime now = start; now < start + 620ms; now += 10ms) {
    std::string out;
    scans += board.wants_scan(now) ? 1 : 0;
    board.tick(now, ranges, out);
    listener.receive(out);
  }
  const auto sent = listener.all<wire::Ranges>();
  EXPECT_EQ(scans, 10);
  ASSERT_THAT(sent, SizeIs(10));
  EXPECT_EQ(sent[1].board_ms, 80U);
  EXPECT_EQ(sent[1].first_bearing_crad, -84);
  EXPECT_EQ(sent[1].beam_width_crad, 14);
  ASSERT_THAT(sent[1].range_mm, SizeIs(13));
  EXPECT_EQ(sent[1].range_mm[6], 350);
  EXPECT_EQ(sent[1].range_mm[5], wire::no_echo);
}

TEST(Rali, reports_twice_a_second_and_never_a_charge_beyond_full) {
  RaliBoard board;
  board.power_up(start, 1, 0ms);
  board.link().connect(true);
  Listener listener;
  for (SimTime now = start; now < start + 2s; now += 10ms) {
    std::string out;
    board.tick(now, {7.4124, 0.4305, 22.54, 1.2}, out);
    listener.receive(out);
  }
  const auto power = listener.all<wire::Power>();
  ASSERT_THAT(power, SizeIs(4));
  EXPECT_EQ(power[0], (wire::Power{7412, 430, 225, 1000}));
}

TEST(Rali, reports_finer_charge_from_a_gauge_that_states_its_uncertainty) {
  RaliBoard board;
  board.power_up(start, 1, 0ms);
  board.link().connect(true);
  Listener listener;
  std::string out;
  for (SimTime now = start; now < start + 600ms; now += 10ms) board.tick(now, {7.4, 0.4, 22.5, 0.871234, 0.0135}, out);
  listener.receive(out);
  ASSERT_THAT(listener.all<wire::Power>(), Not(IsEmpty()));
  EXPECT_EQ(listener.all<wire::Power>()[0], (wire::Power{7400, 400, 225, 871, wire::Power::Gauge{871'234, 135}}));
}

/// Ticks a board that passes bytes and one that passes values, both connected and commanded alike, and expects the
/// same messages of both.
template <typename Board>
void expect_same_as_values(wire::Board which, const std::vector<wire::BoardMessage>& commands, auto tick) {
  Board with_bytes;
  Board with_values;
  for (Board* board : {&with_bytes, &with_values}) {
    board->power_up(start, 77);
    board->link().connect(true);
  }
  Listener of_bytes;
  std::vector<wire::BoardMessage> of_values;
  wire::FrameBatch batch{1};
  wire::BoardFrames sent{1};
  for (int n = 0; n < 100; ++n) {
    const SimTime now = start + n * 10ms;
    std::string out;
    wire::Effects effects;
    tick(with_bytes, now, BoardOutput{out});
    tick(with_values, now, BoardOutput{batch});
    batch.flush("1/PILS", effects);
    of_bytes.receive(out);
    for (const wire::Effect& effect : effects) {
      for (const auto& frame :
           dynamic_cast<const wire::BoardFrames&>(*std::get<wire::SendBytes>(effect).typed).frames())
        of_values.push_back(frame.message);
    }
    const wire::BoardMessage& command = commands[static_cast<std::size_t>(n) % commands.size()];
    const auto sequence = static_cast<std::uint8_t>(n + n / 30);  // some frames are missing
    with_bytes.on_bytes(now, encode(command, sequence));
    sent.clear();
    sent.add(which, sequence, command);
    with_values.on_frame(now, sent.frames().front());
  }
  EXPECT_THAT(of_values, ::testing::ElementsAreArray(of_bytes.received));
  EXPECT_GT(of_values.size(), 10U);
}

struct PilsInPhase : PilsBoard {
  void power_up(SimTime now, std::uint32_t session) { PilsBoard::power_up(now, session, 0ms); }
};

TEST(Board, sends_and_counts_the_same_whether_frames_pass_as_bytes_or_as_values) {
  const std::vector<wire::BoardMessage> commands{wire::Heartbeat{}, wire::Drive{300, 500, 800, 0},
                                                 wire::Hello{wire::Board::PILS, 1, 0, 0}};
  expect_same_as_values<PilsInPhase>(wire::Board::PILS, commands, [](PilsBoard& board, SimTime now, BoardOutput out) {
    const auto drive = board.drive(now, 1.0);  // shows in what the board reports
    board.tick(now, {1.0, drive ? drive->speed_mmps * 1e-3 : 0.0, 0.0, false}, out);
  });
  expect_same_as_values<PravBoard>(wire::Board::PRAV, {wire::Display{"AIV1"}, wire::Heartbeat{}},
                                   [](PravBoard& board, SimTime now, BoardOutput out) {
                                     if (!board.display().empty()) board.on_tag(now + 13ms, 5);
                                     board.tick(now, out);
                                   });
}

TEST(Board, has_nothing_to_do_before_the_time_that_it_states) {
  PravBoard board;
  board.power_up(start, 77);
  board.link().connect(true);
  board.on_tag(start + 37ms, 9);
  EXPECT_LE(board.next_due(), start) << "its Hello";
  std::size_t spoken = 0;
  for (SimTime now = start; now < start + 1s; now += 1ms) {
    const bool due = board.next_due() <= now;
    std::string out;
    board.tick(now, out);
    EXPECT_EQ(out.empty(), !due) << to_seconds(now - start);
    if (!out.empty()) ++spoken;
  }
  EXPECT_EQ(spoken, 11U) << "ten heartbeats, the first with the Hello, and a tag";
  board.on_bytes(start + 1s, encode(wire::Hello{wire::Board::PRAV, 1, 0, 0}, 0));
  EXPECT_LE(board.next_due(), start) << "requested";
  board.link().connect(false);
  EXPECT_EQ(board.next_due(), start + 1s) << "unplugged: only the heartbeats' timer goes on";
}

}  // namespace
}  // namespace cosiva::physical
