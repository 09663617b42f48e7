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

/// Where the vehicle truly was (actualAIVposition).
struct TrueFix {
  SimTime at{};
  Pose2 X_MB;
};
/// The truth between two fixes of a body that goes where it looks; nothing outside of them, or where they lie further
/// apart than `gap_max`.
/// @param fixes  in the order of time
[[nodiscard]] std::optional<Pose2> true_pose(const std::vector<TrueFix>& fixes, SimTime at, SimDuration gap_max);

/// What an algorithm on board said in a run, beside the run's moments.
struct OnBoardMessage {
  std::string algorithm;
  std::string fault;                             ///< why it says nothing any more; empty: it does
  std::vector<estimation::Estimate> estimates;   ///< one for each moment
  std::vector<estimation::Rectified> rectified;  ///< one for each reading
};

/// A run on a vehicle that drives: what its algorithms were told and said, and where it was.
struct LiveRun {
  Trial trial;
  wire::VehicleId vehicle;
  std::vector<OnBoardMessage> published;
};

/// A run in the making: takes answers, and makes a LiveRun of them at the end.
class RunLog {
 public:
  RunLog(std::string name, wire::VehicleId vehicle, std::uint64_t seed, std::uint32_t particles, std::uint32_t horizon);
  /// Of the session, in their order.
  void add(const wire::EstimateResponse& response);
  [[nodiscard]] double travelled_m() const { return travelled_m_; }
  [[nodiscard]] const std::string& map_id() const { return map_id_; }
  [[nodiscard]] std::optional<SimTime> last_moment() const;
  /// With the truth beside each answer: those without any are left out, and counted.
  /// @param zone  that it drove in
  /// Fails ("live.ground_truth") where no moment is left, ("live.zone") where the run's ring is not in the zone.
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
  double moment_m_{0.0};  ///< travelled by the last one
  double since_fiducial_m_{0.0};
};

/// An algorithm that ran on board, as one that can be qualified: it says again what it said then.
/// @param runs  of which the setting's seed names one
[[nodiscard]] Candidate on_board(std::string name, std::string what,
                                 const std::vector<std::shared_ptr<const LiveRun>>& runs);

}  // namespace cosiva::experiments
