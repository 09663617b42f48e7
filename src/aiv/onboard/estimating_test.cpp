#include "cosiva/aiv/onboard/estimating.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <memory>
#include <string>

#include "cosiva/aiv/testing/test_zone.h"

namespace cosiva::aiv {
namespace {

using std::chrono::milliseconds;
using test::lacet4;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using ::testing::SizeIs;
using wire::EstimateResponse;

/// A vehicle that drives along lacet4's first section at 0.5 m/s, and receives requests.
class Requested {
 public:
  Requested() : zone_{std::make_shared<zone::TrafficZone>(lacet4())} {}

  void request_estimate(std::uint32_t sequence, std::vector<std::string> algorithms = {},
                        const std::string& session = "q/1") {
    estimating.on_request(now, {session, sequence, std::move(algorithms), 1, 500, 4});
  }
  void step() {
    now += milliseconds{20};
    s_m += step_m;
    estimating.on_odometry(now, {now, step_m, 0.0, 0.5, known ? std::optional{current_estimate()} : std::nullopt});
  }
  void read(zone::TagNumber number) { estimating.on_tag(number, now, *zone_, current_estimate().X_MB); }
  /// The response that is due now.
  std::optional<EstimateResponse> received() {
    const auto json = estimating.take_response();
    if (!json) return std::nullopt;
    const auto response = wire::estimate_response_from_json(*json);
    EXPECT_TRUE(response) << *json;
    return response ? std::optional{*response} : std::nullopt;
  }
  EstimateResponse response() {
    step();
    const auto response = received();
    EXPECT_TRUE(response);
    return response.value_or(EstimateResponse{});
  }
  [[nodiscard]] Estimating::CurrentEstimate current_estimate() const {
    const zone::TrackPosition position{section, s_m};
    return {zone_, zone_->circuit.pose_at(position), position, 0.002};
  }

  Estimating estimating;
  SimTime now{std::chrono::hours{24}};
  zone::SectionId section{0};
  double s_m{0.1};
  double step_m{0.01};
  bool known{true};

 private:
  std::shared_ptr<zone::TrafficZone> zone_;
};

TEST(Estimating, responds_with_the_next_odometry_first_with_the_start_and_then_with_the_estimate_of_each_algorithm) {
  Requested vehicle;
  vehicle.request_estimate(1, {"dead_reckoning", "ekf"});
  EXPECT_FALSE(vehicle.received());  // the request is for the next position
  const EstimateResponse first = vehicle.response();
  ASSERT_TRUE(first.start);
  EXPECT_EQ(first.start->section, "east");
  EXPECT_NEAR(first.start->along_m, 0.11, 1e-12);
  EXPECT_EQ(first.map_id, "lacet4");
  EXPECT_THAT(first.inputs, IsEmpty());
  vehicle.step();
  vehicle.step();
  EXPECT_FALSE(vehicle.received());  // there is no request
  vehicle.request_estimate(2);
  const EstimateResponse second = vehicle.response();
  EXPECT_FALSE(second.start);
  EXPECT_EQ(second.timestamp, vehicle.now);
  EXPECT_NEAR(second.travelled_m, 0.03, 1e-12);
  EXPECT_THAT(second.inputs, SizeIs(3));
  ASSERT_THAT(second.estimates, SizeIs(2));
  EXPECT_EQ(second.estimates[0].algorithm, "dead_reckoning");
  for (const auto& estimate : second.estimates) {
    EXPECT_LT(distance(estimate.X_MB, vehicle.current_estimate().X_MB), 1e-9);
    EXPECT_TRUE(estimate.covariance);
  }
}

TEST(Estimating, repeats_a_lost_response_and_ignores_a_late_request) {
  Requested vehicle;
  vehicle.request_estimate(1, {"ekf"});
  vehicle.response();
  vehicle.request_estimate(2);
  const EstimateResponse published = vehicle.response();
  vehicle.step();
  vehicle.request_estimate(2);
  EXPECT_EQ(vehicle.received(), published);  // at once: the response is stored
  vehicle.request_estimate(1, {"ekf"});
  vehicle.step();
  EXPECT_FALSE(vehicle.received());
  vehicle.request_estimate(3);
  const EstimateResponse next = vehicle.response();
  EXPECT_THAT(next.inputs, SizeIs(3)) << "no input is repeated, and none is left out";
  EXPECT_NEAR(next.travelled_m - published.travelled_m, 0.03, 1e-12);
}

TEST(Estimating, reports_readings_as_the_antenna_measures_them_and_the_result_of_each_algorithm) {
  Requested vehicle;
  const zone::Tag& tag = *lacet4().tags.begin();
  vehicle.section = tag.position.section;
  vehicle.s_m = tag.position.s_m - 0.05;
  vehicle.request_estimate(1, {"dead_reckoning", "arc_kalman"});
  vehicle.response();
  vehicle.step();
  vehicle.read(tag.number);
  vehicle.read(999'999);  // not a tag of the zone
  vehicle.request_estimate(2);
  const EstimateResponse response = vehicle.response();
  ASSERT_THAT(response.inputs, SizeIs(3));
  const auto& reading = std::get<EstimateResponse::Reading>(response.inputs[1]);
  EXPECT_EQ(reading.fiducial, tag.number);
  // At the rim, 2 cm ahead, 20 ms before the number was read: 1 cm at 0.5 m/s.
  EXPECT_NEAR(reading.detected_B.x_m, 0.01, 1e-9);
  EXPECT_NEAR(reading.detected_B.y_m, 0.0, 1e-9);
  EXPECT_THAT(response.estimates[0].rectified, SizeIs(1));
  EXPECT_FALSE(response.estimates[0].rectified[0].accepted);
  EXPECT_TRUE(response.estimates[1].rectified[0].accepted);
}

TEST(Estimating, refuses_impossible_requests_and_names_the_existing_algorithms) {
  Requested vehicle;
  vehicle.request_estimate(1, {"ekf", "magic"});
  EXPECT_THAT(vehicle.response().fault, AllOf(HasSubstr("magic"), HasSubstr("arc_kalman")));
  vehicle.request_estimate(1, {"arc_smoother", "ekf"}, "q/2");
  const EstimateResponse response = vehicle.response();
  EXPECT_THAT(response.fault, IsEmpty());
  EXPECT_THAT(response.estimates[0].fault, HasSubstr("needs a whole run"));
  EXPECT_THAT(response.estimates[1].fault, IsEmpty());
  vehicle.known = false;
  vehicle.request_estimate(1, {"ekf"}, "q/3");
  EXPECT_THAT(vehicle.response().fault, HasSubstr("position is not known"));
}

TEST(Estimating, refuses_a_session_from_before_its_start) {
  Requested vehicle;
  vehicle.request_estimate(7);
  const auto response = vehicle.received();
  ASSERT_TRUE(response);
  EXPECT_THAT(response->fault, HasSubstr("restarted"));
  EXPECT_EQ(response->sequence, 7U);
}

TEST(Estimating, ends_a_session_without_requests_or_after_a_zone_switch) {
  Requested forgotten;
  forgotten.step_m = 0.0;
  forgotten.request_estimate(1, {"ekf"});
  forgotten.response();
  for (int i = 0; i < 50 * 62; ++i) forgotten.step();
  EXPECT_FALSE(forgotten.estimating.busy());

  Requested switched;
  switched.request_estimate(1, {"ekf"});
  switched.response();
  switched.estimating.on_zone_switched();
  switched.request_estimate(2);
  EXPECT_THAT(switched.response().fault, HasSubstr("switched"));
  EXPECT_FALSE(switched.estimating.busy());
}

TEST(Estimating, has_a_particle_filter_that_its_seed_determines) {
  Requested one;
  Requested other;
  for (Requested* vehicle : {&one, &other}) {
    vehicle->request_estimate(1, {"particles"});
    vehicle->response();
    for (int i = 0; i < 20; ++i) vehicle->step();
    vehicle->request_estimate(2);
  }
  EXPECT_EQ(one.response(), other.response());
}

TEST(BoardClock, dates_a_reading_correctly_whatever_the_delay_of_its_frame) {
  BoardClock clock;
  const SimTime power_up{std::chrono::hours{24}};
  const auto received_after = [&](std::uint32_t board_ms, milliseconds late) {
    return clock.stamp(power_up + milliseconds{board_ms} + late, board_ms) - (power_up + milliseconds{board_ms});
  };
  EXPECT_EQ(received_after(1000, milliseconds{5}), milliseconds{5});  // there is no better offset yet
  EXPECT_EQ(received_after(1020, milliseconds{1}), milliseconds{1});
  EXPECT_LT(received_after(1040, milliseconds{30}) - milliseconds{1}, std::chrono::microseconds{10});
  EXPECT_LT(received_after(1060, milliseconds{300}) - milliseconds{1}, std::chrono::microseconds{50});
  // The board counts from zero again.
  const SimTime again = power_up + milliseconds{5000};
  EXPECT_EQ(clock.stamp(again, 3), again);
}

}  // namespace
}  // namespace cosiva::aiv
