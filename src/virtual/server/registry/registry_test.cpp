#include "cosiva/virtual/server/registry/registry.h"

#include <gtest/gtest.h>

#include <chrono>
#include <memory>
#include <set>
#include <string>

namespace cosiva::virtual_side {
namespace {

std::uint32_t number_of(Registry& registry, const std::string& manufacturer, const std::string& serial) {
  const auto index = registry.add({manufacturer, serial}, virtual_epoch);
  EXPECT_TRUE(index) << serial;
  return index ? registry[*index].identity.number() : 0;
}

TEST(Registry, finds_a_vehicle_by_its_name_and_by_each_of_its_topics) {
  Registry registry{"uagv"};
  ASSERT_TRUE(registry.add({"Acme", "A1"}, virtual_epoch));
  const auto index = registry.add({"Acme", "A2"}, virtual_epoch);
  ASSERT_TRUE(index);
  EXPECT_EQ(registry.find("Acme/A2"), index);
  std::set<VehicleTopic> found;
  for (const std::string topic :
       {"uagv/v2/Acme/A2/connection", "uagv/v2/Acme/A2/state", "uagv/v2/Acme/A2/visualization",
        "uagv/v2/Acme/A2/factsheet", "cosiva/v1/virtual_obstacles_ack/Acme/A2", "cosiva/v1/detected_obstacle/Acme/A2",
        "cosiva/v1/boards/Acme/A2"}) {
    const auto address = registry.find_topic(topic);
    ASSERT_TRUE(address) << topic;
    EXPECT_EQ(address->vehicle, *index) << topic;
    found.insert(address->topic);
  }
  EXPECT_EQ(found.size(), vehicle_topics);
}

TEST(Registry, finds_nothing_of_an_unknown_vehicle) {
  Registry registry{"uagv"};
  ASSERT_TRUE(registry.add({"Acme", "A1"}, virtual_epoch));
  EXPECT_FALSE(registry.find("Acme/A2"));
  EXPECT_FALSE(registry.find_topic("uagv/v2/Acme/A2/state"));
  EXPECT_FALSE(registry.find_topic("uagv/v2/Acme/A1/order")) << "the server's own topic";
}

TEST(Registry, takes_the_display_number_from_the_end_of_the_serial_number) {
  Registry registry{"uagv"};
  EXPECT_EQ(number_of(registry, "Acme", "AIV12"), 12U);
  EXPECT_EQ(number_of(registry, "Acme", "3-0045"), 45U);
}

TEST(Registry, gives_the_lowest_free_display_number_where_the_serial_number_has_none) {
  Registry registry{"uagv"};
  EXPECT_EQ(number_of(registry, "Acme", "AIV1"), 1U);
  EXPECT_EQ(number_of(registry, "Acme", "one"), 2U);
  EXPECT_EQ(number_of(registry, "Acme", "AIV0"), 3U) << "0 is no display number";
  EXPECT_EQ(number_of(registry, "Other", "AIV1"), 4U) << "1 is taken";
}

TEST(Registry, accepts_a_limited_number_of_vehicles) {
  for (const std::size_t vehicles_max : {std::size_t{1}, std::size_t{256}, Registry::vehicles_max_default}) {
    Registry registry{"uagv", vehicles_max};
    for (std::size_t i = 0; i < vehicles_max; ++i)
      ASSERT_TRUE(registry.add({"Acme", "A" + std::to_string(i)}, virtual_epoch)) << i;
    EXPECT_TRUE(registry.full());
    EXPECT_FALSE(registry.add({"Acme", "more"}, virtual_epoch));
    EXPECT_EQ(registry.size(), vehicles_max);
    EXPECT_FALSE(registry.find("Acme/more"));
  }
  EXPECT_EQ(Registry::vehicles_max_default, 2'000U);
}

TEST(Registry, gives_the_index_of_a_removed_entry_to_the_next_vehicle_and_keeps_all_others) {
  Registry registry{"uagv", 3};
  for (const char* serial : {"A1", "A2", "A3"}) ASSERT_TRUE(registry.add({"Acme", serial}, virtual_epoch));
  registry[1].on_retired(virtual_epoch);
  registry.remove(1);
  EXPECT_TRUE(registry.vacant(1));
  EXPECT_EQ(registry.known(), 2U);
  EXPECT_FALSE(registry.find("Acme/A2"));
  EXPECT_FALSE(registry.find_topic("uagv/v2/Acme/A2/state"));
  EXPECT_FALSE(registry.find_topic("cosiva/v1/boards/Acme/A2"));
  EXPECT_EQ(registry.find("Acme/A3"), VehicleIndex{2});
  EXPECT_EQ(registry.add({"Other", "B2"}, virtual_epoch), VehicleIndex{1});
  EXPECT_EQ(registry[1].name(), "Other/B2");
  EXPECT_FALSE(registry[1].retired());
  EXPECT_EQ(registry[1].identity.number(), 2U) << "the number is free again";
  EXPECT_EQ(registry.find_topic("uagv/v2/Other/B2/state")->vehicle, VehicleIndex{1});
  EXPECT_TRUE(registry.full());
}

TEST(Registry, offers_for_removal_the_entry_without_a_state_that_sent_nothing_for_the_longest_time) {
  Registry registry{"uagv"};
  for (const char* serial : {"A1", "A2", "A3", "A4"}) ASSERT_TRUE(registry.add({"Acme", serial}, virtual_epoch));
  registry[0].twin_link.on_present();
  registry[1].reported_state.on_state(std::make_shared<const wire::State>(), true);
  registry[2].membership.on_message(virtual_epoch + std::chrono::seconds{2});
  registry[3].membership.on_message(virtual_epoch + std::chrono::seconds{1});
  EXPECT_EQ(registry.removable(), VehicleIndex{3});
  registry[3].on_retired(virtual_epoch + std::chrono::seconds{3});
  registry.remove(3);
  EXPECT_EQ(registry.removable(), VehicleIndex{2});
  registry[2].twin_link.on_present();
  EXPECT_EQ(registry.removable(), std::nullopt) << "vehicles are never removed";
}

TEST(Registry, refuses_to_remove_a_vehicle_that_is_not_retired_or_an_entry_twice) {
  Registry registry{"uagv"};
  ASSERT_TRUE(registry.add({"Acme", "A1"}, virtual_epoch));
  EXPECT_DEATH(registry.remove(0), "retired");
  registry[0].on_retired(virtual_epoch);
  registry.remove(0);
  EXPECT_DEATH(registry.remove(0), "vacant");
}

TEST(Registry, refuses_to_register_a_vehicle_twice) {
  Registry registry{"uagv"};
  ASSERT_TRUE(registry.add({"Acme", "A1"}, virtual_epoch));
  EXPECT_DEATH(registry.add({"Acme", "A1"}, virtual_epoch), "is_new");
}

TEST(Registry, takes_at_most_the_last_six_digits) {
  Registry registry{"uagv"};
  EXPECT_EQ(number_of(registry, "Acme", "A123456"), 123'456U);
  EXPECT_EQ(number_of(registry, "Acme", "A1234567"), 234'567U);
}

TEST(Registry, takes_every_digit_of_a_serial_number_that_has_nothing_else) {
  Registry registry{"uagv"};
  EXPECT_EQ(number_of(registry, "Acme", "7"), 7U);
  EXPECT_EQ(number_of(registry, "Acme", "190"), 190U);
  EXPECT_EQ(number_of(registry, "Acme", "099"), 99U);
}

TEST(Registry, takes_no_digits_from_within_the_serial_number) {
  Registry registry{"uagv"};
  EXPECT_EQ(number_of(registry, "Acme", "A7B"), 1U);
  EXPECT_EQ(number_of(registry, "Acme", "A7:"), 2U) << "':' follows '9'";
  EXPECT_EQ(number_of(registry, "Acme", "A7."), 3U);
  EXPECT_EQ(number_of(registry, "Acme", "A7:8"), 8U);
  EXPECT_EQ(number_of(registry, "Acme", ""), 4U);
}

TEST(Registry, gives_a_display_number_in_a_gap) {
  Registry registry{"uagv"};
  EXPECT_EQ(number_of(registry, "Acme", "A2"), 2U);
  EXPECT_EQ(number_of(registry, "Acme", "one"), 1U);
  EXPECT_EQ(number_of(registry, "Acme", "three"), 3U);
}

TEST(Registry, numbers_the_vehicles_in_the_order_of_arrival) {
  Registry registry{"plant"};
  EXPECT_EQ(registry.add({"Acme", "A1"}, virtual_epoch), 0U);
  EXPECT_EQ(registry.add({"Acme", "A2"}, virtual_epoch + std::chrono::seconds{1}), 1U);
  EXPECT_EQ(registry[1].name(), "Acme/A2");
  EXPECT_EQ(registry[1].membership.first_received(), virtual_epoch + std::chrono::seconds{1});
  EXPECT_EQ(registry.find("Acme/A1"), 0U);
  EXPECT_TRUE(registry.find_topic("plant/v2/Acme/A1/state")) << "below the interface's name";
  EXPECT_FALSE(registry.find_topic("uagv/v2/Acme/A1/state"));
  EXPECT_EQ(registry.find_topic("plant/v2/Acme/A2/visualization")->topic, VehicleTopic::visualization);
  EXPECT_EQ(registry.find_topic("cosiva/v1/boards/Acme/A1")->topic, VehicleTopic::boards);
}

}  // namespace
}  // namespace cosiva::virtual_side
