#include "cosiva/wire/own/estimate_exchange.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <rapidcheck.h>

#include <cmath>
#include <string>

#include "cosiva/base/random.h"
#include "cosiva/wire/own/limits_fixture.h"

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
  EXPECT_TRUE(rc::check("any request and response", [](std::uint64_t seed) {
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
  }));
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

/// A response that has each field once.
EstimateResponse whole_response() {
  EstimateResponse response;
  response.session = "q/1";
  response.sequence = 1;
  response.timestamp = virtual_epoch;
  response.map_id = "lacet4";
  response.travelled_m = 1.5;
  response.start = EstimateResponse::Start{
      {1.0, 2.0, 0.5}, 0.002, 0.02, "east", 0.25, {0.125, 0.25, 0.375, 0.02, 0.03, 0.004, 0.005, 0.006, 0.007}};
  response.inputs.emplace_back(EstimateResponse::Odometry{0.01, 0.125, 0.02});
  response.inputs.emplace_back(EstimateResponse::Reading{7, {1.5, -1.5}, {0.02, -0.001}});
  response.estimates.push_back({"ekf",
                                "",
                                {1.25, -0.5, 0.75},
                                std::array<double, 9>{1, 2, 3, 4, 5, 6, 7, 8, 9},
                                0.375,
                                Pose2{1.5, -0.5, 0.75},
                                {{true, 0.5, 2}}});
  return response;
}

TEST(EstimateExchange, is_written_as_its_document_shows) {
  EXPECT_EQ(to_json(EstimateRequest{"q/1", 3, {"ekf", "arc"}, 7, 500, 4}),
            R"({"session":"q/1","sequence":3,"algorithms":["ekf","arc"],"seed":7,"particles":500,"horizon":4})");
  const std::string json = to_json(whole_response());
  EXPECT_THAT(
      json,
      ::testing::StartsWith(
          R"({"session":"q/1","sequence":1,"timestamp":"2023-07-11T00:00:00.000Z","mapId":"lacet4","fault":"",)"
          R"("travelled_m":1.5,"start":{"x":1,"y":2,"theta":0.5,"sigma_m":0.002,"thetaSigma":0.02,"section":"east",)"
          R"("along_m":0.25,"sensors":{"distance_variance_per_m":0.125,"turn_variance_per_m":0.25,)"
          R"("turn_variance_per_rad":0.375,"distance_scale_sigma":0.02,"turn_scale_sigma":0.03,)"
          R"("fiducial_along_sigma_m":0.004,"fiducial_across_sigma_m":0.005,"line_sigma_m":0.006,)"
          R"("line_heading_sigma_rad":0.007}},"inputs":[{"odometry":{"distance_m":0.01,"turn_rad":0.125,)"
          R"("duration_s":0.02}},{"reading":{"fiducial":7,"x_m":1.5,"y_m":-1.5,")"));
  EXPECT_THAT(
      json,
      ::testing::EndsWith(
          R"(_m":0.02,"left_m":-0.001}}],)"
          R"("estimates":[{"algorithm":"ekf","fault":"","x":1.25,"y":-0.5,"theta":0.75,"covariance":[1,2,3,4,5,6,7,8,9],)"
          R"("along_m":0.375,"next":{"x":1.5,"y":-0.5,"theta":0.75},"rectified":[{"accepted":true,"nis":0.5,"dimensions":2}]}]})"));
}

TEST(EstimateExchange, states_of_an_algorithm_that_failed_only_its_fault) {
  EstimateResponse response = whole_response();
  response.estimates[0].fault = "diverged";
  EXPECT_THAT(to_json(response), HasSubstr(R"("estimates":[{"algorithm":"ekf","fault":"diverged"}])"));
}

TEST(EstimateExchange, accepts_each_number_of_a_request_within_its_range_only) {
  test::expect_ranges(to_json(EstimateRequest{"q/1", 3, {"ekf"}, 1, 500, 4}), estimate_request_from_json,
                      {{"sequence", 1, 4294967295, 1},
                       {"seed", 0, 9007199254740992, 2},
                       {"particles", 1, 5000, 1},
                       {"horizon", 1, 1000, 1}});
}

TEST(EstimateExchange, accepts_each_number_of_a_response_within_its_range_only) {
  test::expect_ranges(to_json(whole_response()), estimate_response_from_json,
                      {{"sequence", 0, 4294967295, 1},
                       {"travelled_m", -1e9, 1e9},
                       {"start.x", -1e5, 1e5},
                       {"start.y", -1e5, 1e5},
                       {"start.theta", -100, 100},
                       {"start.sigma_m", 0, 1e12},
                       {"start.thetaSigma", 0, 1e12},
                       {"start.along_m", -1e9, 1e9},
                       {"start.sensors.distance_variance_per_m", 0, 1e12},
                       {"start.sensors.turn_variance_per_m", 0, 1e12},
                       {"start.sensors.turn_variance_per_rad", 0, 1e12},
                       {"start.sensors.distance_scale_sigma", 0, 1e12},
                       {"start.sensors.turn_scale_sigma", 0, 1e12},
                       {"start.sensors.fiducial_along_sigma_m", 0, 1e12},
                       {"start.sensors.fiducial_across_sigma_m", 0, 1e12},
                       {"start.sensors.line_sigma_m", 0, 1e12},
                       {"start.sensors.line_heading_sigma_rad", 0, 1e12},
                       {"inputs.0.odometry.distance_m", -1e9, 1e9},
                       {"inputs.0.odometry.turn_rad", -100, 100},
                       {"inputs.0.odometry.duration_s", 0, 1e6},
                       {"inputs.1.reading.fiducial", 0, 4294967295, 1},
                       {"inputs.1.reading.x_m", -1e5, 1e5},
                       {"inputs.1.reading.y_m", -1e5, 1e5},
                       {"inputs.1.reading.left_m", -1e5, 1e5},
                       {"estimates.0.x", -1e5, 1e5},
                       {"estimates.0.y", -1e5, 1e5},
                       {"estimates.0.theta", -100, 100},
                       {"estimates.0.along_m", -1e9, 1e9},
                       {"estimates.0.rectified.0.nis", 0, 1e12},
                       {"estimates.0.rectified.0.dimensions", 0, 255, 1}});
}

TEST(EstimateExchange, accepts_nine_covariances_of_at_most_1e12) {
  const auto with_covariance = [](const std::string& list) {
    std::string json = to_json(whole_response());
    const std::string numbers = "[1,2,3,4,5,6,7,8,9]";
    return estimate_response_from_json(json.replace(json.find(numbers), numbers.size(), list));
  };
  EXPECT_TRUE(with_covariance("[1e12,0,0,0,-1e12,0,0,0,1]"));
  EXPECT_FALSE(with_covariance("[1.0000001e12,0,0,0,1,0,0,0,1]"));
  EXPECT_FALSE(with_covariance("[-1.0000001e12,0,0,0,1,0,0,0,1]"));
  EXPECT_FALSE(with_covariance("[1,0,0,0,1,0,0,0]"));
  EXPECT_FALSE(with_covariance("[1,0,0,0,1,0,0,0,1,1]"));
  const auto without = with_covariance("null");
  ASSERT_TRUE(without);
  EXPECT_FALSE(without->estimates[0].covariance);
}

TEST(EstimateExchange, accepts_lists_and_names_up_to_their_longest) {
  const auto request = [](std::vector<std::string> algorithms) {
    return estimate_request_from_json(to_json(EstimateRequest{"q/1", 3, std::move(algorithms), 1, 500, 4}));
  };
  EXPECT_TRUE(request(std::vector<std::string>(16, "ekf")));
  EXPECT_FALSE(request(std::vector<std::string>(17, "ekf")));
  EXPECT_TRUE(request({std::string(128, 'a')}));
  EXPECT_FALSE(request({std::string(129, 'a')}));
  const auto response = [](std::size_t inputs, std::size_t fault_bytes) {
    EstimateResponse long_one = whole_response();
    long_one.inputs.resize(inputs, EstimateResponse::Odometry{});
    long_one.fault.assign(fault_bytes, 'x');
    return estimate_response_from_json(to_json(long_one));
  };
  EXPECT_TRUE(response(4096, 1024));
  EXPECT_FALSE(response(4097, 0));
  EXPECT_FALSE(response(2, 1025));
}

TEST(EstimateExchange, requires_every_field_that_is_not_optional) {
  EstimateResponse without_start = whole_response();
  without_start.start.reset();
  without_start.inputs.erase(without_start.inputs.begin());
  test::expect_required(
      to_json(without_start), estimate_response_from_json,
      {"session", "sequence", "timestamp", "mapId", "fault", "travelled_m", "inputs", "estimates",
       "inputs.0.reading.fiducial", "inputs.0.reading.x_m", "inputs.0.reading.y_m", "inputs.0.reading.left_m",
       "estimates.0.algorithm", "estimates.0.x", "estimates.0.y", "estimates.0.theta", "estimates.0.rectified",
       "estimates.0.rectified.0.accepted", "estimates.0.rectified.0.dimensions"});
  test::expect_required(to_json(whole_response()), estimate_response_from_json,
                        {"start.x", "start.y", "start.theta", "start.sigma_m", "start.thetaSigma", "start.along_m",
                         "start.sensors", "start.sensors.line_sigma_m", "inputs.0.odometry.distance_m",
                         "inputs.0.odometry.turn_rad", "inputs.0.odometry.duration_s"});
  test::expect_required(to_json(EstimateRequest{"q/1", 3, {"ekf"}, 1, 500, 4}), estimate_request_from_json,
                        {"session", "sequence", "algorithms", "seed", "particles", "horizon"});
}

TEST(EstimateExchange, reads_minus_zero_as_zero) {
  const std::string good = to_json(whole_response());
  const auto distance = estimate_response_from_json(test::with_value(good, "travelled_m", "-0.0"));
  ASSERT_TRUE(distance);
  EXPECT_EQ(distance->travelled_m, 0.0);
  EXPECT_FALSE(std::signbit(distance->travelled_m));
  std::string json = good;
  json.replace(json.find("[1,2,3,4,5,6,7,8,9]"), 19, "[-0.0,0,0,0,1,0,0,0,1]");
  const auto covariance = estimate_response_from_json(json);
  ASSERT_TRUE(covariance);
  EXPECT_EQ(covariance->estimates[0].covariance->at(0), 0.0);
  EXPECT_FALSE(std::signbit(covariance->estimates[0].covariance->at(0)));
}

TEST(EstimateExchange, of_neither_odometry_nor_a_reading_is_refused_and_of_both_is_the_odometry) {
  const auto with_input = [](const std::string& input) {
    std::string json = to_json(whole_response());
    const std::string odometry = R"("odometry":{"distance_m":0.01,"turn_rad":0.125,"duration_s":0.02})";
    return estimate_response_from_json(json.replace(json.find(odometry), odometry.size(), input));
  };
  const auto neither = with_input(R"("odometry":null,"reading":null)");
  ASSERT_FALSE(neither);
  EXPECT_EQ(neither.error().location, "inputs.0.");
  EXPECT_EQ(neither.error().message, "expected odometry or reading");
  const auto both = with_input(R"("reading":{},"odometry":{"distance_m":1,"turn_rad":2,"duration_s":3})");
  ASSERT_TRUE(both);
  EXPECT_EQ(both->inputs.at(0), EstimateResponse::Input(EstimateResponse::Odometry{1.0, 2.0, 3.0}));
}

TEST(EstimateExchange, accepts_an_estimate_without_what_its_algorithm_does_not_state) {
  EstimateResponse response = whole_response();
  response.start->section.reset();
  response.estimates[0].covariance.reset();
  response.estimates[0].along_m.reset();
  response.estimates[0].next.reset();
  response.estimates[0].rectified.assign(1, EstimateResponse::Rectified{});
  const std::string json = to_json(response);
  EXPECT_THAT(json, HasSubstr(R"("theta":0.75,"rectified":[{"accepted":false,"dimensions":0}]})"));
  EXPECT_THAT(json, HasSubstr(R"("thetaSigma":0.02,"along_m":0.25)"));
  EXPECT_EQ(estimate_response_from_json(json).value(), response);
}

TEST(EstimateExchange, does_not_read_the_estimate_of_an_algorithm_that_failed) {
  EstimateResponse response = whole_response();
  response.estimates[0].fault = "diverged";
  const auto read = estimate_response_from_json(to_json(response));
  ASSERT_TRUE(read);
  EXPECT_EQ(read->estimates.at(0).fault, "diverged");
  EXPECT_EQ(read->estimates.at(0).X_MB, Pose2{});
  EXPECT_FALSE(read->estimates.at(0).covariance);
  EXPECT_TRUE(read->estimates.at(0).rectified.empty());
}

TEST(EstimateExchange, accepts_sixteen_estimates) {
  EstimateResponse response = whole_response();
  response.estimates.resize(16, response.estimates.front());
  EXPECT_EQ(estimate_response_from_json(to_json(response)).value(), response);
  response.estimates.push_back(response.estimates.front());
  EXPECT_EQ(estimate_response_from_json(to_json(response)).error().location, "estimates");
}

}  // namespace
}  // namespace cosiva::wire
