#pragma once

#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "cosiva/aiv/estimation/algorithm.h"
#include "cosiva/aiv/estimation/registry.h"
#include "cosiva/aiv/localisation/estimator.h"
#include "cosiva/base/time.h"
#include "cosiva/wire/messages/board.h"
#include "cosiva/wire/own/estimate_exchange.h"
#include "cosiva/zone/layout/traffic_zone.h"

namespace cosiva::aiv {

/// When a board's reading was taken, in our own time: its clock counts from its power-up, and its frames take a while.
/// The fastest frame so far tells how the two clocks stand.
class BoardClock {
 public:
  [[nodiscard]] SimTime stamp(SimTime now, std::uint32_t board_ms);

 private:
  std::optional<SimDuration> offset_;  ///< our time less the board's
  SimTime received_{};
};

/// nextEstimatedPosition(algorithm) on board (A33, A35): algorithms that are asked for by name run beside the
/// vehicle's own belief, which they neither read (but where they begin) nor change, all on the same inputs. A request
/// is answered with the next odometry.
class Estimating {
 public:
  /// What the vehicle knows when a session begins.
  struct CurrentEstimate {
    std::shared_ptr<const zone::TrafficZone> zone;
    Pose2 X_MB;
    std::optional<zone::TrackPosition> position;  ///< none: it is on no line
    double sigma_m{};
  };
  /// A step of odometry, once the vehicle's own belief has taken it.
  struct Step {
    SimTime at{};  ///< of the board's reading
    double distance_m{};
    double turn_rad{};
    double speed_mps{};
    std::optional<CurrentEstimate> current_estimate;  ///< where it is now; none: nobody knows
  };

  /// A step is of interest: somebody asks.
  [[nodiscard]] bool busy() const { return session_.has_value() || requested_.has_value(); }
  void on_request(SimTime now, wire::EstimateRequest request);
  void on_odometry(SimTime now, const Step& step);
  /// @param read_at  when the reader had its number
  void on_tag(std::uint32_t number, SimTime read_at, const zone::TrafficZone& zone, const Pose2& X_MB);
  /// Other ways hold: its algorithms know nothing of those.
  void on_zone_switched();
  /// What is to be said now, if anything.
  [[nodiscard]] std::optional<std::string> take_response();

 private:
  struct Running {
    std::string name;
    std::unique_ptr<estimation::Algorithm> algorithm;  ///< none: it failed
    std::string fault;
    std::vector<wire::EstimateResponse::Rectified> rectified;
  };
  struct Run {
    std::string id;
    std::uint32_t acknowledged{0};  ///< sequence of the last answer
    std::string map_id;
    std::shared_ptr<const estimation::Track> track;
    wire::EstimateResponse::Start start;
    std::vector<Running> algorithms;
    std::vector<wire::EstimateResponse::Input> inputs;
    double travelled_m{0.0};
    double off_loop_m{0.0};
    SimTime stepped_at{};
    double speed_mps{0.0};
    std::string fault;
  };
  void begin(const wire::EstimateRequest& request, const Step& step);
  [[nodiscard]] std::optional<Running> start(const std::string& name, const estimation::Setting& setting);
  void roll(const Step& step);
  void publish_reading(const wire::EstimateResponse::Reading& reading);
  void response(SimTime at);
  void refuse(const wire::EstimateRequest& request, SimTime at, std::string why);
  void publish(const wire::EstimateResponse& response);

  estimation::Registry registry_;
  EstimatorModel model_;
  std::optional<Run> session_;
  std::optional<wire::EstimateRequest> requested_;  ///< and not answered yet
  SimTime requested_at_{};
  /// The last answer, for who asks again.
  struct Responded {
    std::string session;
    std::uint32_t sequence{};
    std::string json;
  };
  std::optional<Responded> last_response_;
  bool due_{false};
};

/// What the vehicle's sensors are worth, as it tells every algorithm: wheels to 3 mm after a metre and 0.5 % in scale,
/// a reading at the rim of the antenna's field to 2.5 mm along and 2 mm across, the line to 1 mm.
[[nodiscard]] estimation::SensorModel data_sheet();

}  // namespace cosiva::aiv
