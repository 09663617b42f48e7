#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "cosiva/physical/plant/plant_fixture.h"
#include "cosiva/physical/plant/plant_options.h"
#include "cosiva/physical/plant/test_zones.h"

namespace cosiva::physical {
namespace {

using ::testing::HasSubstr;

TEST(PlantOptions, travel_as_json) {
  PlantOptions options;
  options.zone = lacet4();
  options.vehicles = 12;
  options.seed = 0xFEDCBA9876543210ULL;
  options.noise.tag_miss = 0.125;
  options.noise.tag_latency_max = 21ms + 500us;
  options.publish_ground_truth = false;
  options.cycle = 100ms;
  const auto read = plant_options_from_json(to_json(options));
  ASSERT_TRUE(read) << to_string(read.error());
  EXPECT_EQ(to_json(*read), to_json(options));
  EXPECT_EQ(read->seed, options.seed);
  EXPECT_EQ(read->noise.tag_latency_max, options.noise.tag_latency_max);
  EXPECT_EQ(read->zone, options.zone);
  EXPECT_EQ(read->cycle, 100ms);
}

TEST(PlantOptions, that_are_missing_have_their_defaults) {
  const auto read = plant_options_from_json(R"({"zone":{"format":"toml","text":""},"seed":7})");
  ASSERT_TRUE(read) << to_string(read.error());
  EXPECT_EQ(read->vehicles, 4U);
  EXPECT_EQ(read->seed, 7U);
  EXPECT_EQ(read->noise.tag_miss, PlantNoise{}.tag_miss);
  EXPECT_EQ(read->cycle, 10ms);
}

TEST(PlantOptions, that_are_invalid_are_named) {
  const auto with = [](const std::string& member) {
    const auto read = plant_options_from_json(R"({"zone":{"format":"toml","text":""},)" + member + "}");
    return read ? std::string("accepted") : read.error().message;
  };
  EXPECT_THAT(with(R"("vehicles":0)"), HasSubstr("'vehicles'"));
  EXPECT_THAT(with(R"("vehicles":2.5)"), HasSubstr("'vehicles'"));
  EXPECT_THAT(with(R"("vehicles":1001)"), HasSubstr("'vehicles'"));
  EXPECT_THAT(with(R"("seed":-1)"), HasSubstr("'seed'"));
  EXPECT_THAT(with(R"("seed":"18446744073709551616")"), HasSubstr("'seed'"));
  EXPECT_THAT(with(R"("publish_zone":1)"), HasSubstr("'publish_zone'"));
  EXPECT_THAT(with(R"("cycle_ms":0)"), HasSubstr("'cycle_ms'"));
  EXPECT_THAT(with(R"("cycle_ms":"10")"), HasSubstr("'cycle_ms'"));
  EXPECT_THAT(with(R"("noise":7)"), HasSubstr("'noise'"));
  EXPECT_THAT(with(R"("noise":{"tag_miss":1.5})"), HasSubstr("'tag_miss'"));
  EXPECT_THAT(with(R"("noise":{"tag_latency_min_ms":30})"), HasSubstr("'tag_latency_min_ms'"));
  EXPECT_FALSE(plant_options_from_json("{}"));
  EXPECT_FALSE(plant_options_from_json("[]"));
  EXPECT_FALSE(plant_options_from_json("nonsense"));
}

}  // namespace
}  // namespace cosiva::physical
