#include "cosiva/zone/rtm/rtm_builder.h"

#include <gtest/gtest.h>

#include "cosiva/zone/testing/test_zones.h"

namespace cosiva::zone {
namespace {

using testing::configuration_file;

TEST(RtmBuilder, builds_an_equal_configuration_once) {
  RtmBuilder builder;
  const std::uint64_t before = Rtm::initialised_count();
  const auto first = builder.build(configuration_file("lacet4.toml"));
  ASSERT_TRUE(first);
  EXPECT_EQ(builder.build(configuration_file("lacet4.toml")).value(), *first);
  EXPECT_EQ(Rtm::initialised_count() - before, 1U);
}

TEST(RtmBuilder, builds_another_configuration_or_origin_anew) {
  RtmBuilder builder;
  ZoneConfiguration configuration = configuration_file("lacet4.toml");
  const auto first = builder.build(configuration);
  configuration.origin = "elsewhere";
  const auto second = builder.build(configuration);
  ASSERT_TRUE(second);
  EXPECT_NE(*second, *first);
  EXPECT_EQ((*second)->configuration().origin, "elsewhere");
}

TEST(RtmBuilder, keeps_the_error_and_the_last_rtm_that_could_be_built) {
  RtmBuilder builder;
  const auto good = builder.build(configuration_file("lacet4.toml"));
  const std::uint64_t before = Rtm::initialised_count();
  const ZoneConfiguration bad{"toml", "bad.toml", "name = 7"};
  const auto refused = builder.build(bad);
  ASSERT_FALSE(refused);
  EXPECT_EQ(builder.build(bad).error(), refused.error());
  EXPECT_EQ(builder.build(configuration_file("lacet4.toml")).value(), *good);
  EXPECT_EQ(Rtm::initialised_count() - before, 1U);
}

TEST(RtmBuilder, takes_an_rtm_that_was_built_before) {
  const auto given = std::make_shared<const Rtm>(*Rtm::initialise(configuration_file("lacet4.toml")));
  const std::uint64_t before = Rtm::initialised_count();
  EXPECT_EQ(RtmBuilder{given}.build(given->configuration()).value(), given);
  EXPECT_EQ(Rtm::initialised_count(), before);
}

TEST(RtmBuilder, takes_what_another_thread_has_built) {
  RtmBuilder builder;
  const ZoneConfiguration good = configuration_file("lacet4.toml");
  const auto rtm = std::make_shared<const Rtm>(*Rtm::initialise(good));
  const ZoneConfiguration bad{"toml", "bad.toml", "name = 7"};
  const std::uint64_t before = Rtm::initialised_count();
  builder.take(good, rtm);
  builder.take(bad, fail("zone.key", "no circuit", "bad.toml"));
  EXPECT_EQ(builder.build(good).value(), rtm);
  EXPECT_EQ(builder.build(bad).error().message, "no circuit");
  EXPECT_EQ(Rtm::initialised_count(), before);
}

TEST(RtmBuilder, forgets_an_error_once_another_configuration_was_built) {
  RtmBuilder builder;
  const ZoneConfiguration bad{"toml", "bad.toml", "name = 7"};
  const std::uint64_t before = Rtm::initialised_count();
  EXPECT_FALSE(builder.build(bad));
  EXPECT_FALSE(builder.build(bad));
  EXPECT_EQ(Rtm::initialised_count() - before, 1U);
  ASSERT_TRUE(builder.build(configuration_file("lacet4.toml")));
  EXPECT_FALSE(builder.build(bad));
  EXPECT_EQ(Rtm::initialised_count() - before, 3U);
}

}  // namespace
}  // namespace cosiva::zone
