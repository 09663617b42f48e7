#include "cosiva/virtual/server/registry/identity.h"

#include <gtest/gtest.h>

namespace cosiva::virtual_side {
namespace {

TEST(Identity, has_the_name_and_the_topics_of_its_id) {
  const Identity identity({"Acme", "A7"}, 7, "uagv");
  EXPECT_EQ(identity.name(), "Acme/A7");
  EXPECT_EQ(identity.number(), 7U);
  EXPECT_EQ(identity.order_topic(), "uagv/v2/Acme/A7/order");
  EXPECT_EQ(identity.actions_topic(), "uagv/v2/Acme/A7/instantActions");
}

TEST(Identity, of_the_virtual_manufacturer_alone_is_augmented) {
  EXPECT_TRUE(Identity({std::string(wire::virtual_manufacturer), "V1"}, 1, "uagv").augmented());
  EXPECT_FALSE(Identity({std::string(wire::our_manufacturer), "AIV1"}, 1, "uagv").augmented());
  EXPECT_FALSE(Identity({"Acme", "V1"}, 1, "uagv").augmented());
}

TEST(Identity, refuses_the_display_number_zero) { EXPECT_DEATH(Identity({"Acme", "A7"}, 0, "uagv"), "number_ > 0"); }

}  // namespace
}  // namespace cosiva::virtual_side
