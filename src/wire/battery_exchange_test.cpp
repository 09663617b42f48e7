#include "wire/battery_exchange.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <rapidcheck.h>

#include <string>

#include "base/random.h"

namespace cosiva::wire {
namespace {

using ::testing::HasSubstr;

TEST(BatteryExchange, reads_back_what_it_writes) {
  rc::check("any battery", [](std::uint64_t seed) {
    Random random{seed, "battery"};
    const BatteryReady ready{"B" + std::to_string(random.below(1000)),
                             "leaf\"33\n",
                             random.uniform(0, 1e4),
                             random.uniform(0, 1e6),
                             random.uniform(-20, 60),
                             random.uniform(0, 100)};
    RC_ASSERT(battery_ready_from_json(to_json(ready)) == ready);
    const BatteryChange change{"B7", static_cast<std::uint32_t>(random.next()), random.chance(0.5) ? "too cold" : ""};
    RC_ASSERT(battery_change_from_json(to_json(change)) == change);
  });
}

TEST(BatteryExchange, that_is_bad_is_refused_with_its_field) {
  const auto refusal = [](const std::string& json) {
    const auto ready = battery_ready_from_json(json);
    EXPECT_FALSE(ready) << json;
    return ready ? std::string{} : to_string(ready.error());
  };
  const std::string rest = R"("type":"x","cycles":1,"rest_s":0,"temperature":20,)";
  EXPECT_THAT(refusal("{}"), HasSubstr("battery"));
  EXPECT_THAT(refusal(R"({"battery":"",)" + rest + R"("charge":100})"), HasSubstr("battery"));
  EXPECT_THAT(refusal(R"({"battery":"B",)" + rest + R"("charge":101})"), HasSubstr("charge"));
  EXPECT_THAT(refusal(R"({"battery":"B",)" + rest + R"("charge":"full"})"), HasSubstr("charge"));
  EXPECT_THAT(refusal(R"({"battery":"B","type":"x","cycles":-1,"rest_s":0,"temperature":20,"charge":1})"),
              HasSubstr("cycles"));
  EXPECT_FALSE(refusal("charge").empty());
}

}  // namespace
}  // namespace cosiva::wire
