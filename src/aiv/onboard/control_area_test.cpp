// Several servers on one broker: the vehicle obeys the server of its control area.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "cosiva/aiv/onboard/onboard_fixture.h"
#include "cosiva/wire/own/control_areas.h"

namespace cosiva::aiv {
namespace {

using test::lacet4_configuration;
using test::OnboardFixture;
using ::testing::AllOf;
using ::testing::Contains;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using ::testing::Not;

const std::string owner_topic = "cosiva/v1/owner/CoSiVA/AIV1";

struct ControlAreaFixture : OnboardFixture {
  using OnboardFixture::OnboardFixture;

  void owner(const std::string& area) {
    receive(owner_topic, wire::to_json({area, 1, now, std::nullopt, std::nullopt}), true);
  }
  /// The clover under another name.
  void zone_of(const std::string& area) {
    zone::ZoneConfiguration zone = lacet4_configuration();
    zone.text.replace(zone.text.find("name = \"lacet4\""), 15, "name = \"" + area + "\"");
    receive("cosiva/v1/area/" + area + "/zone/toml", zone::to_payload(zone), true);
  }
  void heartbeat_of(const std::string& area, double seconds) {
    for (int i = 0; i < static_cast<int>(std::lround(seconds * 10.0)); ++i) {
      receive("cosiva/v1/area/" + area + "/server/heartbeat", R"({"headerId":1})");
      run(0.1);
    }
  }
  [[nodiscard]] std::string map_id() const { return state().position->map_id; }
};

TEST(ControlArea, subscribes_to_its_own_server_and_enters_its_zone_at_the_same_pose) {
  ControlAreaFixture fixture;
  fixture.run(0.5);
  EXPECT_EQ(fixture.map_id(), "lacet4");
  const Pose2 before = *fixture.core->estimated_pose();
  fixture.owner("north");
  EXPECT_THAT(fixture.listens,
              AllOf(Contains("cosiva/v1/area/north/zone/+"), Contains("cosiva/v1/area/north/server/heartbeat"),
                    Contains("cosiva/v1/area/north/server/connection")));
  fixture.zone_of("north");
  fixture.heartbeat_of("north", 0.5);
  EXPECT_EQ(fixture.map_id(), "north");
  EXPECT_LT(distance(before, *fixture.core->estimated_pose()), 0.001) << "all control areas have one frame in common";
  EXPECT_THAT(fixture.error_types(), IsEmpty());
  fixture.order(test::order("N-1").through({"loop_se@0", "loop_se@283", "loop_se@565"}));
  fixture.heartbeat_of("north", 1.5);
  EXPECT_GT(fixture.speed_mps, 0.1);
}

TEST(ControlArea, accepts_no_zone_but_its_own_server_s) {
  ControlAreaFixture fixture;
  fixture.run(0.5);
  fixture.zone_of("north");
  fixture.run(0.5);
  EXPECT_EQ(fixture.map_id(), "lacet4") << "the vehicle belongs to no area";
  fixture.owner("south");
  fixture.zone_of("north");
  zone::ZoneConfiguration plain = lacet4_configuration();
  plain.text.replace(plain.text.find("name = \"lacet4\""), 15, "name = \"plain\"");
  fixture.receive("cosiva/v1/zone/toml", zone::to_payload(plain), true);
  fixture.run(0.5);
  EXPECT_EQ(fixture.map_id(), "lacet4");
}

TEST(ControlArea, changes_servers_and_supervises_the_heartbeat_of_the_new_one_only) {
  ControlAreaFixture fixture;
  fixture.run(0.5);
  fixture.owner("north");
  fixture.zone_of("north");
  fixture.heartbeat_of("north", 0.5);
  fixture.owner("south");
  fixture.zone_of("south");
  fixture.heartbeat_of("south", 1.0);
  EXPECT_EQ(fixture.map_id(), "south");
  EXPECT_THAT(fixture.error_types(), Not(Contains("serverLost"))) << "the old server's heartbeat does not matter";
  EXPECT_THAT(fixture.listens, Not(Contains(HasSubstr("north"))));
  fixture.heartbeat_of("south", 0.5);
  fixture.heartbeat_of("north", 1.0);
  EXPECT_THAT(fixture.error_types(), Contains("serverLost"))
      << "its own server's heartbeat has stopped, whatever the other server sends";
  fixture.receive("cosiva/v1/area/north/server/connection", R"({"connectionState":"OFFLINE"})");
  fixture.run(0.2);
  EXPECT_THAT(fixture.error_types(), Contains("serverLost"));
  fixture.receive("cosiva/v1/area/south/server/connection", R"({"connectionState":"OFFLINE"})");
  fixture.run(0.2);
  EXPECT_THAT(fixture.error_types(), Not(Contains("serverLost"))) << "the server went offline cleanly";
}

TEST(ControlArea, brakes_on_the_old_zone_before_it_enters_the_new_server_s) {
  ControlAreaFixture fixture;
  fixture.run(0.5);
  fixture.order(test::order("O-1").through({"loop_se@0", "loop_se@283", "loop_se@565", "loop_se@848", "loop_se@1131"}));
  fixture.run(1.5);
  ASSERT_GT(fixture.speed_mps, 0.2);
  fixture.owner("north");
  fixture.zone_of("north");
  fixture.run(0.1);
  EXPECT_EQ(fixture.map_id(), "lacet4");
  ASSERT_TRUE(fixture.run_until([&] { return fixture.map_id() == "north"; }, 3.0));
  EXPECT_EQ(fixture.speed_mps, 0.0);
  EXPECT_THAT(fixture.state().order_id, testing::AnyOf("", "O-1"));
  EXPECT_THAT(fixture.state().node_states, IsEmpty()) << "the old server's order is over";
}

TEST(ControlArea, does_not_change_when_the_owner_cannot_be_read_and_logs_it) {
  ControlAreaFixture fixture;
  fixture.run(0.5);
  fixture.owner("north");
  fixture.receive(owner_topic, R"({"area":"so uth"})", true);
  fixture.zone_of("north");
  fixture.run(0.5);
  EXPECT_EQ(fixture.map_id(), "north");
  EXPECT_TRUE(std::ranges::any_of(fixture.logs, [](const wire::Log& line) {
    return line.text.find("the owner of this vehicle") != std::string::npos;
  }));
}

TEST(ControlArea, ends_when_the_owner_is_removed_from_the_broker) {
  ControlAreaFixture fixture;
  fixture.run(0.5);
  fixture.owner("north");
  fixture.zone_of("north");
  fixture.heartbeat_of("north", 0.5);
  fixture.receive(owner_topic, "", true);
  fixture.run(1.0);
  EXPECT_EQ(fixture.map_id(), "north") << "the map in force stays";
  EXPECT_THAT(fixture.error_types(), Not(Contains("serverLost")));
  EXPECT_THAT(fixture.listens, Not(Contains(HasSubstr("area"))));
}

TEST(ControlArea, restores_its_position_after_a_crash_before_it_reports_one_of_another_zone) {
  ControlAreaFixture fixture;
  fixture.run(0.5);
  fixture.owner("north");
  fixture.zone_of("north");
  fixture.run(0.3);
  fixture.order(test::order("N-1").through({"loop_se@0", "loop_se@283", "loop_se@565", "loop_se@848"}));
  fixture.heartbeat_of("north", 4.0);
  const Pose2 was_stopped = fixture.world.pose();
  ASSERT_GT(distance(was_stopped, test::lacet4().circuit.pose_at(test::at(test::lacet4(), "loop_se", 0.0))), 0.3);

  ControlAreaFixture::Setup setup = fixture.reborn();
  setup.zone_notified = false;
  ControlAreaFixture again{setup};
  // As the broker delivers them: in the order of its subscriptions.
  ASSERT_EQ(again.core->subscriptions().front(), owner_topic);
  again.owner("north");
  again.receive("cosiva/v1/zone/toml", zone::to_payload(lacet4_configuration()), true);
  again.run(0.3);
  EXPECT_FALSE(again.core->estimated_pose()) << "the saved position is of another zone";
  again.zone_of("north");
  again.run(0.3);
  ASSERT_TRUE(again.core->estimated_pose());
  EXPECT_LT(distance(*again.core->estimated_pose(), was_stopped), 0.02);
}

TEST(ControlArea, keeps_its_v2x_subscriptions_while_it_changes_servers) {
  ControlAreaFixture fixture;
  fixture.run(0.5);
  ASSERT_THAT(fixture.listens, Contains(HasSubstr("v2x")));
  fixture.owner("north");
  EXPECT_THAT(fixture.listens, AllOf(Contains(HasSubstr("v2x")), Contains("cosiva/v1/area/north/zone/+")));
  fixture.zone_of("north");
  fixture.run(0.5);
  EXPECT_THAT(fixture.listens, AllOf(Contains(HasSubstr("v2x")), Contains("cosiva/v1/area/north/zone/+")))
      << "the server's topics stay subscribed on the new map";
}

}  // namespace
}  // namespace cosiva::aiv
