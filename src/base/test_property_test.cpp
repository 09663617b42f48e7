#include "cosiva/base/test_property.h"

#include <gmock/gmock.h>

namespace cosiva {
namespace {

using testing::AllOf;
using testing::HasSubstr;
using testing::Not;

void fails_twice() {
  EXPECT_EQ(1, 1) << "holds";
  EXPECT_EQ(1, 2) << "goes on";
  ASSERT_EQ(1, 3) << "ends";
  EXPECT_EQ(1, 4) << "never reached";
}

TEST(FailuresOf, reports_failures_without_failing_this_test) {
  EXPECT_THAT(failures_of(fails_twice),
              AllOf(HasSubstr("goes on"), HasSubstr("ends"), Not(HasSubstr("holds")), Not(HasSubstr("never reached"))));
  EXPECT_FALSE(HasFailure());
}

TEST(FailuresOf, is_empty_for_checks_that_hold_also_after_a_failure) {
  EXPECT_NE(failures_of(fails_twice), "");
  EXPECT_EQ(failures_of([] { EXPECT_EQ(1, 1); }), "");
}

}  // namespace
}  // namespace cosiva
