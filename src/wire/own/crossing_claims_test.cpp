#include "cosiva/wire/own/crossing_claims.h"

#include <gtest/gtest.h>

#include <string>

namespace cosiva::wire {
namespace {

CrossingClaims sample() {
  CrossingClaims claims;
  claims.header_id = 7;
  claims.timestamp = virtual_epoch;
  claims.map_id = "lacet4";
  claims.vehicle = {"CoSiVA", "AIV1"};
  claims.position = {0.125, -0.15};
  claims.clock = 12;
  claims.claim = CrossingClaims::Claim{3, 11, 2, false, {"X1", "X2"}};
  claims.yields = {{{"CoSiVA", "AIV2"}, 5}};
  return claims;
}

TEST(CrossingClaims, are_read_as_they_were_written) {
  EXPECT_EQ(*crossing_claims_from_json(to_json(sample())), sample());
  CrossingClaims none = sample();
  none.claim.reset();
  none.yields.clear();
  EXPECT_EQ(*crossing_claims_from_json(to_json(none)), none);
}

TEST(CrossingClaims, are_refused_with_the_name_of_the_bad_field) {
  const auto field_of = [](const std::string& from, const std::string& to) {
    std::string json = to_json(sample());
    const std::size_t at = json.find(from);
    EXPECT_NE(at, std::string::npos) << from;
    json.replace(at, from.size(), to);
    const auto read = crossing_claims_from_json(json);
    return read ? std::string{} : read.error().location;
  };
  EXPECT_EQ(field_of(R"("id":3)", R"("id":-3)"), "claim.id");
  EXPECT_EQ(field_of(R"("priority":2)", R"("priority":1000)"), "claim.priority");
  EXPECT_EQ(field_of(R"(["X1","X2"])", R"([1])"), "claim.crossings.0");
  EXPECT_EQ(field_of(R"("granted":false)", R"("granted":0)"), "claim.granted");
  EXPECT_EQ(field_of(R"("clock":12)", R"("clock":1e12)"), "clock");
  EXPECT_EQ(field_of(R"("claim":5)", R"("claim":0.5)"), "yields.0.claim");
  EXPECT_EQ(field_of(R"("x":0.125)", R"("x":"a")"), "x");
  EXPECT_FALSE(crossing_claims_from_json("{"));
  CrossingClaims many = sample();
  many.yields.resize(CrossingClaims::yields_max + 1, many.yields.front());
  EXPECT_EQ(crossing_claims_from_json(to_json(many)).error().location, "yields");
}

}  // namespace
}  // namespace cosiva::wire
