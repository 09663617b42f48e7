#pragma once

#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "cosiva/aiv/estimation/algorithm.h"
#include "cosiva/aiv/estimation/registry.h"
#include "cosiva/aiv/localisation/estimator.h"
#include "cosiva/base/archive_fwd.h"
#include "cosiva/base/time.h"
#include "cosiva/wire/messages/board.h"
#include "cosiva/wire/own/estimate_exchange.h"
#include "cosiva/zone/layout/traffic_zone.h"

namespace cosiva::aiv {

/// The time of a board's reading in the program's own time: the board's clock counts from its power-up, and its frames
/// arrive late. The fastest frame so far gives the clocks' offset. Invariant: no reading's time is after its receipt.
class BoardClock {
 public:
  [[nodiscard]] SimTime stamp(SimTime now, std::uint32_t board_ms);
  void archive(Archive& archive);  ///< the state, for a snapshot

 private:
  std::optional<SimDuration> offset_;  ///< own time less the board's
  SimTime received_{};
};

/// nextEstimatedPosition(algorithm) on board (A33, A35): algorithms that are requested by name run next to the
/// vehicle's own estimate, which they neither read (except for their start) nor change, all on the same inputs. The
/// response to a request follows with the next odometry. Invariant: a response is due only where there is one.
class Estimating {
 public:
  /// The vehicle's estimate when a session begins.
  struct CurrentEstimate {
    std::shared_ptr<const zone::TrafficZone> zone;
    Pose2 X_MB;
    std::optional<zone::TrackPosition> position;  ///< none: the vehicle is on no path
    double sigma_m{};
  };
  /// A step of odometry, after the vehicle's own estimate has taken it.
  struct Step {
    SimTime at{};  ///< of the board's reading
    double distance_m{};
    double turn_rad{};
    double speed_mps{};
    std::optional<CurrentEstimate> current_estimate;  ///< the present estimate; none: not known
  };

  /// A step is of interest: estimates are requested.
  [[nodiscard]] bool busy() const { return session_.has_value() || requested_.has_value(); }
  void on_request(SimTime now, wire::EstimateRequest request);
  void on_odometry(SimTime now, const Step& step);
  /// @param read_at  when the reader received the number
  void on_tag(std::uint32_t number, SimTime read_at, const zone::TrafficZone& zone, const Pose2& X_MB);
  /// Other sections are in force, which the algorithms do not know.
  void on_zone_switched();
  /// The response that is due now, if any.
  [[nodiscard]] std::optional<std::string> take_response();
  void archive(Archive& archive);  ///< the state, for a snapshot

 private:
  struct Running {
    std::string name;
    std::unique_ptr<estimation::Algorithm> algorithm;  ///< none: the algorithm failed
    std::string fault;
    std::vector<wire::EstimateResponse::Rectified> rectified;
  };
  struct Run {
    std::string id;
    std::uint32_t acknowledged{0};  ///< sequence of the last response
    std::string map_id;
    std::shared_ptr<const estimation::Track> track;
    wire::EstimateResponse::Start start;
    std::vector<Running> algorithms;
    std::vector<wire::EstimateResponse::Input> inputs;
    double travelled_m{0.0};
    double move_m{0.0};  ///< of the present request
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
  std::optional<wire::EstimateRequest> requested_;  ///< without a response yet
  SimTime requested_at_{};
  /// The last response, for a repeated request.
  struct Responded {
    std::string session;
    std::uint32_t sequence{};
    std::string json;
  };
  std::optional<Responded> last_response_;
  bool due_{false};
};

/// Quality of the vehicle's sensors, as given to every algorithm: wheels to 3 mm after a metre and 0.5 % in scale, a
/// reading at the rim of the antenna's field to 2.5 mm along and 2 mm across, the path to 1 mm.
[[nodiscard]] estimation::SensorModel data_sheet();

}  // namespace cosiva::aiv
