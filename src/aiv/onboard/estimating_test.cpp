#include "cosiva/aiv/onboard/estimating.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <memory>
#include <string>

#include "cosiva/base/math.h"

#include "cosiva/aiv/testing/test_graphs.h"
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
  /// A step that leads the vehicle elsewhere than along its section.
  void step_with(double distance_m, double turn_rad, std::optional<Estimating::CurrentEstimate> estimate) {
    now += milliseconds{20};
    estimating.on_odometry(now, {now, distance_m, turn_rad, 0.5, std::move(estimate)});
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
  std::uint32_t last_sequence{1};
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

TEST(Estimating, begins_where_the_vehicle_s_own_estimate_is_and_states_its_sensors) {
  Requested vehicle;
  vehicle.request_estimate(1, {"ekf"});
  const EstimateResponse response = vehicle.response();
  ASSERT_TRUE(response.start);
  EXPECT_EQ(response.session, "q/1");
  EXPECT_EQ(response.sequence, 1U);
  EXPECT_EQ(response.timestamp, vehicle.now);
  EXPECT_EQ(response.travelled_m, 0.0);
  EXPECT_LT(distance(response.start->X_MB, vehicle.current_estimate().X_MB), 1e-12);
  EXPECT_EQ(response.start->sigma_m, 0.0025) << "no position is better than a reading";
  EXPECT_EQ(response.start->heading_sigma_rad, 0.02);
  const estimation::SensorModel sensors = data_sheet();
  EXPECT_EQ(response.start->sensors,
            (wire::EstimateSensors{
                sensors.distance_variance_per_m, sensors.turn_variance_per_m, sensors.turn_variance_per_rad,
                sensors.distance_scale_sigma, sensors.turn_scale_sigma, sensors.fiducial_along_sigma_m,
                sensors.fiducial_across_sigma_m, sensors.line_sigma_m, sensors.line_heading_sigma_rad}));
  vehicle.request_estimate(1, {"ekf"}, "q/2");
  auto uncertain = vehicle.current_estimate();
  uncertain.sigma_m = 0.125;
  vehicle.step_with(0.01, 0.0, uncertain);
  EXPECT_EQ(vehicle.received()->start->sigma_m, 0.125);
}

TEST(Estimating, states_the_quality_of_the_data_sheet) {
  const estimation::SensorModel sensors = data_sheet();
  EXPECT_DOUBLE_EQ(std::sqrt(sensors.distance_variance_per_m), 0.003);
  EXPECT_EQ(sensors.distance_scale_sigma, 0.005);
  EXPECT_EQ(sensors.fiducial_along_sigma_m, 0.0025);
  EXPECT_EQ(sensors.fiducial_across_sigma_m, 0.002);
  EXPECT_EQ(sensors.line_sigma_m, 0.001);
}

TEST(Estimating, begins_off_every_path_without_section) {
  Requested vehicle;
  vehicle.request_estimate(1, {"ekf"});
  auto off_path = vehicle.current_estimate();
  off_path.position.reset();
  vehicle.step_with(0.01, 0.0, off_path);
  const auto response = vehicle.received();
  ASSERT_TRUE(response && response->start);
  EXPECT_FALSE(response->start->section);
  EXPECT_EQ(response->start->along_m, 0.0);
  vehicle.step_with(0.75, 0.0, off_path);
  vehicle.request_estimate(2);
  vehicle.step_with(0.75, 0.0, off_path);
  EXPECT_THAT(vehicle.received()->fault, IsEmpty()) << "there is no loop to leave";
}

TEST(Estimating, reports_each_step_that_moves_or_turns_with_its_duration) {
  Requested vehicle;
  vehicle.request_estimate(1, {"ekf"});
  vehicle.response();
  const auto here = vehicle.current_estimate();
  vehicle.step_with(0.0, 0.0, here);  // nothing has moved
  vehicle.step_with(-0.25, 0.0, here);
  vehicle.step_with(0.0, 0.125, here);
  vehicle.step_with(0.5, 0.25, std::nullopt);  // the position is not known
  vehicle.request_estimate(2);
  vehicle.step_with(0.125, -0.5, here);
  const auto response = vehicle.received();
  ASSERT_TRUE(response);
  EXPECT_DOUBLE_EQ(response->travelled_m, 0.375);
  EXPECT_THAT(response->inputs,
              ::testing::ElementsAre(EstimateResponse::Input{EstimateResponse::Odometry{-0.25, 0.0, 0.02}},
                                     EstimateResponse::Input{EstimateResponse::Odometry{0.0, 0.125, 0.02}},
                                     EstimateResponse::Input{EstimateResponse::Odometry{0.125, -0.5, 0.02}}));
}

TEST(Estimating, ends_the_session_of_a_vehicle_that_has_left_its_loop_by_more_than_half_a_metre) {
  const auto fault_after = [](int steps) {
    Requested vehicle;
    vehicle.request_estimate(1, {"ekf"});
    vehicle.response();
    auto elsewhere = vehicle.current_estimate();
    elsewhere.position->section = zone::no_section;
    for (int i = 1; i < steps; ++i) vehicle.step_with(0.25, 0.0, elsewhere);
    vehicle.request_estimate(2);
    vehicle.step_with(0.25, 0.0, elsewhere);
    return vehicle.received()->fault;
  };
  EXPECT_THAT(fault_after(2), IsEmpty()) << "half a metre";
  EXPECT_THAT(fault_after(3), HasSubstr("left the loop"));
}

TEST(Estimating, ignores_requests_that_are_too_early_or_too_late) {
  Requested vehicle;
  vehicle.request_estimate(1, {"ekf"});
  vehicle.response();
  for (const std::uint32_t sequence : {0U, 3U, 7U}) {
    vehicle.request_estimate(sequence);
    vehicle.step();
    EXPECT_FALSE(vehicle.received()) << sequence;
  }
  vehicle.request_estimate(2);
  EXPECT_EQ(vehicle.response().sequence, 2U);
}

TEST(Estimating, ends_the_session_when_another_client_begins_one) {
  Requested vehicle;
  vehicle.request_estimate(1, {"ekf"}, "q/1");
  vehicle.response();
  vehicle.request_estimate(1, {"ekf"}, "q/2");
  EXPECT_EQ(vehicle.response().session, "q/2");
  vehicle.request_estimate(2, {}, "q/1");
  const auto refused = vehicle.received();
  ASSERT_TRUE(refused);
  EXPECT_EQ(refused->session, "q/1");
  EXPECT_EQ(refused->timestamp, vehicle.now);
  EXPECT_THAT(refused->fault, HasSubstr("client began a session"));
}

TEST(Estimating, ends_a_session_more_than_a_minute_after_its_last_request) {
  Requested vehicle;
  vehicle.step_m = 0.0;
  vehicle.request_estimate(1, {"ekf"});
  const SimTime requested = vehicle.now;
  vehicle.response();
  while (vehicle.now < requested + std::chrono::minutes{1}) vehicle.step();
  EXPECT_TRUE(vehicle.estimating.busy());
  vehicle.step();
  EXPECT_FALSE(vehicle.estimating.busy());
}

TEST(Estimating, ends_a_session_whose_inputs_no_longer_fit_a_response) {
  Requested vehicle;
  vehicle.request_estimate(1, {"dead_reckoning"});
  vehicle.response();
  const auto here = vehicle.current_estimate();
  const auto step = [&] {
    vehicle.now += milliseconds{1};
    vehicle.estimating.on_odometry(vehicle.now, {vehicle.now, 1e-6, 0.0, 0.5, here});
  };
  for (int i = 0; i < 4094; ++i) step();
  EXPECT_TRUE(vehicle.estimating.busy());
  vehicle.request_estimate(2);
  step();
  EXPECT_FALSE(vehicle.estimating.busy());
  EXPECT_THAT(vehicle.received()->fault, HasSubstr("ended before its response"));
}

TEST(Estimating, reports_a_tag_at_the_rim_of_the_antenna_when_its_number_came_into_the_field) {
  Requested vehicle;
  vehicle.request_estimate(1, {"dead_reckoning"});
  vehicle.response();
  vehicle.step();  // the first step after the beginning gives the speed
  const auto reading_of = [&](const Pose2& X_MB, milliseconds age) {
    vehicle.estimating.on_tag(1, vehicle.now - age, lacet4(), X_MB);
    vehicle.request_estimate(++vehicle.last_sequence);
    const EstimateResponse response = vehicle.response();
    for (const auto& input : response.inputs) {
      if (const auto* reading = std::get_if<EstimateResponse::Reading>(&input)) return *reading;
    }
    return EstimateResponse::Reading{};
  };
  const Pose2 on_path = lacet4().circuit.pose_at(lacet4().find_tag(1)->position);
  const auto turned = [&](double angle_rad) { return on_path * Pose2{0.0, 0.0, angle_rad}; };
  // The rim is 2 cm in front; the number comes 20 ms later, in which the vehicle drives 1 cm.
  const auto straight = reading_of(on_path, milliseconds{0});
  EXPECT_LT(distance(straight.fiducial_M, position(on_path)), 1e-12);
  EXPECT_NEAR(straight.detected_B.x_m, 0.02 - 0.5 * 0.02, 1e-12);
  EXPECT_NEAR(reading_of(on_path, milliseconds{10}).detected_B.x_m, 0.02 - 0.5 * 0.03, 1e-12);
  EXPECT_NEAR(reading_of(turned(1.0), milliseconds{0}).detected_B.x_m, 0.01, 1e-12) << "less than 60 degrees";
  // No path leads in that direction: the mean over all points of entry is a quarter of pi times the antenna's range.
  const auto across = reading_of(turned(1.1), milliseconds{0});
  EXPECT_NEAR(across.detected_B.x_m, 0.25 * pi * 0.02 - 0.01, 1e-12);
  EXPECT_EQ(across.detected_B.y_m, 0.0);
}

TEST(Estimating, ignores_readings_while_it_drives_backwards_or_is_not_in_a_session) {
  Requested vehicle;
  vehicle.read(1);  // no session
  vehicle.request_estimate(1, {"ekf"});
  vehicle.response();
  vehicle.now += milliseconds{20};
  vehicle.estimating.on_odometry(vehicle.now, {vehicle.now, -0.01, 0.0, -0.1, vehicle.current_estimate()});
  vehicle.read(1);
  vehicle.request_estimate(2);
  EXPECT_THAT(vehicle.response().inputs, SizeIs(2)) << "odometry only";
}

TEST(Estimating, passes_the_seed_to_the_algorithms) {
  const auto estimate = [](std::uint64_t seed) {
    Requested vehicle;
    vehicle.estimating.on_request(vehicle.now, {"q/1", 1, {"particles"}, seed, 50, 4});
    vehicle.response();
    for (int i = 0; i < 20; ++i) vehicle.step();
    vehicle.request_estimate(2);
    return vehicle.response().estimates.at(0).X_MB;
  };
  EXPECT_EQ(estimate(1), estimate(1));
  EXPECT_NE(estimate(1), estimate(2));
}

TEST(BoardClock, drifts_by_at_most_a_ten_thousandth) {
  BoardClock clock;
  const SimTime power_up{std::chrono::hours{24}};
  EXPECT_EQ(clock.stamp(power_up + milliseconds{1000}, 1000), power_up + milliseconds{1000});
  // 101 s later with a delay of a second: the offset may have grown by 101 s / 10 000.
  EXPECT_EQ(clock.stamp(power_up + milliseconds{102'000}, 101'000),
            power_up + milliseconds{101'000} + std::chrono::microseconds{10'100});
}

TEST(BoardClock, takes_a_change_of_more_than_a_second_for_a_clock_that_was_set) {
  const SimTime power_up{std::chrono::hours{24}};
  const auto stamped_after = [&](SimDuration jump) {
    BoardClock clock;
    (void)clock.stamp(power_up, 1000);
    // The board has counted nothing since; the program's clock has jumped.
    return clock.stamp(power_up + jump, 1000) - power_up;
  };
  // The offset grows by a ten-thousandth of the jump before the two are compared.
  EXPECT_EQ(stamped_after(std::chrono::seconds{1}), std::chrono::microseconds{100});
  EXPECT_EQ(stamped_after(std::chrono::seconds{2}), std::chrono::seconds{2});
  EXPECT_EQ(stamped_after(-std::chrono::seconds{1}), -std::chrono::seconds{1}) << "a smaller offset is always better";
}

TEST(Estimating, shortens_its_reason_to_what_a_response_holds) {
  Requested vehicle;
  vehicle.request_estimate(1, {std::string(2000, 'm')});
  EXPECT_EQ(vehicle.response().fault.size(), EstimateResponse::fault_bytes_max);
}

TEST(Estimating, accepts_readings_at_standstill) {
  Requested vehicle;
  vehicle.request_estimate(1, {"ekf"});
  vehicle.response();
  vehicle.now += milliseconds{20};
  vehicle.estimating.on_odometry(vehicle.now, {vehicle.now, 0.0, 0.0, 0.0, vehicle.current_estimate()});
  vehicle.read(1);
  vehicle.step_m = 0.0;
  vehicle.request_estimate(2);
  const EstimateResponse response = vehicle.response();
  ASSERT_THAT(response.inputs, SizeIs(1));
  EXPECT_EQ(std::get<EstimateResponse::Reading>(response.inputs[0]).fiducial, 1U);
}

TEST(Estimating, reports_a_beacon_at_the_rim_of_the_antenna_and_as_far_off_the_path_as_it_lies) {
  Requested vehicle;
  vehicle.request_estimate(1, {"dead_reckoning"});
  vehicle.response();
  const auto detected_off_path = [&](double off_m) {
    zone::TrafficZone zone = lacet4();
    zone.beacons = zone::BeaconGrid{1.0, {-0.5, -0.15 + off_m}, 1, 1};  // east leads along y = -0.15 m
    vehicle.step();
    vehicle.estimating.on_tag(zone.beacons->first_number, vehicle.now, zone, {-0.5, -0.15, 0.0});
    vehicle.request_estimate(++vehicle.last_sequence);
    const EstimateResponse response = vehicle.response();
    for (const auto& input : response.inputs) {
      if (const auto* reading = std::get_if<EstimateResponse::Reading>(&input)) return reading->detected_B;
    }
    return Point2{9.0, 9.0};
  };
  // The field reaches 2 cm; the number comes 20 ms later, at 0.5 m/s.
  for (const double side : {-1.0, 1.0}) {
    EXPECT_NEAR(detected_off_path(side * 0.012).x_m, 0.016 - 0.01, 1e-9);
    EXPECT_NEAR(detected_off_path(side * 0.012).y_m, side * 0.012, 1e-9);
  }
  EXPECT_NEAR(detected_off_path(0.021).x_m, 0.25 * pi * 0.02 - 0.01, 1e-9) << "beyond the field";
  EXPECT_EQ(detected_off_path(0.021).y_m, 0.0);
}

TEST(Estimating, reports_zeros_without_a_sign) {
  Requested vehicle;
  vehicle.request_estimate(1, {"dead_reckoning"});
  vehicle.response();
  vehicle.step();
  // At the start of a section that leads west, left is −1·0 − sin π·0 = −0.
  zone::TrafficZone zone = test::graph("west", {{"west", {0.0, 0.0, pi}, 1.0, 0.0, {}}}, {});
  zone.tags = {{7, {0, 0.0}}};
  vehicle.estimating.on_tag(7, vehicle.now, zone, {0.0, 0.0, pi});
  vehicle.request_estimate(++vehicle.last_sequence);
  vehicle.step();
  const auto json = vehicle.estimating.take_response();
  ASSERT_TRUE(json);
  EXPECT_THAT(*json, HasSubstr(R"("left_m":0})"));
}

TEST(Estimating, returns_to_its_loop_without_a_trace) {
  Requested vehicle;
  vehicle.request_estimate(1, {"ekf"});
  vehicle.response();
  const auto on_loop = vehicle.current_estimate();
  auto elsewhere = on_loop;
  elsewhere.position->section = zone::no_section;
  for (int times = 0; times < 3; ++times) {
    vehicle.step_with(0.25, 0.0, elsewhere);
    vehicle.step_with(-0.25, 0.0, elsewhere);
    vehicle.step_with(0.25, 0.0, on_loop);
  }
  vehicle.request_estimate(2);
  vehicle.step_with(0.25, 0.0, on_loop);
  EXPECT_THAT(vehicle.received()->fault, IsEmpty());
}

// The next position is that of the path after the move: on lacet4's first section, straight.
TEST(Estimating, responds_with_the_position_after_the_requested_move) {
  Requested vehicle;
  vehicle.request_estimate(1, {"dead_reckoning", "ekf"});
  for (const auto& estimate : vehicle.response().estimates) EXPECT_FALSE(estimate.next) << "no move was named";
  wire::EstimateRequest request{"q/1", 2, {}, 1, 500, 4, 0.25};
  vehicle.estimating.on_request(vehicle.now, request);
  const EstimateResponse response = vehicle.response();
  ASSERT_THAT(response.estimates, SizeIs(2));
  for (const auto& estimate : response.estimates) {
    ASSERT_TRUE(estimate.next) << estimate.algorithm;
    Requested later;
    later.s_m = vehicle.s_m + 0.25;
    EXPECT_LT(distance(*estimate.next, later.current_estimate().X_MB), 1e-6) << estimate.algorithm;
  }
}

}  // namespace
}  // namespace cosiva::aiv
