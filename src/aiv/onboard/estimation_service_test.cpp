#include "cosiva/aiv/onboard/estimation_service.h"

#include <gtest/gtest.h>

#include "cosiva/aiv/testing/test_zone.h"

namespace cosiva::aiv {
namespace {

using test::lacet4;

struct EstimationServiceTest : ::testing::Test {
  EstimationService estimation;
  DrivingContext context{lacet4(), {}};
  Session session{{"CoSiVA", "AIV1"}, wire::default_interface};
  wire::Effects effects;

  EstimationServiceTest() {
    session.set_online(true);
    context.vehicle().estimator().position_at(test::at(lacet4(), "loop_se", 0.5));
  }
};

TEST_F(EstimationServiceTest, passes_odometry_to_the_agent_once) {
  wire::Odometry odometry{};
  estimation.on_odometry(SimTime{}, odometry, context);
  odometry.distance_um = 10'000;
  odometry.board_ms = 20;
  estimation.on_odometry(SimTime{std::chrono::milliseconds{20}}, odometry, context);
  EXPECT_DOUBLE_EQ(context.vehicle().position().travelled_m(), 0.010);
}

TEST_F(EstimationServiceTest, logs_a_request_that_cannot_be_read_once) {
  estimation.on_request(SimTime{}, "{", session, effects);
  estimation.on_request(SimTime{}, "{", session, effects);
  EXPECT_EQ(effects.size(), 1U);
}

TEST_F(EstimationServiceTest, responds_to_a_request_with_the_next_odometry) {
  wire::EstimateRequest request;
  request.session = "s";
  request.sequence = 1;
  request.algorithms = {"no such algorithm"};
  estimation.on_request(SimTime{}, to_json(request), session, effects);
  EXPECT_TRUE(effects.empty());
  estimation.on_odometry(SimTime{}, {}, context);
  estimation.publish(session, effects);
  ASSERT_EQ(effects.size(), 1U);
  EXPECT_TRUE(std::holds_alternative<wire::Publish>(effects[0]));
  estimation.publish(session, effects);
  EXPECT_EQ(effects.size(), 1U);
}

}  // namespace
}  // namespace cosiva::aiv
