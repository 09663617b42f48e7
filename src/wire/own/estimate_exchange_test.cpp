#include "cosiva/wire/own/estimate_exchange.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <rapidcheck.h>

#include <string>

#include "cosiva/base/random.h"

namespace cosiva::wire {
namespace {

using ::testing::HasSubstr;

EstimateResponse::Estimate some_estimate(Random& random, std::size_t readings) {
  EstimateResponse::Estimate estimate;
  estimate.algorithm = "arc_kalman";
  if (random.chance(0.2)) {
    estimate.fault = "it has \"diverged\"\n" + std::string(random.below(900), 'x');
    return estimate;
  }
  estimate.X_MB = {random.gaussian(0, 10), random.gaussian(0, 10), random.uniform(-3, 3)};
  if (random.chance(0.7)) {
    for (double& number : estimate.covariance.emplace()) number = random.gaussian(0, 1e-3);
  }
  if (random.chance(0.5)) estimate.along_m = random.uniform(-1, 1e4);
  for (std::size_t i = 0; i < readings; ++i) {
    estimate.rectified.push_back({random.chance(0.9), std::nullopt, static_cast<std::uint8_t>(random.below(3))});
    if (random.chance(0.5)) estimate.rectified.back().nis = random.uniform(0, 10);
  }
  return estimate;
}

EstimateResponse some_response(Random& random) {
  EstimateResponse response;
  response.session = "qualify-1/" + std::to_string(random.below(100));
  response.sequence = static_cast<std::uint32_t>(random.next());
  response.timestamp = SimTime{std::chrono::milliseconds{1'700'000'000'000 + random.below(1'000'000'000)}};
  response.map_id = "lacet4";
  if (random.chance(0.2)) response.fault = "its zone was switched";
  response.travelled_m = random.uniform(0, 1e5);
  if (random.chance(0.5)) {
    auto& start = response.start.emplace(EstimateResponse::Start{});
    start.X_MB = {random.gaussian(0, 10), random.gaussian(0, 10), random.uniform(-3, 3)};
    start.sigma_m = random.uniform(0, 1);
    start.heading_sigma_rad = random.uniform(0, 1);
    if (random.chance(0.5)) start.section = "loop_se";
    start.along_m = random.uniform(0, 20);
    start.sensors = {1e-4, 2e-5, 3e-4, 0.02, 0.03, random.uniform(0, 1), 0.01, 0.002, 0.02};
  }
  std::size_t readings = 0;
  const std::size_t count = random.below(30);
  for (std::size_t i = 0; i < count; ++i) {
    if (random.chance(0.8)) {
      response.inputs.emplace_back(
          EstimateResponse::Odometry{random.gaussian(0, 0.01), random.gaussian(0, 0.01), 0.02});
    } else {
      ++readings;
      response.inputs.emplace_back(EstimateResponse::Reading{static_cast<std::uint32_t>(random.next()),
                                                             {random.gaussian(0, 10), random.gaussian(0, 10)},
                                                             {random.gaussian(0, 0.02), random.gaussian(0, 0.02)}});
    }
  }
  for (std::size_t i = 0; i < random.below(4); ++i) response.estimates.push_back(some_estimate(random, readings));
  return response;
}

TEST(EstimateExchange, reads_back_what_it_writes_to_the_last_bit) {
  rc::check("any request and response", [](std::uint64_t seed) {
    Random random{seed, "estimates"};
    EstimateRequest request{"qualify-1/7", 1 + static_cast<std::uint32_t>(random.below(1U << 30U)), {}, 0, 1, 1};
    request.seed = random.next() >> 11U;
    request.particles = 1 + static_cast<std::uint32_t>(random.below(EstimateRequest::particles_max));
    request.horizon = 1 + static_cast<std::uint32_t>(random.below(EstimateRequest::horizon_max));
    for (std::size_t i = 0; i < random.below(EstimateRequest::algorithms_max + 1); ++i)
      request.algorithms.push_back("algorithm_" + std::to_string(i));
    RC_ASSERT(estimate_request_from_json(to_json(request)) == request);
    const EstimateResponse response = some_response(random);
    RC_ASSERT(estimate_response_from_json(to_json(response)) == response);
  });
}

TEST(EstimateExchange, refuses_a_bad_request_naming_the_field) {
  const std::string good = to_json(EstimateRequest{"q/1", 3, {"ekf"}, 1, 500, 4});
  const auto refusal = [&](const std::string& from, const std::string& to) {
    std::string json = good;
    const std::size_t at = json.find(from);
    EXPECT_NE(at, std::string::npos) << from;
    const auto read = estimate_request_from_json(json.replace(at, from.size(), to));
    EXPECT_FALSE(read) << json;
    return read ? std::string{} : to_string(read.error());
  };
  ASSERT_TRUE(estimate_request_from_json(good));
  EXPECT_THAT(refusal(R"("session":"q/1")", R"("session":"")"), HasSubstr("session"));
  EXPECT_THAT(refusal(R"("sequence":3)", R"("sequence":0)"), HasSubstr("sequence"));
  EXPECT_THAT(refusal(R"(["ekf"])", R"([7])"), HasSubstr("algorithms.0"));
  EXPECT_THAT(refusal(R"(["ekf"])", R"("ekf")"), HasSubstr("algorithms"));
  EXPECT_THAT(refusal(R"("seed":1)", R"("seed":-1)"), HasSubstr("seed"));
  // A vehicle has no computing time for a million particles.
  EXPECT_THAT(refusal(R"("particles":500)", R"("particles":1000000)"), HasSubstr("particles"));
  EXPECT_THAT(refusal(R"("horizon":4)", R"("horizon":0)"), HasSubstr("horizon"));
  EXPECT_FALSE(estimate_request_from_json(""));
}

TEST(EstimateExchange, refuses_a_bad_response_naming_the_field) {
  EstimateResponse response;
  response.session = "q/1";
  response.start.emplace(EstimateResponse::Start{});
  response.inputs.emplace_back(EstimateResponse::Odometry{0.01, 0.0, 0.02});
  response.inputs.emplace_back(EstimateResponse::Reading{7, {1.5, 0.0}, {0.02, 0.0}});
  auto& estimate = response.estimates.emplace_back();
  estimate.algorithm = "ekf";
  estimate.covariance = std::array<double, 9>{0.25, 0, 0, 0, 1, 0, 0, 0, 1};
  estimate.rectified.push_back({true, 0.5, 1});
  const std::string good = to_json(response);
  const auto refusal = [&](const std::string& from, const std::string& to) {
    std::string json = good;
    const std::size_t at = json.find(from);
    EXPECT_NE(at, std::string::npos) << from << " in " << json;
    const auto read = estimate_response_from_json(json.replace(at, from.size(), to));
    EXPECT_FALSE(read) << json;
    return read ? std::string{} : to_string(read.error());
  };
  ASSERT_TRUE(estimate_response_from_json(good)) << good;
  EXPECT_THAT(refusal(R"("distance_m":0.01)", R"("distance_m":"far")"), HasSubstr("inputs.0.odometry.distance_m"));
  EXPECT_THAT(refusal(R"("fiducial":7)", R"("fiducial":0.5)"), HasSubstr("inputs.1.reading.fiducial"));
  EXPECT_THAT(refusal(R"({"odometry")", R"({"gyroscope")"), HasSubstr("inputs.0"));
  EXPECT_THAT(refusal(R"([0.25,)", R"([)"), HasSubstr("estimates.0.covariance"));
  EXPECT_THAT(refusal(R"([0.25,)", R"([null,)"), HasSubstr("estimates.0.covariance.0"));
  EXPECT_THAT(refusal(R"("nis":0.5)", R"("nis":-1)"), HasSubstr("estimates.0.rectified.0.nis"));
  EXPECT_THAT(refusal(R"("sensors":{)", R"("nothing":{)"), HasSubstr("start.sensors"));
  EXPECT_THAT(refusal(R"("fiducial_along_sigma_m":0)", R"("fiducial_along_sigma_m":-1)"),
              HasSubstr("start.sensors.fiducial_along_sigma_m"));
  EXPECT_THAT(refusal(R"("timestamp":)", R"("at":)"), HasSubstr("timestamp"));
  EXPECT_FALSE(estimate_response_from_json("[]"));
}

}  // namespace
}  // namespace cosiva::wire
