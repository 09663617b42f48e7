#include "cosiva/virtual/server/registry/factsheet_record.h"

#include <gtest/gtest.h>

namespace cosiva::virtual_side {
namespace {

wire::Factsheet with_actions() {
  wire::Factsheet factsheet;
  factsheet.actions.resize(2);
  factsheet.actions[0].type = "startPause";
  factsheet.actions[0].instant = true;
  factsheet.actions[1].type = "pick";
  factsheet.actions[1].node = true;
  return factsheet;
}

TEST(FactsheetRecord, knows_nothing_before_the_factsheet) {
  const FactsheetRecord record;
  EXPECT_TRUE(record.missing());
  EXPECT_EQ(record.supports("startPause"), std::nullopt);
}

TEST(FactsheetRecord, lists_the_instant_actions_of_the_vehicle) {
  FactsheetRecord record;
  record.on_factsheet(with_actions());
  EXPECT_FALSE(record.missing());
  EXPECT_EQ(record.supports("startPause"), true);
  EXPECT_EQ(record.supports("pick"), false) << "at nodes only";
  EXPECT_EQ(record.supports("initPosition"), false);
}

TEST(FactsheetRecord, is_requested_once_per_session) {
  FactsheetRecord record;
  record.on_requested();
  EXPECT_FALSE(record.missing());
  EXPECT_DEATH(record.on_requested(), "missing");
  record.on_session();
  EXPECT_TRUE(record.missing());
  record.on_factsheet(with_actions());
  record.on_session();
  EXPECT_FALSE(record.missing()) << "a vehicle keeps its factsheet";
}

TEST(FactsheetRecord, is_replaced_by_the_next_one_and_requested_no_more) {
  FactsheetRecord record;
  record.on_factsheet(with_actions());
  EXPECT_DEATH(record.on_requested(), "missing");
  wire::Factsheet other;
  other.actions.push_back({"pick", "", true, false, false, {}});
  record.on_factsheet(other);
  EXPECT_EQ(record.supports("startPause"), false);
  EXPECT_EQ(record.supports("pick"), true);
}

}  // namespace
}  // namespace cosiva::virtual_side
