#include "cosiva/wire/own/actual_position.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <rapidcheck.h>

#include <string>

#include "cosiva/base/random.h"

namespace cosiva::wire {
namespace {

using ::testing::HasSubstr;

TEST(ActualPosition, reads_back_what_it_writes) {
  EXPECT_TRUE(rc::check("any position", [](std::uint64_t seed) {
    Random random{seed, "actual position"};
    const ActualPositionRequest request{"qualify-7/\"1", static_cast<std::uint32_t>(random.next())};
    RC_ASSERT(actual_position_request_from_json(to_json(request)) == request);
    const ActualPosition position{request.session,
                                  request.sequence,
                                  SimTime{std::chrono::milliseconds{1'700'000'000'000 + random.below(1'000'000'000)}},
                                  {random.uniform(-1e4, 1e4), random.uniform(-1e4, 1e4), random.uniform(-3.1, 3.1)},
                                  random.uniform(0, 1)};
    RC_ASSERT(actual_position_from_json(to_json(position)) == position);
  }));
}

TEST(ActualPosition, refuses_a_bad_message_naming_the_field) {
  const ActualPosition good{"s", 1, SimTime{}, {1.0, 2.0, 0.5}, 0.001};
  const auto refusal = [&good](const std::string& from, const std::string& to) {
    std::string json = to_json(good);
    const std::size_t at = json.find(from);
    EXPECT_NE(at, std::string::npos) << json;
    const auto read = actual_position_from_json(json.replace(at, from.size(), to));
    EXPECT_FALSE(read) << json;
    return read ? std::string{} : to_string(read.error());
  };
  EXPECT_THAT(refusal(R"("x":1)", R"("x":null)"), HasSubstr("x"));
  EXPECT_THAT(refusal(R"("uncertainty":0.001)", R"("uncertainty":-1)"), HasSubstr("uncertainty"));
  EXPECT_THAT(refusal(R"("session":"s")", R"("session":"")"), HasSubstr("session"));
  EXPECT_THAT(refusal(R"("sequence":1)", R"("sequence":-1)"), HasSubstr("sequence"));
  EXPECT_FALSE(actual_position_request_from_json("{}"));
}

}  // namespace
}  // namespace cosiva::wire
