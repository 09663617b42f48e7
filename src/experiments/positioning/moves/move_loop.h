#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "cosiva/base/pose.h"
#include "cosiva/base/result.h"
#include "cosiva/base/time.h"
#include "cosiva/experiments/positioning/metrology/ground_truth_source.h"
#include "cosiva/experiments/positioning/metrology/live_run.h"
#include "cosiva/wire/messages/messages.h"
#include "cosiva/wire/own/actual_position.h"
#include "cosiva/wire/own/estimate_exchange.h"
#include "cosiva/wire/runtime/core.h"
#include "cosiva/zone/layout/traffic_zone.h"

namespace cosiva::experiments {

struct MoveLoopOptions {
  wire::VehicleId vehicle;
  std::string session;                  ///< of this run, unique among all tests
  std::vector<std::string> algorithms;  ///< on board, at least one
  double distance_m{10.0};              ///< TDTmax
  double step_m{0.1};                   ///< of each move
  std::uint64_t seed{1};
  std::uint32_t particles{500};
  std::uint32_t horizon{4};
};

/// A message of figures 16 and 17 between two of its objects, written where the message is sent or received.
struct Call {
  SimTime at{};
  std::string from;  ///< Simulator, CoSiVA/AIV1, GVS or plant
  std::string to;
  std::string text;  ///< "nextEstimatedPosition(arc_kalman)", "PE = (…)", "move(0.100 m)"
};

/// One iteration: (PA, PE1, PE2, …). Each estimate was made before the move, of the position after it.
struct MoveStep {
  SimTime at{};  ///< of the actual position
  Pose2 actual;
  std::vector<Pose2> estimated;  ///< by algorithm, in the options' order
  double travelled_m{};          ///< by the vehicle's odometry, after the move
  double since_fiducial_m{};     ///< likewise, since its last reading
};

/// One run of figure 16, or with several algorithms of figure 17, on one vehicle: the next position is requested from
/// the vehicle, then a move commanded, then the actual position requested from the GVS, and the three recorded, until
/// the vehicle has travelled TDTmax. Without I/O: messages in, messages out. Lost messages are repeated.
///
/// Invariant: no move is commanded before its estimates are there, and no position is requested before the move's end.
class MoveLoop {
 public:
  enum class Phase : std::uint8_t { starting, stopping, estimating, moving, locating, done, failed };
  struct Sent {
    std::vector<wire::Publish> messages;
    std::vector<Call> calls;
  };

  /// @param source must outlive the loop
  MoveLoop(MoveLoopOptions options, const GroundTruthSource& source);

  void on_message(SimTime now, std::string_view topic, std::string_view payload);
  [[nodiscard]] Sent tick(SimTime now);
  /// The run is over without a result.
  void fail_run(std::string why);

  [[nodiscard]] Phase phase() const { return phase_; }
  [[nodiscard]] const std::string& fault() const { return fault_; }  ///< why the run has failed
  [[nodiscard]] SimTime progressed() const { return progressed_; }   ///< when the phase has changed last
  [[nodiscard]] double travelled_m() const { return odometer_.travelled_m; }
  [[nodiscard]] const std::string& map_id() const { return map_id_; }
  [[nodiscard]] std::size_t repeated() const { return repeated_; }  ///< requests and commands
  [[nodiscard]] const std::vector<MoveStep>& steps() const { return steps_; }
  [[nodiscard]] const MoveLoopOptions& options() const { return options_; }
  /// The run for its evaluation. Fails ("moves.steps") without a step, ("live.zone") where the run's loop is not in the
  /// zone.
  [[nodiscard]] Result<LiveRun> finish(const std::shared_ptr<const zone::TrafficZone>& zone) const;

 private:
  void enter(SimTime now, Phase phase);
  void request_estimate(SimTime now);
  void command_move(SimTime now);
  void request_position(SimTime now);
  void send(SimTime now, std::string to, std::string text, wire::Publish message);
  void receive(SimTime now, std::string from, std::string text);
  void on_estimate(SimTime now, const wire::EstimateResponse& response);
  void on_state(SimTime now, const wire::State& state);
  void on_position(SimTime now, const wire::ActualPosition& position);
  [[nodiscard]] std::string source_name() const;

  MoveLoopOptions options_;
  const GroundTruthSource& source_;
  Phase phase_{Phase::starting};
  std::string fault_;
  SimTime progressed_{};
  std::optional<SimTime> sent_;   ///< the present request, last; nothing: not sent yet
  std::uint32_t sequence_{0};     ///< of the present iteration's requests
  std::uint32_t moves_{0};        ///< commanded, with those that only stop the vehicle
  std::vector<Pose2> estimated_;  ///< of the present iteration
  std::optional<wire::EstimateResponse::Start> start_;
  std::string map_id_;
  struct Odometer {
    double travelled_m{0.0};
    double since_fiducial_m{0.0};
  };
  Odometer odometer_;  ///< the vehicle's, at its last response
  std::vector<MoveStep> steps_;
  Sent outgoing_;
  std::size_t repeated_{0};
};

}  // namespace cosiva::experiments
