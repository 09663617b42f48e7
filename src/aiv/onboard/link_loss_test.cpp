// After the loss of its broker or its server a vehicle brakes, or finishes its base where it was started so: while it
// receives V2X messages of every vehicle on the base, by the direct link if there is no broker.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <string>

#include "cosiva/aiv/onboard/onboard_fixture.h"

namespace cosiva::aiv {
namespace {

using std::chrono::milliseconds;
using test::at;
using test::lacet4;
using test::OnboardFixture;
using ::testing::IsEmpty;
using ::testing::SizeIs;

/// A vehicle on a base of 2.54 m along the south-eastern loop, with a server and a direct link.
struct LinkLossFixture : OnboardFixture {
  explicit LinkLossFixture(LinkLoss link_loss = LinkLoss::finish_base)
      : OnboardFixture{{.direct = true, .link_loss = link_loss}} {
    server_heartbeats = true;
    run(0.5);
    order(test::order("O-1").through({"loop_se@0", "loop_se@283", "loop_se@2545"}));
    run(1.0);
    EXPECT_NEAR(speed_mps, 0.4, 0.01) << "the medium speed of lacet4";
  }
  /// By the direct link.
  void receive_direct(const std::string& serial, zone::TrackPosition position, const std::string& port_serial = "") {
    wire::Intent intent;
    intent.header_id = ++sent_count;
    intent.timestamp = now;
    intent.map_id = "lacet4";
    intent.vehicle = {"CoSiVA", serial};
    intent.pose = lacet4().circuit.pose_at(position);
    feed(wire::InputKind::bytes, wire::v2x_port_of({"CoSiVA", port_serial.empty() ? serial : port_serial}),
         to_json(intent));
  }
  [[nodiscard]] bool brakes() const { return last_drive().speed_mmps == 0; }
  /// @param each_ms  the period of an intent of a vehicle on the base
  [[nodiscard]] bool drives_for(double seconds, int each_ms = 0) {
    int ms = 0;
    return !run_until(
        [&] {
          ms += 10;
          if (each_ms > 0 && ms % each_ms == 0) receive_direct("AIV2", at(lacet4(), "loop_se", 2.4));
          return brakes();
        },
        seconds);
  }
  std::uint32_t sent_count{0};
};

TEST(LinkLoss, brakes_by_default) {
  LinkLossFixture vehicle{LinkLoss::brake};
  vehicle.link(false);
  EXPECT_TRUE(vehicle.drives_for(0.4, 100));
  EXPECT_FALSE(vehicle.drives_for(0.2, 100)) << "500 ms after the last message";
}

TEST(LinkLoss, of_the_broker_or_the_server_lets_a_vehicle_finish_its_base) {
  for (const bool broker : {true, false}) {
    LinkLossFixture vehicle;
    if (broker)
      vehicle.link(false);
    else
      vehicle.server_heartbeats = false;
    EXPECT_TRUE(vehicle.drives_for(1.5)) << "no other vehicle is known";
    vehicle.run(6.0);
    EXPECT_EQ(vehicle.speed_mps, 0.0);
    const auto stopped_at = vehicle.ground_truth.track_position(lacet4().circuit);
    EXPECT_EQ(lacet4().circuit.part(stopped_at.section).name, "loop_se");
    EXPECT_NEAR(stopped_at.s_m, 2.545, 0.02) << "the end of the base";
  }
}

TEST(LinkLoss, brakes_when_a_vehicle_on_the_base_becomes_unresponsive_and_continues_when_it_is_received_again) {
  LinkLossFixture vehicle;
  vehicle.link(false);
  EXPECT_TRUE(vehicle.drives_for(1.0, 100));
  const SimTime last_received = vehicle.now;
  EXPECT_FALSE(vehicle.drives_for(1.0));
  EXPECT_GE(vehicle.now - last_received, milliseconds{290});
  EXPECT_LE(vehicle.now - last_received, milliseconds{340});
  vehicle.receive_direct("AIV2", at(lacet4(), "loop_se", 2.4));
  vehicle.run(0.04);
  EXPECT_FALSE(vehicle.brakes());
}

TEST(LinkLoss, is_not_survived_by_messages_of_a_vehicle_under_a_false_name) {
  LinkLossFixture vehicle;
  vehicle.receive_direct("AIV2", at(lacet4(), "loop_se", 2.4));
  vehicle.link(false);
  const bool drives = !vehicle.run_until(
      [&] {
        vehicle.receive_direct("AIV2", at(lacet4(), "loop_se", 2.4), "AIV3");
        return vehicle.brakes();
      },
      1.0);
  EXPECT_FALSE(drives) << "AIV2 is unresponsive, whatever AIV3 sends";
}

TEST(LinkLoss, does_not_excuse_a_board_or_a_pause) {
  LinkLossFixture vehicle;
  vehicle.link(false);
  EXPECT_TRUE(vehicle.drives_for(0.8));
  vehicle.silence(wire::Board::DOBS);
  EXPECT_FALSE(vehicle.drives_for(0.8));
  LinkLossFixture paused;
  paused.act("startPause", "P");
  paused.link(false);
  paused.run(1.0);
  EXPECT_TRUE(paused.brakes());
}

TEST(LinkLoss, leaves_a_vehicle_that_publishes_by_the_direct_link_ten_times_a_second_near_others) {
  LinkLossFixture vehicle;
  vehicle.link(false);
  vehicle.direct_intents.clear();
  vehicle.intents.clear();
  EXPECT_TRUE(vehicle.drives_for(1.0, 100));
  EXPECT_GE(vehicle.direct_intents.size(), 10U);
  EXPECT_THAT(vehicle.intents, IsEmpty()) << "there is no broker";
  EXPECT_THAT(vehicle.undecodable, IsEmpty());
}

TEST(LinkLoss, of_nothing_sends_each_intent_both_ways_under_one_number) {
  LinkLossFixture vehicle;
  vehicle.direct_intents.clear();
  vehicle.intents.clear();
  vehicle.run(2.1);
  ASSERT_THAT(vehicle.intents, SizeIs(vehicle.direct_intents.size()));
  EXPECT_EQ(vehicle.intents, vehicle.direct_intents);
}

TEST(DirectLink, is_not_used_where_it_is_switched_off) {
  OnboardFixture vehicle;
  vehicle.run(1.0);
  vehicle.feed(wire::InputKind::bytes, "v2x/CoSiVA/AIV2", "no JSON");
  EXPECT_THAT(vehicle.direct_intents, IsEmpty());
  EXPECT_TRUE(std::ranges::none_of(
      vehicle.logs, [](const wire::Log& line) { return line.text.find("not used") != std::string::npos; }));
}

TEST(DirectLink, logs_a_message_that_cannot_be_read_once) {
  LinkLossFixture vehicle;
  for (int i = 0; i < 3; ++i) vehicle.feed(wire::InputKind::bytes, "v2x/CoSiVA/AIV2", "no JSON");
  EXPECT_EQ(std::ranges::count_if(
                vehicle.logs,
                [](const wire::Log& line) { return line.text.find("v2x/CoSiVA/AIV2' not used") != std::string::npos; }),
            1);
}

TEST(LinkLossOptions, are_written_and_read) {
  OnboardOptions options;
  const std::string by_default = to_json(options);
  EXPECT_EQ(by_default.find("linkLoss"), std::string::npos) << "as in earlier journals";
  EXPECT_EQ(onboard_options_from_json(by_default)->link_loss, LinkLoss::brake);
  options.link_loss = LinkLoss::finish_base;
  options.v2x_direct = true;
  const auto read = onboard_options_from_json(to_json(options));
  ASSERT_TRUE(read);
  EXPECT_EQ(read->link_loss, LinkLoss::finish_base);
  EXPECT_TRUE(read->v2x_direct);
  const auto bad = onboard_options_from_json(R"({"linkLoss":"drive-on"})");
  ASSERT_FALSE(bad);
  EXPECT_EQ(bad.error().location, "linkLoss");
}

}  // namespace
}  // namespace cosiva::aiv
