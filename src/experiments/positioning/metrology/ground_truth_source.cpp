#include "cosiva/experiments/positioning/metrology/ground_truth_source.h"

#include <utility>

#include "cosiva/base/expect.h"
#include "cosiva/wire/own/actual_position.h"
#include "cosiva/wire/own/gvs.h"

namespace cosiva::experiments {

GroundTruthSource::GroundTruthSource(std::string named_topic)
    : kind_{named_topic.empty() ? Kind::plant : Kind::named},
      topic_{named_topic.empty() ? std::string(wire::ground_truth_topic) : std::move(named_topic)} {}

std::vector<std::string> GroundTruthSource::subscriptions() const {
  if (kind_ == Kind::named) return {topic_};
  return {std::string(wire::gvs_connection_topic), std::string(wire::gvs_detections_topic),
          std::string(wire::ground_truth_topic)};
}

bool GroundTruthSource::on_message(std::string_view topic, std::string_view payload) {
  if (topic != wire::gvs_connection_topic || kind_ == Kind::named || in_use_) return false;
  const auto connection = wire::gvs_connection_from_json(payload);
  if (!connection) return false;
  // A camera without images has no positions either; its trouble ends when the first image arrives.
  const bool operates = connection->state == wire::ConnectionState::online && connection->trouble.empty();
  const Kind before = std::exchange(kind_, operates ? Kind::gvs : Kind::plant);
  topic_ = operates ? wire::gvs_detections_topic : wire::ground_truth_topic;
  camera_ = connection->source;
  COSIVA_EXPECT(!in_use_);
  return kind_ != before;
}

std::string_view GroundTruthSource::request_prefix() const {
  COSIVA_EXPECT(kind_ != Kind::named);
  return kind_ == Kind::gvs ? wire::gvs_position_request_topic_prefix : wire::plant_position_request_topic_prefix;
}

std::string_view GroundTruthSource::response_prefix() const {
  COSIVA_EXPECT(kind_ != Kind::named);
  return kind_ == Kind::gvs ? wire::gvs_position_response_topic_prefix : wire::plant_position_response_topic_prefix;
}

std::string GroundTruthSource::name() const {
  switch (kind_) {
    case Kind::gvs: return camera_.empty() ? "GVS" : "GVS, " + camera_;
    case Kind::plant: return "the plant's ground truth, as no GVS is in operation";
    case Kind::named: break;
  }
  return topic_;
}

}  // namespace cosiva::experiments
