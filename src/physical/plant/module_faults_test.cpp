// Line tracking and faults of the modules of emulated vehicles (A15, A16, A18), as their boards report them.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>

#include "cosiva/physical/boards/line_tracker.h"
#include "cosiva/physical/plant/plant_fixture.h"
#include "cosiva/physical/plant/test_zones.h"
#include "cosiva/physical/plant/vehicle_faults.h"

namespace cosiva::physical {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;
using wire::BoardPart;
using wire::Finding;

constexpr wire::Drive cruise{400, 800, 1000, 0};

class ModuleFaults : public testing::Test {
 protected:
  void inject(const std::string& fault) {
    fixture.feed(wire::InputKind::command, "operator", R"({"setFault":{"vehicle":1,)" + fault + "}}");
  }
  [[nodiscard]] std::uint8_t code() const { return fixture.received<wire::Heartbeat>(1).back().self_test; }
  [[nodiscard]] std::uint8_t any_code() const {
    std::uint8_t found = 0;
    for (const auto& heartbeat : fixture.received<wire::Heartbeat>(1)) found = std::max(found, heartbeat.self_test);
    return found;
  }
  void request_self_test(std::uint8_t number) {
    wire::module_link::Encoder encoder;
    for (const Board board : wire::all_boards)
      fixture.feed(wire::InputKind::bytes, wire::port_name(1, board), encoder.encode(wire::SelfTestRequest{number}));
    fixture.run_for(100ms);
  }
  PlantFixture fixture{lacet4()};
};

TEST_F(ModuleFaults, a_stuck_sensor_is_found_within_a_quarter_of_a_second_and_stops_the_vehicle) {
  fixture.drive(1, cruise);
  fixture.run_for(2s);
  EXPECT_EQ(any_code(), 0);
  ASSERT_GT(fixture.ground_truth(1).speed_mps, 0.3);
  inject(R"("fault":"stuck_sensor","sensor":7)");
  fixture.run_for(250ms);
  EXPECT_EQ(any_code(), wire::fault_code({BoardPart::DEMS, Finding::implausible}));
  fixture.run_for(750ms);
  EXPECT_EQ(fixture.ground_truth(1).speed_mps, 0.0);
  const auto parts = fixture.received<wire::PilsParts>(1).back();
  EXPECT_EQ(parts.reading[7], 255);
}

TEST_F(ModuleFaults, a_fault_stays_until_a_self_test_passes) {
  fixture.drive(1, cruise);
  fixture.run_for(1s);
  inject(R"("fault":"stuck_sensor","for_s":2)");
  fixture.run_for(1500ms);
  request_self_test(1);
  ASSERT_EQ(fixture.received<wire::SelfTestResult>(1).size(), 4U);
  EXPECT_THAT(
      fixture.received<wire::SelfTestResult>(1).front().parts,
      ElementsAre(wire::PartFinding{BoardPart::controller}, wire::PartFinding{BoardPart::BRAC},
                  wire::PartFinding{BoardPart::DEMS, Finding::implausible}, wire::PartFinding{BoardPart::PMOT}));
  fixture.run_for(1s);
  fixture.forget();
  fixture.run_for(1s);
  EXPECT_EQ(any_code(), 0x32) << "the sensor works again, but no test has passed";
  EXPECT_EQ(fixture.ground_truth(1).speed_mps, 0.0);
  request_self_test(2);
  fixture.forget();
  fixture.run_for(2s);
  EXPECT_EQ(any_code(), 0);
  EXPECT_GT(fixture.ground_truth(1).speed_mps, 0.3);
}

TEST_F(ModuleFaults, a_dead_motor_turns_the_body_and_is_found_before_a_quarter_turn) {
  fixture.drive(1, cruise);
  fixture.run_for(2s);
  const double heading_rad = fixture.ground_truth(1).X_MB.heading_rad;
  inject(R"("fault":"dead_motor","motor":"right")");
  fixture.run_for(1s);
  EXPECT_EQ(any_code(), wire::fault_code({BoardPart::PMOT, Finding::does_not_turn}));
  EXPECT_EQ(fixture.ground_truth(1).speed_mps, 0.0);
  const double turned_rad = wrap_angle(fixture.ground_truth(1).X_MB.heading_rad - heading_rad);
  EXPECT_LT(turned_rad, -0.05) << "around its right wheel";
  EXPECT_GT(turned_rad, -0.5 * pi);
  request_self_test(1);
  EXPECT_EQ(fixture.received<wire::SelfTestResult>(1).front().parts.back(),
            (wire::PartFinding{BoardPart::PMOT, Finding::does_not_turn}));
}

TEST_F(ModuleFaults, a_failed_reader_reads_no_tag_and_is_in_the_heartbeats_until_it_works_and_is_tested) {
  fixture.drive(1, cruise);
  inject(R"("fault":"failed_reader","for_s":30)");
  fixture.run_for(29s);  // two thirds of a lap, with eight tags
  EXPECT_TRUE(fixture.received<wire::TagRead>(1).empty());
  EXPECT_EQ(any_code(), wire::fault_code({BoardPart::RFID, Finding::no_response}));
  EXPECT_GT(fixture.ground_truth(1).speed_mps, 0.3) << "the board PRAV alone does not stop a vehicle";
  fixture.run_for(2s);
  request_self_test(1);
  fixture.forget();
  fixture.run_for(10s);
  EXPECT_FALSE(fixture.received<wire::TagRead>(1).empty());
  EXPECT_EQ(any_code(), 0);
}

TEST_F(ModuleFaults, a_brown_out_silences_all_boards_and_they_start_anew_with_their_odometer_at_zero) {
  fixture.drive(1, cruise);
  fixture.run_for(3s);
  const auto session = fixture.received<wire::Hello>(1).front().session;
  inject(R"("fault":"brown_out","for_s":1)");
  fixture.forget();
  fixture.run_for(990ms);
  EXPECT_TRUE(fixture.received<wire::Heartbeat>(1).empty());
  EXPECT_TRUE(fixture.received<wire::Odometry>(1).empty());
  fixture.fall_unresponsive(1);
  fixture.run_for(500ms);
  ASSERT_EQ(fixture.received<wire::Hello>(1).size(), 4U);
  EXPECT_NE(fixture.received<wire::Hello>(1).front().session, session);
  EXPECT_EQ(fixture.received<wire::Odometry>(1).back().distance_um, 0);
  EXPECT_EQ(fixture.ground_truth(1).speed_mps, 0.0) << "without supply the motors do not turn";
}

TEST_F(ModuleFaults, all_end_with_none) {
  inject(R"("fault":"failed_reader")");
  fixture.run_for(200ms);
  EXPECT_NE(any_code(), 0);
  inject(R"("fault":"none")");
  request_self_test(1);
  fixture.forget();
  fixture.run_for(300ms);
  EXPECT_EQ(any_code(), 0);
}

TEST_F(ModuleFaults, outlast_a_restart_of_the_plant) {
  fixture.drive(1, cruise);
  inject(R"("fault":"dead_motor")");
  inject(R"("fault":"failed_reader")");
  fixture.run_for(500ms);
  fixture.restart();
  fixture.forget();
  fixture.run_for(1s);
  EXPECT_NE(any_code(), 0);
  request_self_test(1);
  EXPECT_EQ(fixture.received<wire::SelfTestResult>(1).front().parts.back().finding, Finding::does_not_turn);
}

TEST_F(ModuleFaults, are_refused_with_the_wrong_field) {
  const auto refusal = [&](const std::string& fault) {
    fixture.logged.clear();
    inject(fault);
    return fixture.logged.empty() ? std::string{} : fixture.logged.back();
  };
  EXPECT_THAT(refusal(R"("fault":"stuck")"), HasSubstr("fault: expected stuck_sensor, dead_motor, failed_reader"));
  EXPECT_THAT(refusal(R"("fault":"brown_out")"), HasSubstr("for_s: expected seconds above 0, up to 10"));
  EXPECT_THAT(refusal(R"("fault":"brown_out","for_s":11)"), HasSubstr("for_s: "));
  EXPECT_THAT(refusal(R"("fault":"stuck_sensor","sensor":8)"),
              HasSubstr("sensor: expected a whole number from 0 to 7"));
  EXPECT_THAT(refusal(R"("fault":"stuck_sensor","reading":256)"), HasSubstr("reading: "));
  EXPECT_THAT(refusal(R"("fault":"dead_motor","motor":"both")"), HasSubstr("motor: expected left or right"));
  EXPECT_EQ(refusal(R"("fault":"dead_motor","motor":"right","for_s":0.5)"), "");
}

TEST(PilsParts, measure_the_line_the_wheels_and_the_supply) {
  PlantFixture fixture{lacet4()};
  fixture.drive(1, cruise);
  fixture.run_for(12s);
  const auto all = fixture.received<wire::PilsParts>(1);
  EXPECT_NEAR(static_cast<double>(all.size()), 24.0, 1.0) << "2 Hz";
  double difference_max = 0.0;
  for (const wire::PilsParts& parts : all) {
    EXPECT_EQ(parts.plugs, 7);
    EXPECT_LE(parts.supply_mv, 5000);
    EXPECT_GT(parts.supply_mv, 4800);
    int sum = 0;
    for (const std::uint8_t reading : parts.reading) sum += reading;
    EXPECT_NEAR(sum, 255.0 * 19.0 / 8.0, 4.0) << "the whole width of the line";
    difference_max = std::max(difference_max, std::fabs(parts.left.speed_mmps - parts.right.speed_mmps) * 1e-3);
  }
  // In the loops of 0.6 m radius: v · track / r.
  EXPECT_NEAR(difference_max, 0.4 * 0.1 / 0.6, 0.02);
  EXPECT_GT(all.back().left.current_ma, 0);
}

TEST(LineTrackingChoice, is_made_for_each_vehicle_and_changes_how_it_follows_its_line) {
  PlantFixture fixture{lacet4(), 2};
  fixture.options.equipment = *read_equipment(2, {"centroid_pd", "2=threshold"}, {});
  fixture.restart();
  fixture.drive(1, cruise);
  fixture.drive(2, cruise);
  fixture.run_for(20s);
  const auto rms_mm = [&](std::uint32_t vehicle) {
    double sum = 0.0;
    const auto all = fixture.received<wire::Odometry>(vehicle);
    for (const auto& odometry : all) sum += 0.01 * odometry.line_offset_01mm * odometry.line_offset_01mm;
    return std::sqrt(sum / static_cast<double>(all.size()));
  };
  EXPECT_NE(rms_mm(1), rms_mm(2));
  EXPECT_GT(fixture.ground_truth(2).distance_m, 5.0);
}

TEST(Equipment, is_read_from_the_options_of_a_command_line) {
  EXPECT_TRUE(read_equipment(3, {}, {})->empty());
  const auto equipment = *read_equipment(3, {"path_observer", "2=threshold"}, {"3"});
  EXPECT_THAT(equipment, ElementsAre(VehicleEquipment{"path_observer", true}, VehicleEquipment{"threshold", true},
                                     VehicleEquipment{"path_observer", false}));
  EXPECT_THAT(*read_equipment(2, {}, {"all"}),
              ElementsAre(VehicleEquipment{"centroid_pd", false}, VehicleEquipment{"centroid_pd", false}));
  EXPECT_EQ(read_equipment(3, {"pid"}, {}).error().message,
            "'pid' is no algorithm; expected one of centroid_pd, path_observer, threshold");
  for (const char* bad : {"4=threshold", "0=threshold", "x=threshold", "=threshold"})
    EXPECT_EQ(read_equipment(3, {bad}, {}).error().code, "plant.line_tracking") << bad;
  for (const char* bad : {"4", "0", "", "both"})
    EXPECT_EQ(read_equipment(3, {}, {bad}).error().code, "plant.rali") << bad;
}

TEST(Equipment, survives_in_the_options_of_a_plant) {
  PlantOptions options;
  options.zone = lacet4();
  options.vehicles = 2;
  options.equipment = *read_equipment(2, {"2=path_observer"}, {"1"});
  const auto read = plant_options_from_json(to_json(options));
  ASSERT_TRUE(read) << to_string(read.error());
  EXPECT_EQ(read->equipment, options.equipment);
  std::string other = to_json(options);
  other.replace(other.find("path_observer"), 13, "path_observed");
  EXPECT_FALSE(plant_options_from_json(other));
}

TEST(Equipment, without_rali_has_no_port_and_no_power_readings) {
  PlantFixture fixture{lacet4(), 2};
  fixture.options.equipment = *read_equipment(2, {}, {"2"});
  fixture.restart();
  fixture.forget();
  fixture.run_for(2s);
  EXPECT_EQ(fixture.core().ports().size(), 7U);
  EXPECT_FALSE(fixture.received<wire::Power>(1).empty());
  EXPECT_TRUE(fixture.received<wire::Power>(2).empty());
  EXPECT_FALSE(fixture.received<wire::Ranges>(2).empty());
}

}  // namespace
}  // namespace cosiva::physical
