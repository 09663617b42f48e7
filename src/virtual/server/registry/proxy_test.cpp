#include "cosiva/virtual/server/registry/proxy.h"

#include <gtest/gtest.h>

#include <chrono>
#include <cstdint>
#include <optional>
#include <string>

#include "cosiva/wire/messages/topics.h"

namespace cosiva::virtual_side {
namespace {

using namespace std::chrono_literals;

class RegistryOfPlant : public testing::Test {
 protected:
  std::uint32_t number_of(const std::string& serial, const std::string& manufacturer = "CoSiVA") {
    return registry[*registry.add({manufacturer, serial}, virtual_epoch)].number;
  }
  Registry registry{"plant7"};
};

TEST_F(RegistryOfPlant, gives_each_vehicle_the_number_that_its_serial_number_ends_with) {
  EXPECT_EQ(number_of("AIV12"), 12U);
  EXPECT_EQ(number_of("3"), 3U);
  EXPECT_EQ(number_of("7-040"), 40U);
  EXPECT_EQ(number_of("x9", "Acme"), 9U);
  EXPECT_EQ(number_of("AIV123456"), 123456U) << "six digits count";
  EXPECT_EQ(number_of("B9123457"), 123457U);
}

TEST_F(RegistryOfPlant, gives_the_lowest_free_number_where_the_serial_number_has_none_or_a_taken_one) {
  EXPECT_EQ(number_of("AIV2"), 2U);
  EXPECT_EQ(number_of("left"), 1U);
  EXPECT_EQ(number_of("AIV2", "Acme"), 3U);
  EXPECT_EQ(number_of("AIV0"), 4U);
  EXPECT_EQ(number_of("AIV5x"), 5U) << "digits at the end only; five is the lowest free one";
}

TEST_F(RegistryOfPlant, finds_a_vehicle_by_its_name_and_by_each_of_its_topics) {
  const wire::VehicleId id{"CoSiVA", "AIV1"};
  const VehicleIndex first = *registry.add({"Acme", "agv-1"}, virtual_epoch);
  const VehicleIndex vehicle = *registry.add(id, virtual_epoch + 3s);
  EXPECT_NE(first, vehicle);
  EXPECT_EQ(registry.find("CoSiVA/AIV1"), vehicle);
  EXPECT_EQ(registry.find("CoSiVA/AIV2"), std::nullopt);
  const auto finds = [&](const std::string& topic, VehicleTopic kind) {
    const auto address = registry.find_topic(topic);
    return address && address->vehicle == vehicle && address->topic == kind;
  };
  EXPECT_TRUE(finds("plant7/v2/CoSiVA/AIV1/connection", VehicleTopic::connection));
  EXPECT_TRUE(finds("plant7/v2/CoSiVA/AIV1/state", VehicleTopic::state));
  EXPECT_TRUE(finds("plant7/v2/CoSiVA/AIV1/visualization", VehicleTopic::visualization));
  EXPECT_TRUE(finds("plant7/v2/CoSiVA/AIV1/factsheet", VehicleTopic::factsheet));
  EXPECT_TRUE(finds(wire::own_topic(wire::virtual_obstacles_ack_topic_prefix, id), VehicleTopic::perceived));
  EXPECT_TRUE(finds(wire::own_topic(wire::detected_obstacle_topic_prefix, id), VehicleTopic::detected));
  EXPECT_TRUE(finds(wire::own_topic(wire::boards_topic_prefix, id), VehicleTopic::boards));
  EXPECT_FALSE(registry.find_topic("plant7/v2/CoSiVA/AIV1/order"));
  const AivProxy& proxy = registry[vehicle];
  EXPECT_EQ(proxy.order_topic, "plant7/v2/CoSiVA/AIV1/order");
  EXPECT_EQ(proxy.actions_topic, "plant7/v2/CoSiVA/AIV1/instantActions");
  EXPECT_EQ(proxy.first_received, virtual_epoch + 3s);
}

TEST_F(RegistryOfPlant, accepts_256_vehicles) {
  for (std::size_t i = 0; i < 256; ++i) EXPECT_TRUE(registry.add({"Acme", std::to_string(i)}, virtual_epoch));
  EXPECT_FALSE(registry.add({"Acme", "one-more"}, virtual_epoch));
  EXPECT_EQ(registry.size(), 256U);
}

TEST_F(RegistryOfPlant, knows_virtual_vehicles_and_cosiva_vehicles) {
  const VehicleIndex physical = *registry.add({std::string(wire::our_manufacturer), "AIV1"}, virtual_epoch);
  const VehicleIndex hosted = *registry.add({std::string(wire::virtual_manufacturer), "V1"}, virtual_epoch);
  const VehicleIndex foreign = *registry.add({"Acme", "agv-1"}, virtual_epoch);
  EXPECT_FALSE(registry[physical].augmented);
  EXPECT_TRUE(registry[hosted].augmented);
  EXPECT_TRUE(registry[physical].is_cosiva());
  EXPECT_TRUE(registry[hosted].is_cosiva());
  EXPECT_FALSE(registry[foreign].is_cosiva());
  registry[foreign].boards.emplace();
  EXPECT_TRUE(registry[foreign].is_cosiva()) << "it reports its boards, so it runs the CoSiVA program";
}

TEST_F(RegistryOfPlant, renews_a_vehicle_that_returns_but_keeps_its_name_number_and_counters) {
  const VehicleIndex vehicle = *registry.add({"CoSiVA", "AIV4"}, virtual_epoch);
  AivProxy& proxy = registry[vehicle];
  proxy.version = "2.0.0";
  proxy.retired = true;
  proxy.priority = 7;
  proxy.twin = 3;
  proxy.entity = 5;
  proxy.messages = 11;
  proxy.headers_missed = 12;
  proxy.refused = 13;
  proxy.outdated = 14;
  proxy.order_header_id = 15;
  proxy.actions_header_id = 16;
  proxy.no_orders = true;
  proxy.state.emplace();
  proxy.map_id = "oval";
  registry.renew(vehicle, virtual_epoch + 60s);
  EXPECT_EQ(proxy.name, "CoSiVA/AIV4");
  EXPECT_EQ(proxy.id, (wire::VehicleId{"CoSiVA", "AIV4"}));
  EXPECT_EQ(proxy.number, 4U);
  EXPECT_EQ(proxy.order_topic, "plant7/v2/CoSiVA/AIV4/order");
  EXPECT_EQ(proxy.actions_topic, "plant7/v2/CoSiVA/AIV4/instantActions");
  EXPECT_EQ(proxy.priority, 7);
  EXPECT_EQ(proxy.twin, 3U);
  EXPECT_EQ(proxy.entity, 5U);
  EXPECT_EQ(proxy.messages, 11U);
  EXPECT_EQ(proxy.headers_missed, 12U);
  EXPECT_EQ(proxy.refused, 13U);
  EXPECT_EQ(proxy.outdated, 14U);
  EXPECT_EQ(proxy.order_header_id, 15U);
  EXPECT_EQ(proxy.actions_header_id, 16U);
  EXPECT_EQ(proxy.first_received, virtual_epoch + 60s);
  EXPECT_TRUE(proxy.version.empty() && proxy.map_id.empty());
  EXPECT_FALSE(proxy.retired || proxy.no_orders || proxy.state.has_value());
  EXPECT_EQ(registry.find("CoSiVA/AIV4"), vehicle);
}

TEST_F(RegistryOfPlant, knows_supported_instant_actions_from_the_factsheet) {
  AivProxy& proxy = registry[*registry.add({"Acme", "agv-1"}, virtual_epoch)];
  EXPECT_EQ(proxy.supports("startPause"), std::nullopt);
  proxy.factsheet.emplace();
  proxy.factsheet->actions = {{"startPause", "", true, false, false, {}}, {"pick", "", false, true, false, {}}};
  EXPECT_EQ(proxy.supports("startPause"), true);
  EXPECT_EQ(proxy.supports("pick"), false) << "it is an action of nodes";
  EXPECT_EQ(proxy.supports("backUp"), false);
}

TEST_F(RegistryOfPlant, does_not_show_a_vehicle_for_a_second_after_its_handover) {
  AivProxy& proxy = registry[*registry.add({"CoSiVA", "AIV1"}, virtual_epoch)];
  EXPECT_FALSE(proxy.shown(virtual_epoch)) << "it has no twin yet";
  proxy.twin = 0;
  EXPECT_TRUE(proxy.here() && proxy.shown(virtual_epoch));
  proxy.handed_over = {virtual_epoch, virtual_epoch};
  EXPECT_FALSE(proxy.shown(virtual_epoch + 999ms));
  EXPECT_TRUE(proxy.shown(virtual_epoch + 1s)) << "the handover has not succeeded";
  proxy.retired = true;
  EXPECT_FALSE(proxy.here() || proxy.shown(virtual_epoch + 1s));
}

TEST(VehicleTopics, have_the_names_of_the_standard_and_of_cosiva_s_own_topics) {
  for (const auto topic :
       {VehicleTopic::connection, VehicleTopic::state, VehicleTopic::visualization, VehicleTopic::factsheet})
    EXPECT_EQ(parse_vehicle_topic(to_string(topic)), topic);
  EXPECT_EQ(to_string(VehicleTopic::state), "state");
  EXPECT_EQ(to_string(VehicleTopic::visualization), "visualization");
  EXPECT_EQ(to_string(VehicleTopic::connection), "connection");
  EXPECT_EQ(to_string(VehicleTopic::factsheet), "factsheet");
  EXPECT_EQ(to_string(VehicleTopic::perceived), "virtual_obstacles_ack");
  EXPECT_EQ(to_string(VehicleTopic::detected), "detected_obstacle");
  EXPECT_EQ(to_string(VehicleTopic::boards), "boards");
  EXPECT_EQ(parse_vehicle_topic("boards"), std::nullopt) << "not below the interface name";
  EXPECT_EQ(parse_vehicle_topic("order"), std::nullopt);
}

}  // namespace
}  // namespace cosiva::virtual_side
