#include "cosiva/aiv/onboard/announced_zone.h"

#include <gtest/gtest.h>

#include <memory>
#include <string_view>

#include "cosiva/aiv/testing/test_zone.h"

namespace cosiva::aiv {
namespace {

TEST(AnnouncedZone, carries_its_rtm_and_is_the_zone_s_name_in_a_digest) {
  const auto rtm = std::make_shared<const zone::Rtm>(*zone::Rtm::initialise(test::lacet4_configuration()));
  const AnnouncedZone announced{rtm};
  EXPECT_EQ(announced.rtm(), rtm);
  Digest folded;
  announced.fold(folded);
  Digest expected;
  expected.add(std::string_view{"lacet4"});
  EXPECT_EQ(folded.value(), expected.value());
}

TEST(AnnouncedZoneDeathTest, has_an_rtm) { EXPECT_DEATH(AnnouncedZone{nullptr}, "rtm_"); }

}  // namespace
}  // namespace cosiva::aiv
