#include "cosiva/wire/own/crossing_status.h"

#include <gtest/gtest.h>

#include <string>

namespace cosiva::wire {
namespace {

CrossingStatus sample() {
  CrossingStatus status;
  status.header_id = 7;
  status.timestamp = virtual_epoch;
  status.map_id = "lacet4";
  status.unit = {"CoSiVA.unit", "X1"};
  status.crossing = "X1";
  status.centre = {0.15, -0.15};
  status.holders = {{{"CoSiVA", "AIV1"}, 100}};
  status.waiting = {{{"CoSiVA", "AIV2"}, 50}, {{"CoSiVA", "AIV3"}, 4'000'000'000U}};
  return status;
}

TEST(CrossingStatus, is_read_as_it_was_written) {
  EXPECT_EQ(*crossing_status_from_json(to_json(sample())), sample());
  CrossingStatus last = sample();
  last.online = false;
  last.holders.clear();
  last.waiting.clear();
  EXPECT_EQ(*crossing_status_from_json(to_json(last)), last);
}

TEST(CrossingStatus, is_refused_with_the_name_of_the_bad_field) {
  const auto field_of = [](const std::string& from, const std::string& to) {
    std::string json = to_json(sample());
    const std::size_t at = json.find(from);
    EXPECT_NE(at, std::string::npos) << from;
    json.replace(at, from.size(), to);
    const auto read = crossing_status_from_json(json);
    return read ? std::string{} : read.error().location;
  };
  EXPECT_EQ(field_of(R"("serialNumber":"X1")", R"("serialNumber":"X 1")"), "serialNumber");
  EXPECT_EQ(field_of(R"("crossing":"X1")", R"("crossing":1)"), "crossing");
  EXPECT_EQ(field_of(R"("age":0.1)", R"("age":-1)"), "holders.0.age");
  EXPECT_EQ(field_of(R"("serialNumber":"AIV2")", R"("serialNumber":"")"), "waiting.0.serialNumber");
  EXPECT_EQ(field_of(R"("y":-0.15)", R"("y":1e9)"), "y");
  EXPECT_EQ(field_of(R"("online":true)", R"("online":1)"), "online");
  EXPECT_FALSE(crossing_status_from_json("{"));
  CrossingStatus many = sample();
  many.holders.resize(CrossingStatus::vehicles_max + 1, many.holders.front());
  EXPECT_EQ(crossing_status_from_json(to_json(many)).error().location, "holders");
}

TEST(UnitSwitch, is_read_as_it_was_written_and_refused_with_the_name_of_the_bad_field) {
  EXPECT_EQ(*unit_switch_from_json(to_json(UnitSwitch{"X1", true})), (UnitSwitch{"X1", true}));
  EXPECT_EQ(unit_switch_from_json(R"({"crossing":"X1"})").error().location, "on");
  EXPECT_EQ(unit_switch_from_json(R"({"crossing":2,"on":true})").error().location, "crossing");
}

}  // namespace
}  // namespace cosiva::wire
