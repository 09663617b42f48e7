#pragma once

#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "cosiva/base/pose.h"
#include "cosiva/base/result.h"
#include "cosiva/base/time.h"
#include "cosiva/wire/messages/messages.h"

/// What GVS, the camera over the zone (A34), tells of the physical side. docs/protocols/own-messages.md.
namespace cosiva::wire {

/// GVS → server, with each picture: whom the camera over the zone saw where (wire::GvsDetections, A34).
inline constexpr std::string_view gvs_detections_topic = "cosiva/v1/gvs/detections";
/// Retained with a last will: whether that camera watches (wire::GvsConnection).
inline constexpr std::string_view gvs_connection_topic = "cosiva/v1/gvs/connection";
/// Server → GVS: somebody looks at its pictures, so they are sent for the next two seconds.
inline constexpr std::string_view gvs_preview_request_topic = "cosiva/v1/gvs/preview_request";
/// GVS → server, while somebody looks: the picture, small and grey, as Netpbm's P5; its comment says who is where on
/// it.
inline constexpr std::string_view gvs_preview_topic = "cosiva/v1/gvs/preview";

/// GVS → server, QoS 0, for each of its pictures: whom it saw where.
struct GvsDetections {
  std::uint32_t header_id{};
  SimTime timestamp{};  ///< when the picture's exposure began
  double period_s{};    ///< to the next picture
  struct Detection {
    std::string vehicle;  ///< "CoSiVA/AIV1": whose tag it is
    std::uint32_t tag{};
    SimTime at{};            ///< the middle of the exposure of its own rows
    Pose2 pose;              ///< X_MB of the vehicle, its tag's height and mount accounted for
    double uncertainty_m{};  ///< standard, of its place
    friend bool operator==(const Detection&, const Detection&) = default;
  };
  std::vector<Detection> detections;  ///< at most detections_max
  /// What of the floor it sees so that a whole tag fits in: corners of a polygon, at most corners_max. Who is outside
  /// is not missed.
  std::vector<Point2> field;
  static constexpr std::size_t detections_max = 256;
  static constexpr std::size_t corners_max = 64;
  friend bool operator==(const GvsDetections&, const GvsDetections&) = default;
};

/// GVS → server, retained, QoS 1, and as its last will: whether it watches.
struct GvsConnection {
  ConnectionState state{};
  SimTime timestamp{};
  std::string source;   ///< where its pictures come from, in words
  std::string trouble;  ///< why none come now; empty: they do
  friend bool operator==(const GvsConnection&, const GvsConnection&) = default;
};

[[nodiscard]] std::string to_json(const GvsDetections& detections);
[[nodiscard]] std::string to_json(const GvsConnection& connection);
/// Both fail ("own.field", naming the field; "json.syntax") as readers of our own messages do.
[[nodiscard]] Result<GvsDetections> gvs_detections_from_json(std::string_view json);
[[nodiscard]] Result<GvsConnection> gvs_connection_from_json(std::string_view json);

}  // namespace cosiva::wire
