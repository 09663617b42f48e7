#pragma once

#include <cstdint>
#include <string>
#include <string_view>

#include "cosiva/base/pose.h"
#include "cosiva/base/result.h"
#include "cosiva/base/time.h"

/// actualAIVposition, figures 16 and 17 (A33, A35): the actual position of a vehicle, requested from the GVS, or where
/// none runs from the emulated plant. docs/protocols/own-messages.md.
namespace cosiva::wire {

/// Instrument → GVS, by vehicle: ActualPositionRequest. The GVS responds with its next image of the vehicle.
inline constexpr std::string_view gvs_position_request_topic_prefix = "cosiva/v1/gvs/actual_position/request/";
/// GVS → instrument: ActualPosition.
inline constexpr std::string_view gvs_position_response_topic_prefix = "cosiva/v1/gvs/actual_position/response/";
/// The same from the emulated plant, which responds at once with its ground truth.
inline constexpr std::string_view plant_position_request_topic_prefix = "cosiva/v1/plant/actual_position/request/";
inline constexpr std::string_view plant_position_response_topic_prefix = "cosiva/v1/plant/actual_position/response/";

struct ActualPositionRequest {
  std::string session;  ///< of the instrument's run
  std::uint32_t sequence{1};
  friend bool operator==(const ActualPositionRequest&, const ActualPositionRequest&) = default;
};

struct ActualPosition {
  std::string session;  ///< of the request
  std::uint32_t sequence{1};
  SimTime at{};  ///< when the vehicle was there
  Pose2 X_MB;
  double uncertainty_m{};  ///< standard, of the position
  friend bool operator==(const ActualPosition&, const ActualPosition&) = default;
};

[[nodiscard]] std::string to_json(const ActualPositionRequest& request);
[[nodiscard]] std::string to_json(const ActualPosition& position);
/// Fail ("own.field", "json.…") as the readers of own_messages.h do.
[[nodiscard]] Result<ActualPositionRequest> actual_position_request_from_json(std::string_view json);
[[nodiscard]] Result<ActualPosition> actual_position_from_json(std::string_view json);

}  // namespace cosiva::wire
