#include "cosiva/wire/messages/messages.h"

#include <gtest/gtest.h>

namespace cosiva::wire {
namespace {

const Action action{"setSpeedLimit",
                    "1",
                    "",
                    BlockingType::none,
                    {{"profile", std::string("slow")},
                     {"maxSpeed", 0.3},
                     {"now", true},
                     {"zone", RawJson{"[1]"}},
                     {"profile", std::string("fast")}}};

TEST(ActionParameters, are_found_by_key_and_the_first_match_counts) {
  EXPECT_EQ(action.text("profile"), "slow");
  EXPECT_EQ(action.number("maxSpeed"), 0.3);
  EXPECT_EQ(*action.find("now"), ParameterValue{true});
  EXPECT_EQ(action.find("absent"), nullptr);
}

TEST(ActionParameters, of_another_type_are_not_converted) {
  EXPECT_EQ(action.number("profile"), std::nullopt);
  EXPECT_EQ(action.number("now"), std::nullopt);
  EXPECT_EQ(action.text("maxSpeed"), std::nullopt);
  EXPECT_EQ(action.text("zone"), std::nullopt);
  EXPECT_EQ(action.number("absent"), std::nullopt);
}

}  // namespace
}  // namespace cosiva::wire
