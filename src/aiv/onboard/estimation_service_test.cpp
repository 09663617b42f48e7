#include "cosiva/aiv/onboard/estimation_service.h"

#include <gtest/gtest.h>

#include <cmath>
#include <string>
#include <variant>
#include <vector>

#include "cosiva/aiv/testing/test_zone.h"

namespace cosiva::aiv {
namespace {

using test::lacet4;

struct EstimationServiceTest : ::testing::Test {
  EstimationService estimation;
  DrivingContext context{lacet4(), {}};
  ServerProxy server_proxy{{"CoSiVA", "AIV1"}, wire::default_interface};
  wire::Effects effects;

  EstimationServiceTest() {
    server_proxy.set_online(true);
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
  estimation.on_request(SimTime{}, "{", server_proxy, effects);
  estimation.on_request(SimTime{}, "{", server_proxy, effects);
  EXPECT_EQ(effects.size(), 1U);
}

TEST_F(EstimationServiceTest, responds_to_a_request_with_the_next_odometry) {
  wire::EstimateRequest request;
  request.session = "s";
  request.sequence = 1;
  request.algorithms = {"no such algorithm"};
  estimation.on_request(SimTime{}, to_json(request), server_proxy, effects);
  EXPECT_TRUE(effects.empty());
  estimation.on_odometry(SimTime{}, {}, context);
  estimation.publish(server_proxy, effects);
  ASSERT_EQ(effects.size(), 1U);
  EXPECT_TRUE(std::holds_alternative<wire::Publish>(effects[0]));
  estimation.publish(server_proxy, effects);
  EXPECT_EQ(effects.size(), 1U);
}

/// A session of estimates on a vehicle that reports every 20 ms.
struct EstimationSessionTest : EstimationServiceTest {
  SimTime now{std::chrono::hours{24}};
  wire::Odometry odometry;
  std::uint32_t sequence{0};

  void read(double distance_m = 0.0) {
    now += std::chrono::milliseconds{20};
    odometry.board_ms += 20;
    odometry.distance_um += std::llround(1e6 * distance_m);
    estimation.on_odometry(now, odometry, context);
  }
  void request() {
    wire::EstimateRequest next;
    next.session = "s";
    next.sequence = ++sequence;
    next.algorithms = {"dead_reckoning"};
    estimation.on_request(now, to_json(next), server_proxy, effects);
  }
  /// The inputs in the response to a request that is sent now, with the reading that follows.
  std::vector<wire::EstimateResponse::Input> inputs_with(double distance_m = 0.0) {
    request();
    read(distance_m);
    effects.clear();
    estimation.publish(server_proxy, effects);
    EXPECT_EQ(effects.size(), 1U);
    if (effects.empty()) return {};
    const auto response = wire::estimate_response_from_json(std::get<wire::Publish>(effects[0]).payload);
    EXPECT_TRUE(response);
    return response ? response->inputs : std::vector<wire::EstimateResponse::Input>{};
  }
};

void expect_step(const wire::EstimateResponse::Input& input, double distance_m, double turn_rad) {
  const auto* step = std::get_if<wire::EstimateResponse::Odometry>(&input);
  ASSERT_NE(step, nullptr);
  EXPECT_NEAR(step->distance_m, distance_m, 1e-9);
  EXPECT_NEAR(step->turn_rad, turn_rad, 1e-9);
  EXPECT_NEAR(step->duration_s, 0.02, 1e-9);
}

TEST_F(EstimationSessionTest, turns_on_its_path_as_the_path_does) {
  // The loop turns to the right, with a radius of 0.6 m.
  read();
  EXPECT_TRUE(inputs_with().empty());
  read(0.01);
  const auto inputs = inputs_with(-0.03);
  ASSERT_EQ(inputs.size(), 2U);
  expect_step(inputs[0], 0.01, -0.01 / 0.6);
  expect_step(inputs[1], -0.03, 0.03 / 0.6);
}

TEST_F(EstimationSessionTest, moves_and_turns_in_a_manoeuvre_as_its_wheels_report) {
  context.vehicle().estimator().set_off_path({3.0, 4.0, 0.5});
  odometry.manoeuvre = wire::Manoeuvre{0, 0, 0};
  read();
  EXPECT_TRUE(inputs_with().empty());
  odometry.manoeuvre = wire::Manoeuvre{50, 0, 0};
  read();
  odometry.manoeuvre = wire::Manoeuvre{50, 0, 100};
  const auto inputs = inputs_with();
  ASSERT_EQ(inputs.size(), 2U);
  expect_step(inputs[0], 0.05, 0.0);
  expect_step(inputs[1], 0.0, 0.1);
}

TEST_F(EstimationSessionTest, dates_a_tag_by_its_age) {
  const zone::TrackPosition tag = lacet4().find_tag(1)->position;
  context.vehicle().estimator().position_at(tag);
  odometry.speed_mmps = 500;
  read();
  EXPECT_TRUE(inputs_with().empty());
  read();  // gives the speed
  estimation.on_tag(now, {0, 1, 10}, context);
  const auto inputs = inputs_with();
  ASSERT_EQ(inputs.size(), 1U);
  const auto& reading = std::get<wire::EstimateResponse::Reading>(inputs[0]);
  EXPECT_EQ(reading.fiducial, 1U);
  // The rim of the field is 2 cm ahead; 10 ms and the latency of 20 ms at 0.5 m/s.
  EXPECT_NEAR(reading.detected_B.x_m, 0.02 - 0.5 * 0.03, 1e-9);
}

TEST_F(EstimationSessionTest, has_no_position_to_begin_with_before_the_vehicle_has) {
  DrivingContext lost{lacet4(), {}};
  request();
  estimation.on_odometry(now, odometry, lost);
  estimation.on_tag(now, {0, 1, 0}, lost);
  estimation.publish(server_proxy, effects);
  ASSERT_EQ(effects.size(), 1U);
  EXPECT_NE(std::get<wire::Publish>(effects[0]).payload.find("position is not known"), std::string::npos);
}

}  // namespace
}  // namespace cosiva::aiv
