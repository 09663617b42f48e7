#include "cosiva/aiv/order/load_bay.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace cosiva::aiv {
namespace {

using testing::ElementsAre;
using testing::IsEmpty;
using wire::Load;

wire::Action with(std::vector<wire::Parameter> parameters) {
  return {"any", "1", "", wire::BlockingType::none, std::move(parameters)};
}
wire::Parameter text(std::string key, std::string value) { return {std::move(key), std::move(value)}; }

TEST(LoadBay, puts_a_load_on_the_device_that_the_pick_names_and_else_on_the_first_free_one) {
  LoadBay bay{{"front", "centre", "back"}};
  EXPECT_EQ(bay.pick(with({text("loadId", "B"), text("lhd", "back")})), (Load{"B", "", "back", {}}));
  EXPECT_EQ(bay.pick(with({text("loadId", "F"), text("loadType", "EPAL"), {"weight", 8.5}})),
            (Load{"F", "EPAL", "front", 8.5}));
  EXPECT_EQ(bay.pick(with({text("lhd", "")})), (Load{"", "", "centre", {}}));
  EXPECT_THAT(bay.loads(),
              ElementsAre(Load{"F", "EPAL", "front", 8.5}, Load{"", "", "centre", {}}, Load{"B", "", "back", {}}));
}

TEST(LoadBay, refuses_a_load_where_the_device_or_every_device_is_occupied) {
  LoadBay bay{{"front", "back"}};
  ASSERT_TRUE(bay.pick(with({})));
  const auto same = bay.pick(with({text("lhd", "front")}));
  ASSERT_FALSE(same);
  EXPECT_EQ(same.error().message, "load position 'front' is occupied");
  ASSERT_TRUE(bay.pick(with({})));
  const auto third = bay.pick(with({}));
  ASSERT_FALSE(third);
  EXPECT_EQ(third.error().message, "the vehicle is loaded to its capacity");
  EXPECT_EQ(bay.loads().size(), 2U);
}

TEST(LoadBay, drops_the_load_that_the_parameters_agree_with) {
  LoadBay bay{{"front", "back"}};
  ASSERT_TRUE(bay.pick(with({text("loadId", "L1"), text("loadType", "EPAL")})));
  ASSERT_TRUE(bay.pick(with({text("loadId", "L2"), text("loadType", "INDU")})));
  for (const auto& other : {text("loadId", "L3"), text("loadType", "XLT"), text("lhd", "centre")}) {
    const auto refused = bay.drop(with({other}));
    ASSERT_FALSE(refused) << other.key;
    EXPECT_EQ(refused.error().message, "the vehicle carries no such load");
  }
  EXPECT_FALSE(bay.drop(with({text("loadId", "L1"), text("lhd", "back")}))) << "all must agree";
  EXPECT_EQ(bay.drop(with({text("loadType", "INDU")})), (Load{"L2", "INDU", "back", {}}));
  EXPECT_EQ(bay.drop(with({})), (Load{"L1", "EPAL", "front", {}}));
  const auto empty = bay.drop(with({}));
  ASSERT_FALSE(empty);
  EXPECT_EQ(empty.error().message, "the vehicle carries no load");
}

TEST(LoadBay, restores_loads_of_the_devices_that_the_vehicle_has) {
  LoadBay bay{{"front", "back"}};
  bay.restore({{"L1", "", "back", {}}, {"L2", "", "back", {}}, {"L3", "", "trailer", {}}, {"L4", "", "front", {}}});
  EXPECT_THAT(bay.loads(), ElementsAre(Load{"L4", "", "front", {}}, Load{"L1", "", "back", {}}));
  bay.restore({});
  EXPECT_THAT(bay.loads(), IsEmpty());
}

}  // namespace
}  // namespace cosiva::aiv
