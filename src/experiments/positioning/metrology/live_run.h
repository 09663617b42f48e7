#pragma once

#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "cosiva/base/time.h"
#include "cosiva/experiments/positioning/metrology/qualification.h"
#include "cosiva/experiments/positioning/metrology/trial.h"
#include "cosiva/wire/own/estimate_exchange.h"
#include "cosiva/zone/layout/traffic_zone.h"

namespace cosiva::experiments {

/// The vehicle's actual position (actualAIVposition).
struct TrueFix {
  SimTime at{};
  Pose2 X_MB;
};
/// The ground truth between two fixes of a body that moves in the direction of its heading; nothing outside of them, or
/// where the fixes are further apart than `gap_max`.
/// @param fixes  in the order of time
[[nodiscard]] std::optional<Pose2> true_pose(const std::vector<TrueFix>& fixes, SimTime at, SimDuration gap_max);

/// The responses of an algorithm on board in a run, with the run's moments.
struct OnBoardMessage {
  std::string algorithm;
  std::string fault;                             ///< why the algorithm stopped responding; empty: no fault
  std::vector<estimation::Estimate> estimates;   ///< one for each moment
  std::vector<estimation::Rectified> rectified;  ///< one for each reading
};

/// A run on a driving vehicle: the inputs and the responses of its algorithms, and its actual positions.
struct LiveRun {
  Trial trial;
  wire::VehicleId vehicle;
  std::vector<OnBoardMessage> published;
};

/// A run in progress: takes responses, and makes a live run of them at the end.
///
/// Invariant: each moment has the time at which the vehicle has sent it.
class RunLog {
 public:
  RunLog(std::string name, wire::VehicleId vehicle, std::uint64_t seed, std::uint32_t particles, std::uint32_t horizon);
  /// Adds a response of the session, in order.
  void add(const wire::EstimateResponse& response);
  [[nodiscard]] double travelled_m() const { return travelled_m_; }
  [[nodiscard]] const std::string& map_id() const { return map_id_; }
  [[nodiscard]] std::optional<SimTime> last_moment() const;
  /// Adds the ground truth at each response: responses without ground truth are left out, and counted.
  /// @param zone  of the run
  /// Fails ("live.ground_truth") where no moment is left, ("live.zone") where the run's loop is not in the zone.
  [[nodiscard]] Result<LiveRun> finish(const std::shared_ptr<const zone::TrafficZone>& zone,
                                       const std::vector<TrueFix>& ground_truth, SimDuration gap_max,
                                       std::size_t& without_ground_truth) &&;

 private:
  void report(const wire::EstimateResponse::Input& input);
  void receive(const wire::EstimateResponse::Estimate& estimate, bool moment);

  LiveRun run_;
  std::string map_id_;
  std::optional<wire::EstimateResponse::Start> start_;
  std::vector<SimTime> stamps_;  ///< of the moments
  double travelled_m_{0.0};
  double moment_m_{0.0};  ///< distance travelled at the last moment
  double since_fiducial_m_{0.0};
};

/// An algorithm that ran on board, as a candidate: repeats its recorded responses.
/// @param runs  of which the setting's seed selects one
[[nodiscard]] Candidate on_board(std::string name, std::string what,
                                 const std::vector<std::shared_ptr<const LiveRun>>& runs);

}  // namespace cosiva::experiments
