#include "cosiva/experiments/positioning/metrology/ground_truth_source.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "cosiva/wire/own/gvs.h"

namespace cosiva::experiments {
namespace {

using ::testing::ElementsAre;

bool connect(GroundTruthSource& source, wire::ConnectionState state, const std::string& trouble = {}) {
  return source.on_message(wire::gvs_connection_topic,
                           to_json(wire::GvsConnection{state, virtual_epoch, "the camera /dev/video0", trouble}));
}

TEST(GroundTruthSource, is_the_gvs_where_one_is_in_operation_and_otherwise_the_plant) {
  GroundTruthSource source;
  EXPECT_EQ(source.topic(), "cosiva/v1/plant/ground_truth");
  EXPECT_EQ(source.name(), "the plant's ground truth, as no GVS is in operation");
  EXPECT_TRUE(connect(source, wire::ConnectionState::online));
  EXPECT_EQ(source.topic(), "cosiva/v1/gvs/detections");
  EXPECT_EQ(source.request_prefix(), "cosiva/v1/gvs/actual_position/request/");
  EXPECT_EQ(source.response_prefix(), "cosiva/v1/gvs/actual_position/response/");
  EXPECT_EQ(source.name(), "GVS, the camera /dev/video0");
  EXPECT_FALSE(connect(source, wire::ConnectionState::online)) << "no change";
}

TEST(GroundTruthSource, is_the_plant_while_the_gvs_is_offline_broken_or_without_images) {
  GroundTruthSource source;
  EXPECT_FALSE(connect(source, wire::ConnectionState::offline));
  EXPECT_FALSE(connect(source, wire::ConnectionState::connection_broken));
  EXPECT_FALSE(connect(source, wire::ConnectionState::online, "the camera delivers no image"));
  EXPECT_FALSE(source.on_message(wire::gvs_connection_topic, "{"));
  EXPECT_FALSE(source.on_message("cosiva/v1/gvs/other", "{}"));
  EXPECT_EQ(source.kind(), GroundTruthSource::Kind::plant);
}

TEST(GroundTruthSource, does_not_change_in_a_test) {
  GroundTruthSource source;
  EXPECT_TRUE(connect(source, wire::ConnectionState::online));
  source.use();
  EXPECT_FALSE(connect(source, wire::ConnectionState::offline));
  EXPECT_EQ(source.kind(), GroundTruthSource::Kind::gvs) << "positions of two sources would be mixed in one result";
}

TEST(GroundTruthSource, is_a_named_topic_whatever_runs) {
  GroundTruthSource source{"site/motion_capture"};
  EXPECT_THAT(source.subscriptions(), ElementsAre("site/motion_capture"));
  EXPECT_FALSE(connect(source, wire::ConnectionState::online));
  EXPECT_EQ(source.name(), "site/motion_capture");
}

}  // namespace
}  // namespace cosiva::experiments
