#include "cosiva/aiv/onboard/zone_selection.h"

#include <gtest/gtest.h>

#include "cosiva/aiv/testing/test_zone.h"

namespace cosiva::aiv {
namespace {

using enum ZoneSelection::Verdict;
using test::lacet4;

zone::ZoneConfiguration changed(const std::string& from, const std::string& to) {
  zone::ZoneConfiguration configuration = test::lacet4_configuration();
  configuration.text.replace(configuration.text.find(from), from.size(), to);
  return configuration;
}
zone::ZoneConfiguration renamed() { return changed("name = \"lacet4\"", "name = \"other\""); }

struct ZoneSelectionTest : ::testing::Test {
  ZoneSelection zones;
  wire::Effects effects;

  ZoneSelection::Verdict announce(const zone::ZoneConfiguration& configuration) {
    return zones.on_announced(configuration, nullptr, &lacet4(), effects).verdict;
  }
  void enter() {
    const auto decision = zones.on_announced(test::lacet4_configuration(), nullptr, nullptr, effects);
    ASSERT_EQ(decision.verdict, first);
    zones.enforce(*decision.rtm);
  }
};

TEST_F(ZoneSelectionTest, lists_the_zone_in_force_and_then_the_pending_one) {
  EXPECT_TRUE(zones.maps().empty());
  enter();
  EXPECT_EQ(zones.maps().size(), 1U);
  EXPECT_EQ(announce(test::lacet4_configuration()), unchanged);
  EXPECT_EQ(announce(renamed()), pending);
  EXPECT_EQ(announce(renamed()), unchanged) << "the zone is pending already";
  ASSERT_EQ(zones.maps().size(), 2U);
  EXPECT_TRUE(zones.maps()[0].enabled);
  EXPECT_EQ(zones.maps()[1].map_id, "other");
  EXPECT_FALSE(zones.maps()[1].enabled);
  zones.enforce(*zones.pending());
  ASSERT_EQ(zones.maps().size(), 1U);
  EXPECT_EQ(zones.maps()[0].map_id, "other");
  EXPECT_TRUE(zones.maps()[0].enabled);
}

TEST_F(ZoneSelectionTest, calls_a_switch_off_when_the_zone_in_force_is_announced_again) {
  enter();
  ASSERT_EQ(announce(renamed()), pending);
  EXPECT_EQ(announce(test::lacet4_configuration()), called_off);
  EXPECT_FALSE(zones.pending());
  EXPECT_EQ(zones.maps().size(), 1U);
}

TEST_F(ZoneSelectionTest, adopts_other_fiducials_at_once) {
  enter();
  ASSERT_EQ(announce(renamed()), pending);
  EXPECT_EQ(announce(changed("s_m = 1.4137", "s_m = 1.3637")), edited);
  EXPECT_FALSE(zones.pending()) << "the last announcement counts";
}

TEST_F(ZoneSelectionTest, refuses_an_invalid_zone_and_keeps_the_pending_one) {
  enter();
  ASSERT_EQ(announce(renamed()), pending);
  EXPECT_EQ(announce({"toml", "x.toml", "no zone"}), refused);
  EXPECT_TRUE(zones.pending());
  EXPECT_FALSE(zones.refusal().empty());
  EXPECT_EQ(announce(test::lacet4_configuration()), called_off);
  EXPECT_TRUE(zones.refusal().empty());
}

TEST_F(ZoneSelectionTest, takes_an_rtm_that_was_built_before) {
  const auto built = std::make_shared<const zone::Rtm>(*zone::Rtm::initialise(test::lacet4_configuration()));
  const std::uint64_t before = zone::Rtm::initialised_count();
  EXPECT_EQ(zones.on_announced(built->configuration(), built, nullptr, effects).rtm, built);
  EXPECT_EQ(zone::Rtm::initialised_count(), before);
}

TEST_F(ZoneSelectionTest, logs_what_follows_and_what_stays) {
  enter();
  effects.clear();
  ASSERT_EQ(announce(renamed()), pending);
  ASSERT_EQ(effects.size(), 1U);
  EXPECT_EQ(std::get<wire::Log>(effects[0]),
            (wire::Log{'i', "zone 'other' follows 'lacet4' as soon as this vehicle has stopped"}));
  ASSERT_EQ(announce(test::lacet4_configuration()), called_off);
  ASSERT_EQ(effects.size(), 2U);
  EXPECT_EQ(std::get<wire::Log>(effects[1]), (wire::Log{'i', "zone 'lacet4' stays"}));
  EXPECT_EQ(announce(test::lacet4_configuration()), unchanged);
  EXPECT_EQ(effects.size(), 2U);
}

TEST_F(ZoneSelectionTest, takes_a_refused_first_zone_for_an_error_and_a_later_one_for_a_warning) {
  const zone::ZoneConfiguration bad{"toml", "x.toml", "no zone"};
  EXPECT_EQ(zones.on_announced(bad, nullptr, nullptr, effects).verdict, refused);
  EXPECT_EQ(std::get<wire::Log>(effects.back()).level, 'e');
  EXPECT_EQ(std::get<wire::Log>(effects.back()).text, zones.refusal());
  EXPECT_TRUE(zones.refusal().starts_with("a zone was announced and is not used: "));
  enter();
  EXPECT_TRUE(zones.refusal().empty());
  EXPECT_EQ(announce(bad), refused);
  EXPECT_EQ(std::get<wire::Log>(effects.back()).level, 'w');
}

TEST_F(ZoneSelectionTest, replaces_a_pending_zone_by_the_next_one) {
  enter();
  ASSERT_EQ(announce(renamed()), pending);
  ASSERT_EQ(announce(changed("name = \"lacet4\"", "name = \"third\"")), pending);
  ASSERT_EQ(zones.maps().size(), 2U);
  EXPECT_EQ(zones.maps()[1].map_id, "third");
  EXPECT_EQ(zones.pending()->zone().name, "third");
}

TEST_F(ZoneSelectionTest, gives_the_rtm_of_a_first_or_edited_zone_only) {
  const auto begun = zones.on_announced(test::lacet4_configuration(), nullptr, nullptr, effects);
  ASSERT_TRUE(begun.rtm);
  zones.enforce(*begun.rtm);
  EXPECT_FALSE(zones.on_announced(test::lacet4_configuration(), nullptr, &lacet4(), effects).rtm);
  EXPECT_FALSE(zones.on_announced(renamed(), nullptr, &lacet4(), effects).rtm);
  const auto other_tags = zones.on_announced(changed("s_m = 1.4137", "s_m = 1.3637"), nullptr, &lacet4(), effects);
  ASSERT_TRUE(other_tags.rtm);
  EXPECT_EQ(other_tags.rtm->zone().name, "lacet4");
}

TEST_F(ZoneSelectionTest, needs_the_zone_that_is_in_force_and_no_other_rtm_than_the_announced_zone_s) {
  EXPECT_DEATH(announce(test::lacet4_configuration()), "in_force != nullptr");
  const auto other = std::make_shared<const zone::Rtm>(*zone::Rtm::initialise(renamed()));
  EXPECT_DEATH(static_cast<void>(zones.on_announced(test::lacet4_configuration(), other, nullptr, effects)),
               "configuration");
}

}  // namespace
}  // namespace cosiva::aiv
