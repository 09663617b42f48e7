#include "cosiva/virtual/server/view/report_watch.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <string>

#include "cosiva/virtual/server/testing/server_fixture.h"

namespace cosiva::virtual_side {
namespace {

using namespace fixture;
using testing::HasSubstr;
using testing::IsEmpty;
using testing::SizeIs;

/// One vehicle that is stopped on the south side and reports.
class Reports : public testing::Test {
 protected:
  Reports() {
    aiv.blocked = true;
    fixture.run_for(3s);
  }
  [[nodiscard]] JsonValue::Array findings() const { return *fixture.bijection().find("findings")->array(); }
  /// The vehicle corrects its position by so much along its path, at this tag.
  void read_tag(int number, double shift_m) {
    aiv.motion.shift(fixture.zone->circuit, shift_m);
    wire::Information tag;
    tag.type = "lastTag";
    tag.references = {{"tag", std::to_string(number)}};
    aiv.information = {tag};
    aiv.state_due = true;
    fixture.run_for(200ms);
  }

  ServerFixture fixture;
  FixtureVehicle& aiv{fixture.add("AIV1", {0, 0.5})};
};

TEST_F(Reports, of_one_vehicle_show_nothing) {
  read_tag(7, 0.03);
  EXPECT_THAT(findings(), IsEmpty());
}

TEST_F(Reports, of_two_programs_under_one_name_are_found_within_a_second) {
  fixture.add("AIV1", {2, 0.5}).blocked = true;
  fixture.run_for(1s);
  ASSERT_THAT(findings(), SizeIs(1));
  EXPECT_EQ(findings()[0].text("kind"), "two programs");
  EXPECT_EQ(findings()[0].text("id"), "CoSiVA/AIV1");
  const double matched = *fixture.bijection().number("matched_ratio");
  fixture.run_for(1s);
  EXPECT_LT(*fixture.bijection().number("matched_ratio"), matched);
  fixture.vehicles.back()->alive = false;
  fixture.run_for(6s);
  EXPECT_THAT(findings(), IsEmpty());
}

TEST_F(Reports, of_a_tag_that_was_moved_on_one_side_are_found_until_a_vehicle_is_not_displaced_at_it) {
  read_tag(7, 0.4);
  ASSERT_THAT(findings(), SizeIs(1));
  EXPECT_EQ(findings()[0].text("kind"), "displaced tag");
  EXPECT_EQ(findings()[0].text("id"), "tag 7");
  EXPECT_THAT(findings()[0].text("text").value_or(""), HasSubstr("CoSiVA/AIV1 was displaced by 0.4 m"));
  read_tag(8, 0.0);
  EXPECT_THAT(findings(), SizeIs(1)) << "another tag";
  read_tag(7, 0.02);
  EXPECT_THAT(findings(), IsEmpty());
}

TEST_F(Reports, after_a_gap_show_nothing_about_a_tag) {
  aiv.alive = false;
  fixture.run_for(2s);
  aiv.alive = true;
  read_tag(7, 0.4);
  EXPECT_THAT(findings(), IsEmpty());
}

}  // namespace
}  // namespace cosiva::virtual_side
