#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "cosiva/base/archive_fwd.h"
#include "cosiva/base/digest.h"
#include "cosiva/virtual/server/augmented/third_party_pause.h"
#include "cosiva/virtual/server/augmented/virtual_fleet.h"
#include "cosiva/virtual/server/messages/message_publisher.h"
#include "cosiva/virtual/server/registry/registry.h"
#include "cosiva/virtual/simulator/simulator.h"

namespace cosiva::virtual_side {

/// Sends each vehicle the virtual objects near its path (wire::VirtualObstacles) and measures how soon the vehicle
/// perceives them. A virtual AIV perceives only what the server sends, so its message contains physical vehicles and
/// obstacles as well.
///
/// Invariant: what a vehicle was sent last is sorted and stored once (`commanded`), so that a change is found by
/// comparison; a message contains at most bodies_max bodies, and at most the last 16 changes of a vehicle are measured.
class VirtualObstaclePublisher {
 public:
  static constexpr double within_m = 2.0;  ///< of the twin's body origin
  static constexpr SimDuration period{std::chrono::milliseconds{100}};
  static constexpr int empty_last = 5;  ///< number of empty messages after the last body has left, since any message
                                        ///< may be lost
  /// An acknowledgement of one of the next two messages acknowledges a change, too: the first message may have been
  /// lost.
  static constexpr std::uint32_t response_within = 2;
  static constexpr std::uint32_t known_max = 256;  ///< acknowledgements of older messages are rejected
  static constexpr std::size_t sent_kept = 16;     ///< number of messages whose sending time is stored

  VirtualObstaclePublisher(Registry& registry, MessagePublisher& publisher, Traces& traces, Simulator& simulator,
                           VirtualFleet& fleet, ThirdPartyPause& pauses)
      : registry_{registry},
        publisher_{publisher},
        traces_{traces},
        simulator_{simulator},
        fleet_{fleet},
        pauses_{pauses} {}

  void resize(std::size_t vehicles) { viewers_.resize(vehicles); }
  /// Called after every possible change of the virtual objects, and at every tick. Costs nothing while there are none.
  void update();
  /// The next update evaluates all vehicles, even if there is no virtual object.
  void wake() { busy_ = true; }
  /// Processes an acknowledgement. @param decided  on the server's clock. Returns false if the acknowledgement refers
  /// to no recent message.
  bool on_virtual_obstacles_ack(VehicleIndex vehicle, const wire::VirtualObstaclesAck& perceived, SimTime decided);
  /// A vehicle's program has restarted: the vehicle has perceived nothing yet.
  void new_session(VehicleIndex vehicle) {
    Viewer fresh;
    fresh.next_id = viewers_[vehicle].next_id;
    viewers_[vehicle] = std::move(fresh);
  }

  /// The virtual body that the vehicle brakes for; empty: none.
  [[nodiscard]] const std::string& perceives(VehicleIndex vehicle) const { return viewers_[vehicle].perceives; }
  void fold(Digest& digest) const;
  void archive(Archive& archive);  ///< the state, for a snapshot

 private:
  /// A body of the virtual world, as sent to all vehicles.
  struct Present {
    wire::Body body;
    std::uint16_t handle;  ///< unique among all bodies
    SimTime changed;       ///< time of appearance or of the last jump
    VehicleIndex vehicle;  ///< no_vehicle: the body is no vehicle
    bool physical;         ///< sent to virtual AIVs only
    double distance_m{};   ///< from the current viewer
    double front_m{};      ///< of its foremost point, measured forward from the viewer's body origin
  };
  using SentObject = std::pair<std::uint16_t, SimTime>;  ///< handle and `changed`
  struct Change {
    std::uint32_t header_id;
    SimTime since;
    bool perceived;
    std::vector<std::string> came;  ///< the vehicle has not braked for these yet
  };
  struct Viewer {
    std::uint32_t next_id{0};
    std::array<SimTime, sent_kept> sent{};  ///< by header id, modulo
    std::vector<SentObject> commanded;      ///< sorted
    SimTime due{};
    int empties{0};
    std::vector<Change> changes;  ///< the last few
    bool acknowledged{false};
    std::uint32_t unanswered{0};
    SimTime first_sent{};
    std::string perceives;
  };

  void gather();
  void gather_vehicles();
  [[nodiscard]] std::optional<Pose2> pose_of(VehicleIndex vehicle) const;
  [[nodiscard]] bool can_receive(VehicleIndex vehicle) const;
  void survey_neighbours(VehicleIndex vehicle);
  void pick(VehicleIndex vehicle, const Pose2& X_MB);
  void record_change(Viewer& viewer);
  void send(VehicleIndex vehicle, Viewer& viewer);
  void measure(Viewer& viewer, const wire::VirtualObstaclesAck& perceived, SimTime decided, bool begins_to_brake);

  Registry& registry_;
  MessagePublisher& publisher_;
  Traces& traces_;
  Simulator& simulator_;
  VirtualFleet& fleet_;
  ThirdPartyPause& pauses_;
  std::vector<Viewer> viewers_;
  std::vector<Present> world_;
  std::vector<const Present*> near_;      ///< of the current viewer, nearest first
  std::vector<SentObject> sent_objects_;  ///< the same, sorted
  bool busy_{false};                      ///< at the last update, at least one vehicle was sent a body
};

/// The body of a vehicle of this zone, as sent to other vehicles.
[[nodiscard]] wire::Body body_of(std::string id, const Pose2& X_MB, double speed_mps, const zone::VehicleShape& shape);
/// Distance from `p` to the body's surface; negative inside.
[[nodiscard]] double distance_to(const wire::Body& body, Point2 p);

}  // namespace cosiva::virtual_side
