#pragma once

#include <deque>
#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "cosiva/base/archive_fwd.h"
#include "cosiva/base/digest.h"
#include "cosiva/base/json_writer.h"
#include "cosiva/base/result.h"
#include "cosiva/virtual/server/registry/registry.h"
#include "cosiva/virtual/simulator/simulator.h"
#include "cosiva/wire/own/gvs.h"
#include "cosiva/wire/runtime/core.h"

namespace cosiva::virtual_side {

/// Compares the detections of the camera over the zone (GVS, A34) with the twins: the distance of each twin from the
/// detected pose of its vehicle at the same moment, detected vehicles without a twin, and twins that are not detected.
/// The results go to the bijection monitor and to the operators; no twin and no order depends on them. Where no camera
/// watches, an instrument's reference poses replace the measured ones: they give distances, and no findings.
///
/// Invariant: at most detected_max vehicles are stored; a series of detections of a vehicle begins not after its last
/// one.
class GroundTruthComparator {
 public:
  /// Longer than a tracker needs to find a lost vehicle again.
  static constexpr SimDuration timeout{std::chrono::seconds{3}};
  /// A detected vehicle without a twin is a finding after this time: it may have been switched on a moment ago.
  static constexpr SimDuration twin_expected_within{std::chrono::milliseconds{900}};
  /// Without an image for this time, or for three periods, the camera counts as unresponsive.
  static constexpr SimDuration unresponsive_after{std::chrono::seconds{2}};
  /// Past poses of twins are stored for this time, since an image is evaluated some time after its exposure.
  static constexpr SimDuration history{std::chrono::seconds{2}};
  static constexpr std::size_t detected_max = 256;  ///< bounds the memory if many invented names are received

  GroundTruthComparator(const Registry& registry, Simulator& simulator) : registry_{registry}, simulator_{simulator} {}

  [[nodiscard]] static std::vector<std::string> subscriptions();
  [[nodiscard]] static bool handles(std::string_view topic) {
    return topic.starts_with("cosiva/v1/gvs/") || topic == wire::reference_poses_topic;
  }
  /// Fails ("own.…", "json.…") and then keeps its state. @return  a short summary for the traces of communications;
  /// empty: nothing to show
  [[nodiscard]] Result<std::string> on_message(SimTime now, const wire::Input& input);
  /// Records the poses of the twins and updates the findings. Costs nothing if no camera ever connected. @param
  /// unknown_senders  whether an AIV without a twin is a finding: with several control areas the AIV may belong to
  /// another one
  void tick(SimTime now, bool unknown_senders);

  /// The last detection of a vehicle; nothing if the vehicle is not detected now.
  struct Sighted {
    std::uint32_t tag{};
    SimTime at{};       ///< time of the exposure
    SimTime arrived{};  ///< time of reception
    SimTime since{};    ///< start of the uninterrupted series of detections
    Pose2 X_MB;
    double uncertainty_m{};
    /// From the vehicle to its twin at that moment; nothing if there was no twin.
    std::optional<double> gap_m;
    std::optional<double> gap_rad;
  };

  /// Since when the camera has detected neither this vehicle anywhere, nor any other one at the position of its twin;
  /// nothing: it detects one, or that position is not in its field of view, or it is not watching.
  [[nodiscard]] std::optional<SimTime> undetected_since(VehicleIndex vehicle) const;

  /// The snapshot's "gvs": null if no message of a camera was received.
  void write(JsonWriter& json) const;
  void fold(Digest& digest) const;
  void archive(Archive& archive);  ///< the state, for a snapshot

 private:
  /// The last poses of a twin, and since when the twin has been in the camera's field of view.
  struct Trail {
    struct Point {
      SimTime at;
      Pose2 X_MB;
    };
    std::deque<Point> points;
    std::optional<SimTime> in_field_since;
  };

  [[nodiscard]] bool received() const { return connection_ || detections_; }
  [[nodiscard]] Result<std::string> take_reference(const wire::Input& input);
  [[nodiscard]] std::string_view state() const;
  void take(SimTime now, wire::GvsDetections detections);
  void compare(const wire::GvsDetections::Detection& detection, Sighted& detected);
  /// Of a twin from the true pose of its vehicle; nothing: there was no twin at that moment.
  struct Gap {
    double m;
    double rad;
  };
  [[nodiscard]] std::optional<Gap> measure(const wire::GvsDetections::Detection& detection, std::string_view reference);
  [[nodiscard]] std::optional<Pose2> twin_at(VehicleIndex vehicle, SimTime at) const;
  [[nodiscard]] std::optional<VehicleIndex> twin_of(const std::string& name) const;
  [[nodiscard]] bool reports(const std::string& name) const;
  void record_twins();
  [[nodiscard]] std::vector<Finding> find(bool unknown_senders);
  void find_unseen(std::vector<Finding>& findings);
  [[nodiscard]] SimTime since(Finding::Kind kind, const std::string& id) const;

  const Registry& registry_;
  Simulator& simulator_;
  SimTime now_{};
  std::optional<wire::GvsConnection> connection_;
  SimTime connection_at_{};
  std::optional<wire::GvsDetections> detections_;  ///< the last
  SimTime detections_at_{};
  SimTime watching_since_{};
  bool referenced_{false};  ///< an instrument has sent poses
  std::map<std::string, Sighted> detected_;
  std::vector<Trail> trails_;  ///< by vehicle
};

}  // namespace cosiva::virtual_side
