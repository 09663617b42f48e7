#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "cosiva/base/digest.h"
#include "cosiva/virtual/server/augmented/third_party_pause.h"
#include "cosiva/virtual/server/augmented/virtual_fleet.h"
#include "cosiva/virtual/server/messages/message_publisher.h"
#include "cosiva/virtual/server/registry/proxy.h"
#include "cosiva/virtual/simulator/simulator.h"

namespace cosiva::virtual_side {

/// Tells each vehicle what of the virtual world is near its way (wire::VirtualObstacles), and measures how soon it is
/// felt. A virtual AIV, whose world is the server's, is told of physical vehicles and obstacles, too.
class VirtualObstaclePublisher {
 public:
  static constexpr double within_m = 2.0;  ///< of the twin's middle
  static constexpr SimDuration period{std::chrono::milliseconds{100}};
  static constexpr int empty_last = 5;  ///< so often an empty one follows, since any may be lost
  /// An answer to one of the next two is an answer to a change, too: the first may have been lost on the way.
  static constexpr std::uint32_t response_within = 2;
  static constexpr std::uint32_t known_max = 256;  ///< older ones are not known any more
  static constexpr std::size_t sent_kept = 16;     ///< of so many is known when they were sent

  VirtualObstaclePublisher(Registry& registry, MessagePublisher& publisher, Traces& traces, Simulator& simulator,
                           VirtualFleet& fleet, ThirdPartyPause& pauses)
      : registry_{registry},
        publisher_{publisher},
        traces_{traces},
        simulator_{simulator},
        fleet_{fleet},
        pauses_{pauses} {}

  void resize(std::size_t vehicles) { viewers_.resize(vehicles); }
  /// After everything that may have changed the virtual world, and every tick. Costs nothing while that is empty.
  void update();
  /// The next update looks at everybody, even in an empty world.
  void wake() { busy_ = true; }
  /// Takes an answer in. @param decided  on the server's clock. False: it answers nothing that was sent lately.
  bool on_virtual_obstacles_ack(VehicleIndex vehicle, const wire::VirtualObstaclesAck& perceived, SimTime decided);
  /// A vehicle's program has started anew: it has felt nothing yet.
  void new_session(VehicleIndex vehicle) {
    Viewer fresh;
    fresh.next_id = viewers_[vehicle].next_id;
    viewers_[vehicle] = std::move(fresh);
  }

  /// The virtual body it brakes for; empty: none.
  [[nodiscard]] const std::string& perceives(VehicleIndex vehicle) const { return viewers_[vehicle].perceives; }
  void fold(Digest& digest) const;

 private:
  /// A body of the virtual world, as all vehicles will hear of it.
  struct Present {
    wire::Body body;
    std::uint16_t handle;  ///< unlike all others'
    SimTime changed;       ///< came or leapt
    VehicleIndex vehicle;  ///< no_vehicle: it is none
    bool physical;         ///< told to virtual AIVs only
    double distance_m{};   ///< of the viewer at hand
    double front_m{};      ///< of its foremost point, before the viewer's middle
  };
  using SentObject = std::pair<std::uint16_t, SimTime>;  ///< handle and `changed`
  struct Change {
    std::uint32_t header_id;
    SimTime since;
    bool perceived;
    std::vector<std::string> came;  ///< not braked for yet
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
  std::vector<const Present*> near_;      ///< of the viewer at hand, nearest first
  std::vector<SentObject> sent_objects_;  ///< the same, sorted
  bool busy_{false};                      ///< somebody was told of something at the last update
};

/// The shape that the zone's vehicles have for others.
[[nodiscard]] wire::Body body_of(std::string id, const Pose2& X_MB, double speed_mps, const zone::VehicleShape& shape);
/// Distance from `p` to the body's surface; negative inside.
[[nodiscard]] double distance_to(const wire::Body& body, Point2 p);

}  // namespace cosiva::virtual_side
