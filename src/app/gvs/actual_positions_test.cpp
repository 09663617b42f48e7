#include "cosiva/app/gvs/actual_positions.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <chrono>

namespace cosiva::app {
namespace {

using std::chrono::milliseconds;
using ::testing::IsEmpty;
using ::testing::SizeIs;

wire::GvsDetections image(SimTime at, const std::string& vehicle, double x_m) {
  return {1, at, 0.25, {{vehicle, 1, at, {x_m, 2.0, 0.5}, 0.001}}, {}};
}

TEST(ActualPositions, responds_once_with_the_first_image_taken_after_the_request) {
  ActualPositions positions;
  const SimTime now = virtual_epoch;
  positions.on_request(now, {"CoSiVA", "AIV1"}, to_json(wire::ActualPositionRequest{"q/1", 3}));
  EXPECT_THAT(positions.on_detections(image(now - milliseconds{10}, "CoSiVA/AIV1", 1.0)), IsEmpty()) << "taken before";
  EXPECT_THAT(positions.on_detections(image(now + milliseconds{10}, "CoSiVA/AIV2", 1.0)), IsEmpty()) << "another one";
  const auto responses = positions.on_detections(image(now + milliseconds{250}, "CoSiVA/AIV1", 1.5));
  ASSERT_THAT(responses, SizeIs(1));
  EXPECT_EQ(responses[0].topic, "cosiva/v1/gvs/actual_position/response/CoSiVA/AIV1");
  EXPECT_EQ(wire::actual_position_from_json(responses[0].payload),
            (wire::ActualPosition{"q/1", 3, now + milliseconds{250}, {1.5, 2.0, 0.5}, 0.001}));
  EXPECT_THAT(positions.on_detections(image(now + milliseconds{500}, "CoSiVA/AIV1", 1.5)), IsEmpty());
}

TEST(ActualPositions, ignores_what_cannot_be_read_and_bounds_its_requests) {
  ActualPositions positions;
  positions.on_request(virtual_epoch, {"CoSiVA", "AIV1"}, "{");
  EXPECT_THAT(positions.on_detections(image(virtual_epoch, "CoSiVA/AIV1", 1.0)), IsEmpty());
  const std::string request = to_json(wire::ActualPositionRequest{"q/1", 1});
  for (std::size_t i = 0; i <= ActualPositions::vehicles_max; ++i)
    positions.on_request(virtual_epoch, {"ACME", std::to_string(i)}, request);
  EXPECT_THAT(positions.on_detections(image(virtual_epoch, "ACME/256", 1.0)), IsEmpty());
  EXPECT_THAT(positions.on_detections(image(virtual_epoch, "ACME/255", 1.0)), SizeIs(1));
}

}  // namespace
}  // namespace cosiva::app
