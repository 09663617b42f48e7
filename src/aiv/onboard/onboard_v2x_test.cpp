// V2X: the intents that the on-board program publishes, its subscriptions, and the intents that it accepts
// (docs/protocols/v2x.md).
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "cosiva/aiv/onboard/onboard_fixture.h"

namespace cosiva::aiv {
namespace {

using test::at;
using test::lacet4;
using test::OnboardFixture;
using ::testing::Contains;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using ::testing::SizeIs;

const wire::VehicleId me{"CoSiVA", "AIV1"};

struct Talking : OnboardFixture {
  explicit Talking(const Setup& setup = {}) : OnboardFixture{setup} { run(1.0); }

  wire::Intent from(const std::string& serial, zone::TrackPosition track_position) {
    wire::Intent intent;
    intent.header_id = ++published_count;
    intent.timestamp = now;
    intent.map_id = "lacet4";
    intent.vehicle = {"CoSiVA", serial};
    intent.pose = lacet4().circuit.pose_at(track_position);
    return intent;
  }
  void receive_intent(const wire::Intent& intent, bool retained = false) {
    receive(wire::v2x_topic("lacet4", wire::cell_of(position(intent.pose)), intent.vehicle), to_json(intent), retained);
  }
  /// With a vehicle nearby that publishes five times a second.
  void run_in_company(double seconds) {
    for (int i = 0; i < static_cast<int>(seconds * 5.0); ++i) {
      receive_intent(from("AIV2", at(lacet4(), "loop_se", 1.5)));
      run(0.2);
    }
  }
  [[nodiscard]] std::size_t published_in_company(double seconds) {
    run_in_company(1.0);
    const std::size_t before = intents.size();
    run_in_company(seconds);
    return intents.size() - before;
  }
  [[nodiscard]] std::size_t warnings() const {
    return static_cast<std::size_t>(
        std::ranges::count_if(logs, [](const wire::Log& line) { return line.level == 'w'; }));
  }
  std::uint32_t published_count{0};
};

TEST(OnboardV2x, subscribes_to_the_cells_around_it_as_soon_as_its_position_is_known) {
  const Talking fixture;
  EXPECT_EQ(fixture.listens, wire::v2x_filters("lacet4", wire::cell_of(position(fixture.world.pose()))));
  OnboardFixture lost{{.start = std::nullopt}};
  lost.run(3.0);
  EXPECT_THAT(lost.listens, IsEmpty());
  EXPECT_THAT(lost.intents, IsEmpty());
}

TEST(OnboardV2x, neither_publishes_nor_receives_when_it_is_switched_off) {
  Talking fixture{{.v2x = false}};
  fixture.run_in_company(3.0);
  fixture.receive("cosiva/v1/v2x/lacet4/0_0/CoSiVA/AIV2", "no JSON");
  fixture.run(1.0);
  EXPECT_THAT(fixture.listens, IsEmpty());
  EXPECT_THAT(fixture.intents, IsEmpty());
  EXPECT_EQ(fixture.warnings(), Talking{}.warnings()) << "the message was not even read";
}

TEST(OnboardV2x, publishes_once_a_second_alone_and_more_often_near_others) {
  Talking fixture;
  const std::size_t before = fixture.intents.size();
  fixture.run(5.0);
  EXPECT_EQ(fixture.intents.size() - before, 5U);
  EXPECT_EQ(fixture.published_in_company(4.0), 8U) << "the vehicle is stopped";
  fixture.server_heartbeats = true;
  fixture.order(test::order("O-1").through({"loop_se@0", "loop_se@283", "loop_se@2545"}));
  const std::size_t moving = fixture.published_in_company(3.0);
  EXPECT_GE(moving, 15U);
  EXPECT_LE(moving, 20U);
  EXPECT_THAT(fixture.undecodable, IsEmpty());
}

TEST(OnboardV2x, responds_to_a_newcomer_at_once) {
  Talking fixture;
  fixture.run(0.2);
  const std::size_t before = fixture.intents.size();
  fixture.receive_intent(fixture.from("AIV2", at(lacet4(), "loop_se", 0.5)));
  fixture.run(0.12);
  EXPECT_EQ(fixture.intents.size(), before + 1);
}

TEST(OnboardV2x, publishes_its_identity_and_position_and_counts_its_messages) {
  Talking fixture;
  fixture.run(3.0);
  ASSERT_GE(fixture.intents.size(), 3U);
  const wire::Intent& last = fixture.intents.back();
  EXPECT_EQ(last.vehicle, me);
  EXPECT_EQ(last.position->section, "loop_se");
  EXPECT_EQ(last.header_id, fixture.intents.size() - 1);
  EXPECT_TRUE(std::ranges::any_of(fixture.published, [&](const wire::Publish& publish) {
    return publish.topic == wire::v2x_topic("lacet4", wire::cell_of(position(fixture.world.pose())), me) &&
           publish.qos == 0 && !publish.retained;
  }));
}

TEST(OnboardV2x, publishes_at_once_when_it_begins_to_brake) {
  Talking fixture;
  fixture.server_heartbeats = true;
  fixture.order(test::order("O-1").through({"loop_se@0", "loop_se@283", "loop_se@2545"}));
  fixture.run_in_company(2.0);
  EXPECT_FALSE(fixture.intents.back().braking);
  fixture.act("startPause", "P");
  EXPECT_TRUE(fixture.run_until([&] { return fixture.intents.back().braking; }, 0.2));
}

TEST(OnboardV2x, counts_refused_intents_and_logs_each_kind_once) {
  Talking fixture;
  const std::size_t before = fixture.warnings();
  for (int i = 0; i < 100; ++i) {
    wire::Intent fast = fixture.from("AIV2", at(lacet4(), "loop_se", 0.5));
    fast.speed_mps = 50.0;
    fixture.receive_intent(fast);
    wire::Intent double_ganger = fixture.from("AIV1", at(lacet4(), "loop_se", 0.5));
    fixture.receive("cosiva/v1/v2x/lacet4/0_-1/CoSiVA/AIV7", to_json(double_ganger));
    fixture.receive("cosiva/v1/v2x/lacet4/0_-1/CoSiVA/AIV7", "{\"headerId\":NaN}");
    fixture.receive("cosiva/v1/v2x/nonsense", "{}");
    fixture.run(0.02);
  }
  EXPECT_EQ(fixture.warnings(), before + 3);
  EXPECT_TRUE(std::ranges::any_of(fixture.logs, [](const wire::Log& line) {
    return line.text.find("the reported pose or speed is impossible") != std::string::npos;
  }));
}

TEST(OnboardV2x, is_not_disturbed_by_its_own_messages_or_retained_ones) {
  Talking fixture;
  const std::size_t before = fixture.warnings();
  fixture.receive_intent(fixture.from("AIV1", at(lacet4(), "loop_se", 0.0)));
  fixture.receive_intent(fixture.from("AIV2", at(lacet4(), "loop_se", 0.5)), true);
  const std::size_t published_count = fixture.intents.size();
  fixture.run(5.0);
  EXPECT_EQ(fixture.warnings(), before);
  EXPECT_EQ(fixture.intents.size(), published_count + 5) << "as if alone";
}

TEST(OnboardV2x, publishes_in_another_cell_when_it_has_entered_it) {
  Talking fixture;
  fixture.server_heartbeats = true;
  const auto first = fixture.listens;
  // The south-eastern loop leads from y < 0 to the northward straight, over the border at y = 0.
  fixture.order(test::order("O-1").through({"loop_se@0", "loop_se@2545", "north@0", "north@380", "north@1120"}));
  EXPECT_TRUE(fixture.run_until([&] { return fixture.listens != first; }, 30.0));
  EXPECT_EQ(fixture.listens, wire::v2x_filters("lacet4", {0, 0}));
  fixture.run(1.1);
  EXPECT_TRUE(fixture.published.back().topic.starts_with("cosiva/v1/v2x/lacet4/0_0/") ||
              std::ranges::any_of(fixture.published, [](const wire::Publish& publish) {
                return publish.topic == "cosiva/v1/v2x/lacet4/0_0/CoSiVA/AIV1";
              }));
}

}  // namespace
}  // namespace cosiva::aiv
