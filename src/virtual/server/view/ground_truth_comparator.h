#pragma once

#include <deque>
#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "cosiva/base/digest.h"
#include "cosiva/base/json_writer.h"
#include "cosiva/base/result.h"
#include "cosiva/virtual/server/registry/proxy.h"
#include "cosiva/virtual/simulator/simulator.h"
#include "cosiva/wire/own/gvs.h"
#include "cosiva/wire/runtime/core.h"

namespace cosiva::virtual_side {

/// What the camera over the zone (GVS, A34) says of the physical side, held against the twins: how far each twin was
/// from where its vehicle was seen at that moment, who is seen without a twin, and which twin nobody sees. It is news
/// for the bijection monitor and for people; no twin and no order ever follows it.
class GroundTruthComparator {
 public:
  /// Longer than a tracker needs to find again whom it lost.
  static constexpr SimDuration timeout{std::chrono::seconds{3}};
  /// Without a picture for so long, or three periods, it watches no more.
  static constexpr SimDuration unresponsive_after{std::chrono::seconds{2}};
  /// Twins are remembered for so long: a picture is looked at after it was taken.
  static constexpr SimDuration history{std::chrono::seconds{2}};
  static constexpr std::size_t detected_max = 256;  ///< a flood of made-up names must not take the memory

  GroundTruthComparator(const Registry& registry, Simulator& simulator) : registry_{registry}, simulator_{simulator} {}

  [[nodiscard]] static std::vector<std::string> subscriptions();
  [[nodiscard]] static bool handles(std::string_view topic) { return topic.starts_with("cosiva/v1/gvs/"); }
  /// Fails ("own.…", "json.…") and then keeps what it knew.
  /// @return  in a few words, what is worth showing among the communications; empty: nothing
  [[nodiscard]] Result<std::string> on_message(SimTime now, const wire::Input& input);
  /// Notes where the twins are, and what is wrong. Costs nothing where no camera was ever heard.
  /// @param strangers  whether an AIV without a twin is ours to miss: of several control areas it may be another's
  void tick(SimTime now, bool unknown_senders);

  /// Of the physical side as it was seen last; nothing where it is not seen now.
  struct Sighted {
    std::uint32_t tag{};
    SimTime at{};       ///< when it was there
    SimTime arrived{};  ///< when we heard of it
    SimTime since{};    ///< from when on it has been seen again and again
    Pose2 X_MB;
    double uncertainty_m{};
    /// To its twin at that moment; nothing where there was none.
    std::optional<double> gap_m;
    std::optional<double> gap_rad;
  };

  /// The snapshot's "gvs": null where no camera was heard of.
  void write(JsonWriter& json) const;
  void fold(Digest& digest) const;

 private:
  /// A twin's last places, and since when it has been where the camera looks.
  struct Trail {
    struct Point {
      SimTime at;
      Pose2 X_MB;
    };
    std::deque<Point> points;
    std::optional<SimTime> in_field_since;
  };

  [[nodiscard]] bool received() const { return connection_ || detections_; }
  [[nodiscard]] std::string_view state() const;
  void take(SimTime now, wire::GvsDetections detections);
  void compare(const wire::GvsDetections::Detection& detection, Sighted& detected);
  [[nodiscard]] std::optional<Pose2> twin_at(VehicleIndex vehicle, SimTime at) const;
  [[nodiscard]] std::optional<VehicleIndex> twin_of(const std::string& name) const;
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
  std::map<std::string, Sighted> detected_;
  std::vector<Trail> trails_;  ///< by vehicle
};

}  // namespace cosiva::virtual_side
