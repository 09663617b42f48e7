#include "cosiva/zone/drawing/zone_circuit.h"

#include <gtest/gtest.h>

#include "cosiva/zone/drawing/draw.h"
#include "cosiva/zone/testing/test_zones.h"

namespace cosiva::zone {
namespace {

TEST(ZoneCircuit, draws_its_zone) {
  const auto circuit = circuit_of(testing::lacet4());
  ASSERT_TRUE(circuit);
  const auto drawn = (*circuit)->draw();
  const auto expected = draw(*(*circuit)->zone());
  ASSERT_EQ(drawn.size(), expected.size());
  for (std::size_t i = 0; i < drawn.size(); ++i) {
    EXPECT_EQ(drawn[i].layer, expected[i].layer);
    EXPECT_EQ(drawn[i].points, expected[i].points);
  }
}

TEST(ZoneCircuit, is_not_made_of_a_zone_that_could_not_be_read) {
  const auto circuit = circuit_of(fail("zone.key", "no circuit", "bad.toml"));
  ASSERT_FALSE(circuit);
  EXPECT_EQ(circuit.error().code, "zone.key");
}

}  // namespace
}  // namespace cosiva::zone
