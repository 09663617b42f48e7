#include "cosiva/aiv/onboard/warnings.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <string>
#include <vector>

namespace cosiva::aiv {
namespace {

using testing::ElementsAre;

std::vector<std::string> descriptions(const Warnings& warnings) {
  std::vector<std::string> all;
  for (const wire::VehicleError& warning : warnings.all()) all.push_back(warning.description);
  return all;
}

TEST(Warnings, are_warnings_with_their_references) {
  Warnings warnings;
  warnings.add("orderError", "no such node", {{"orderId", "O"}});
  EXPECT_THAT(warnings.all(), ElementsAre(wire::VehicleError{
                                  "orderError", wire::ErrorLevel::warning, "no such node", {{"orderId", "O"}}}));
}

TEST(Warnings, that_are_repeated_move_to_the_end) {
  Warnings warnings;
  for (const char* text : {"a", "b", "c", "a"}) warnings.add("orderError", text);
  EXPECT_THAT(descriptions(warnings), ElementsAre("b", "c", "a"));
}

TEST(Warnings, are_at_most_sixteen_the_newest) {
  Warnings warnings;
  for (int i = 0; i < 16; ++i) warnings.add("orderError", std::to_string(i));
  EXPECT_EQ(descriptions(warnings).front(), "0");
  warnings.add("orderError", "16");
  EXPECT_EQ(warnings.all().size(), 16U);
  EXPECT_EQ(descriptions(warnings).front(), "1");
  EXPECT_EQ(descriptions(warnings).back(), "16");
}

TEST(Warnings, about_updates_end_with_an_accepted_update_and_all_with_a_new_order) {
  Warnings warnings;
  warnings.add("orderUpdateError", "late");
  warnings.add("orderError", "wrong");
  warnings.on_update();
  EXPECT_THAT(descriptions(warnings), ElementsAre("wrong"));
  warnings.on_new_order();
  EXPECT_TRUE(warnings.all().empty());
}

}  // namespace
}  // namespace cosiva::aiv
