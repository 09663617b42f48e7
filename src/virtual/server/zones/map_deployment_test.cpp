#include "cosiva/virtual/server/zones/map_deployment.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <string>
#include <vector>

#include "cosiva/virtual/server/testing/orders_fixture.h"

namespace cosiva::virtual_side {
namespace {

using namespace fixture;
using testing::Contains;
using testing::IsEmpty;
using testing::SizeIs;

/// A third-party vehicle on map "old" at 0.5 m along the south side of the oval; its factsheet lists all three actions.
class Deployment : public testing::Test {
 protected:
  Deployment() : vehicle{orders.add_at("agv-7", orders.at("south", 0.5), "Acme")} {
    maps.resize(1);
    orders.proxy(vehicle).position.on_position(orders.now + 1h, "old", {0.5, 0.0, 0.0});
    list_actions({"downloadMap", "enableMap", "initPosition"});
    list_maps({{"old", "1", "", true}});
  }
  void list_actions(const std::vector<std::string>& types) {
    wire::Factsheet factsheet;
    for (const std::string& type : types) factsheet.actions.push_back({type, "", true, false, false, {}});
    orders.proxy(vehicle).factsheet.on_factsheet(factsheet);
  }
  void list_maps(const std::vector<wire::MapInfo>& known) { orders.report_field(vehicle, &wire::State::maps, known); }
  std::vector<wire::Action> sent(const std::string& type) { return orders.actions_to(vehicle, type); }
  std::size_t sent_count() {
    return sent("downloadMap").size() + sent("enableMap").size() + sent("initPosition").size();
  }
  void step(const std::string& link = "http://example.test/zone") { maps.step(vehicle, {"oval", "2", link}); }
  void report(const wire::Action& action, wire::ActionStatus status) {
    orders.report_action(vehicle, action, status);
    step();
  }
  OrdersFixture orders;
  VehicleIndex vehicle;
  MapDeployment maps{orders.server.registry, orders.server.publisher, orders.actions};
};

TEST_F(Deployment, downloads_enables_and_initialises_one_after_the_other) {
  step();
  ASSERT_THAT(sent("downloadMap"), SizeIs(1));
  const wire::Action download = sent("downloadMap")[0];
  EXPECT_EQ(download.text("mapId"), "oval");
  EXPECT_EQ(download.text("mapVersion"), "2");
  EXPECT_EQ(download.text("mapDownloadLink"), "http://example.test/zone");
  EXPECT_EQ(download.blocking_type, wire::BlockingType::none);
  EXPECT_THAT(orders.logs(), Contains("i Acme/agv-7: is on map 'old'; requested downloadMap of 'oval'"));
  report(download, wire::ActionStatus::running);
  EXPECT_EQ(sent_count(), 1U) << "the download continues";

  report(download, wire::ActionStatus::finished);
  list_maps({{"old", "1", "", true}, {"oval", "7", "", false}});
  orders.pass(999ms);
  step();
  EXPECT_EQ(sent_count(), 1U) << "the next state may have been sent before";
  orders.pass(1ms);
  step();
  ASSERT_THAT(sent("enableMap"), SizeIs(1));
  EXPECT_EQ(sent("enableMap")[0].text("mapId"), "oval");
  EXPECT_EQ(sent("enableMap")[0].text("mapVersion"), "7") << "as the vehicle names it";

  report(sent("enableMap")[0], wire::ActionStatus::finished);
  list_maps({{"old", "1", "", true}, {"oval", "7", "", true}});
  orders.pass(1s);
  step();
  ASSERT_THAT(sent("initPosition"), SizeIs(1));
  const wire::Action position = sent("initPosition")[0];
  EXPECT_EQ(position.number("x"), 0.5);
  EXPECT_EQ(position.number("y"), 0.0);
  EXPECT_EQ(position.number("theta"), 0.0);
  EXPECT_EQ(position.text("mapId"), "oval");
  EXPECT_EQ(position.text("lastNodeId"), "");
  EXPECT_EQ(sent_count(), 3U);
}

TEST_F(Deployment, repeats_a_failed_action_after_ten_seconds) {
  step();
  report(sent("downloadMap")[0], wire::ActionStatus::failed);
  orders.pass(9999ms);
  step();
  EXPECT_EQ(sent_count(), 1U);
  orders.pass(1ms);
  step();
  EXPECT_EQ(sent_count(), 2U);
}

TEST_F(Deployment, waits_ten_seconds_for_a_response_and_ten_more_before_it_repeats_the_action) {
  step();
  orders.pass(10s);
  step();
  orders.pass(9999ms);
  step();
  EXPECT_EQ(sent_count(), 1U);
  orders.pass(1ms);
  step();
  EXPECT_EQ(sent_count(), 2U);
}

TEST_F(Deployment, begins_again_with_another_zone) {
  step();
  maps.begin();
  step();
  EXPECT_EQ(sent_count(), 2U);
}

TEST_F(Deployment, waits_until_the_vehicle_is_stopped_without_an_order_and_online) {
  orders.report_field(vehicle, &wire::State::driving, true);
  step();
  orders.report_field(vehicle, &wire::State::driving, false);
  orders.report_field(vehicle, &wire::State::node_states, {{"N1", 2, true, {}}});
  step();
  orders.report_field(vehicle, &wire::State::node_states, {});
  orders.proxy(vehicle).connection.on_offline(orders.now);
  step();
  EXPECT_EQ(sent_count(), 0U);
  orders.proxy(vehicle).connection.on_connection(wire::ConnectionState::online, orders.now);
  step();
  EXPECT_EQ(sent_count(), 1U);
}

TEST_F(Deployment, requests_only_what_the_factsheet_lists_and_the_maps_permit) {
  step("");
  EXPECT_EQ(sent_count(), 0U) << "there is no link, and the vehicle does not know the map";
  list_actions({"enableMap", "initPosition"});
  step();
  EXPECT_EQ(sent_count(), 0U) << "it cannot download";
  list_maps({});
  step();
  EXPECT_THAT(sent("initPosition"), SizeIs(1)) << "a vehicle that lists no maps may know this one";
}

TEST_F(Deployment, initialises_a_vehicle_that_cannot_enable_maps) {
  list_actions({"downloadMap", "initPosition"});
  list_maps({{"oval", "7", "", false}});
  step();
  EXPECT_THAT(sent("initPosition"), SizeIs(1));
  EXPECT_EQ(sent_count(), 1U);
}

TEST_F(Deployment, requests_nothing_from_a_vehicle_without_a_factsheet) {
  const VehicleIndex unknown = orders.add_at("agv-8", orders.at("north", 0.5), "Acme");
  maps.resize(2);
  maps.step(unknown, {"oval", "2", "http://example.test/zone"});
  for (const auto type : {"downloadMap", "enableMap", "initPosition"})
    EXPECT_THAT(orders.actions_to(unknown, type), IsEmpty()) << type;
}

TEST_F(Deployment, repeats_an_earlier_request_no_more_once_another_zone_is_in_force) {
  step();
  orders.pass(300ms);
  orders.actions.tick(orders.server.registry, true);
  ASSERT_EQ(sent_count(), 2U) << "not acknowledged within 300 ms";
  maps.begin();
  orders.pass(300ms);
  orders.actions.tick(orders.server.registry, true);
  EXPECT_EQ(sent_count(), 2U);
}

TEST_F(Deployment, begins_at_once_with_another_zone_although_an_action_has_just_failed) {
  step();
  report(sent("downloadMap")[0], wire::ActionStatus::failed);
  maps.begin();
  step();
  EXPECT_EQ(sent_count(), 2U);
}

TEST_F(Deployment, waits_ten_seconds_where_its_action_is_followed_no_longer) {
  step();
  orders.actions.forget(vehicle);
  step();
  orders.pass(9999ms);
  step();
  EXPECT_EQ(sent_count(), 1U);
  orders.pass(1ms);
  step();
  EXPECT_EQ(sent_count(), 2U);
}

TEST_F(Deployment, follows_an_action_that_continues_for_up_to_ten_seconds) {
  step();
  orders.pass(9s);
  report(sent("downloadMap")[0], wire::ActionStatus::running);
  orders.pass(999ms);
  report(sent("downloadMap")[0], wire::ActionStatus::finished);
  orders.pass(1s);
  step();
  EXPECT_EQ(sent_count(), 2U) << "finished in time: the next step after a second";
}

TEST_F(Deployment, downloads_to_a_vehicle_that_lists_no_maps_where_it_can) {
  list_maps({});
  step();
  EXPECT_THAT(sent("downloadMap"), SizeIs(1));
  EXPECT_EQ(sent_count(), 1U);
}

TEST_F(Deployment, initialises_a_vehicle_that_lists_no_maps_where_there_is_no_link) {
  list_maps({});
  step("");
  EXPECT_THAT(sent("initPosition"), SizeIs(1));
  EXPECT_EQ(sent_count(), 1U);
}

TEST_F(Deployment, requests_nothing_where_no_action_is_left) {
  list_actions({"downloadMap", "enableMap"});
  list_maps({{"oval", "2", "", true}});
  step();
  EXPECT_EQ(sent_count(), 0U);
}

TEST_F(Deployment, initialises_no_vehicle_whose_position_was_never_reported) {
  const VehicleIndex lost = orders.add("agv-9", "Acme");
  maps.resize(2);
  wire::Factsheet factsheet;
  factsheet.actions.push_back({"initPosition", "", true, false, false, {}});
  orders.proxy(lost).factsheet.on_factsheet(factsheet);
  maps.step(lost, {"oval", "2", ""});
  orders.report_field(lost, &wire::State::driving, false);
  maps.step(lost, {"oval", "2", ""});
  EXPECT_THAT(orders.actions_to(lost, "initPosition"), IsEmpty());
}

TEST_F(Deployment, follows_each_vehicle_by_itself) {
  const VehicleIndex other = orders.add_at("agv-8", orders.at("north", 0.5), "Acme");
  maps.resize(2);
  wire::Factsheet factsheet;
  factsheet.actions.push_back({"initPosition", "", true, false, false, {}});
  orders.proxy(other).factsheet.on_factsheet(factsheet);
  step();
  maps.step(other, {"oval", "2", ""});
  maps.step(other, {"oval", "2", ""});
  EXPECT_EQ(sent_count(), 1U);
  ASSERT_THAT(orders.actions_to(other, "initPosition"), SizeIs(1));
  EXPECT_NEAR(*orders.actions_to(other, "initPosition")[0].number("y"), 1.0, 1e-9) << "the north side of the oval";
}

}  // namespace
}  // namespace cosiva::virtual_side
