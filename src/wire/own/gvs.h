#pragma once

#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "cosiva/base/pose.h"
#include "cosiva/base/result.h"
#include "cosiva/base/time.h"
#include "cosiva/wire/messages/messages.h"

/// The messages of GVS, the camera over the zone (A34), about the physical side. docs/protocols/own-messages.md.
namespace cosiva::wire {

/// GVS → server, with each image: the vehicles that the camera detected and their poses (wire::GvsDetections, A34).
inline constexpr std::string_view gvs_detections_topic = "cosiva/v1/gvs/detections";
/// Instrument → server, once a second: the true poses of vehicles (wire::GvsDetections, without a field of view), from
/// the emulated world or a motion capture system.
inline constexpr std::string_view reference_poses_topic = "cosiva/v1/reference/poses";
/// Retained with a last will: whether that camera is in operation (wire::GvsConnection).
inline constexpr std::string_view gvs_connection_topic = "cosiva/v1/gvs/connection";
/// Server → GVS: a client displays the preview, so images are sent for the next two seconds.
inline constexpr std::string_view gvs_preview_request_topic = "cosiva/v1/gvs/preview_request";
/// GVS → server, while a client displays it: the image, small and grey, as Netpbm's P5; its comment states each
/// vehicle's position in the image.
inline constexpr std::string_view gvs_preview_topic = "cosiva/v1/gvs/preview";

/// GVS → server, QoS 0, for each of its images: the detected vehicles and their poses.
struct GvsDetections {
  std::uint32_t header_id{};
  SimTime timestamp{};  ///< when the image's exposure began
  double period_s{};    ///< to the next image
  struct Detection {
    std::string vehicle;  ///< "CoSiVA/AIV1": the vehicle that carries the tag
    std::uint32_t tag{};
    SimTime at{};            ///< the middle of the exposure of the tag's rows
    Pose2 pose;              ///< X_MB of the vehicle, its tag's height and mount accounted for
    double uncertainty_m{};  ///< standard, of its position
    friend bool operator==(const Detection&, const Detection&) = default;
  };
  std::vector<Detection> detections;  ///< at most detections_max
  /// The part of the floor where the camera detects a whole tag: corners of a polygon, at most corners_max. A vehicle
  /// outside does not count as missing.
  std::vector<Point2> field;
  static constexpr std::size_t detections_max = 256;
  static constexpr std::size_t corners_max = 64;
  friend bool operator==(const GvsDetections&, const GvsDetections&) = default;
};

/// GVS → server, retained, QoS 1, and as its last will: whether the camera is in operation.
struct GvsConnection {
  ConnectionState state{};
  SimTime timestamp{};
  std::string source;   ///< where the images come from, as text
  std::string trouble;  ///< why none come now; empty: images come
  friend bool operator==(const GvsConnection&, const GvsConnection&) = default;
};

[[nodiscard]] std::string to_json(const GvsDetections& detections);
[[nodiscard]] std::string to_json(const GvsConnection& connection);
/// Both fail ("own.field", naming the field; "json.syntax") as readers of CoSiVA's own messages do.
[[nodiscard]] Result<GvsDetections> gvs_detections_from_json(std::string_view json);
[[nodiscard]] Result<GvsConnection> gvs_connection_from_json(std::string_view json);

}  // namespace cosiva::wire
