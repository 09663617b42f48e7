#include "cosiva/virtual/server/augmented/restored_aivs.h"

#include <gtest/gtest.h>

namespace cosiva::virtual_side {
namespace {

TEST(RestoredAivs, are_found_and_removed_by_serial_number_or_name) {
  RestoredAivs restored;
  restored.add({"V1", "north", 0.3});
  restored.add({"V2", "south", 0.5});
  ASSERT_NE(restored.find("V2"), nullptr);
  EXPECT_EQ(restored.find("V2"), restored.find("CoSiVA.virtual/V2"));
  EXPECT_EQ(restored.find("V2")->section, "south");
  EXPECT_EQ(restored.find("V3"), nullptr);
  EXPECT_EQ(restored.find("CoSiVA/V2"), nullptr);
  restored.remove("CoSiVA.virtual/V2");
  EXPECT_EQ(restored.find("V2"), nullptr);
  EXPECT_NE(restored.find("V1"), nullptr);
}

TEST(RestoredAivs, wait_once_where_a_state_lists_one_twice) {
  RestoredAivs restored;
  restored.add({"V1", "north", 0.3});
  restored.add({"V1", "south", 0.5});
  ASSERT_EQ(restored.aivs().size(), 1U);
  EXPECT_EQ(restored.find("V1")->section, "north");
}

TEST(RestoredAivs, wait_no_more_once_they_are_taken) {
  RestoredAivs restored;
  restored.add({"V1", "north", 0.3});
  EXPECT_EQ(restored.take().size(), 1U);
  EXPECT_TRUE(restored.aivs().empty());
}

}  // namespace
}  // namespace cosiva::virtual_side
