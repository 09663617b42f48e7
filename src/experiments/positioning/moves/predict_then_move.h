#pragma once

#include <cstdint>
#include <deque>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "cosiva/experiments/positioning/metrology/platform_test.h"
#include "cosiva/experiments/positioning/moves/move_loop.h"

namespace cosiva::experiments {

/// Steps of complete runs, by the index of the run.
using MoveStepsByRun = std::map<std::size_t, std::vector<MoveStep>>;

struct PredictThenMoveOptions {
  std::vector<wire::VehicleId> vehicles;  ///< each drives one run at a time, until all runs are driven
  std::size_t runs{1};
  double distance_m{10.0};  ///< TDTmax
  double step_m{0.1};       ///< of each move, from step_m_min to wire::EstimateRequest::move_m_max
  std::vector<std::string> algorithms;
  std::uint64_t seed{1};  ///< of the first run; the following runs count up
  std::uint32_t particles{500};
  std::uint32_t horizon{4};
  std::optional<double> speed_mps;                   ///< commanded speed; none: their present speed
  SimDuration timeout{std::chrono::seconds{10}};     ///< a vehicle or a GVS without a response for this time is lost
  SimDuration stopped_max{std::chrono::minutes{1}};  ///< and so is a vehicle whose move does not end
  std::string name;                                  ///< of this test, among all tests on the platform
  static constexpr double step_m_min = 0.02;
};

/// Figures 16 and 17 with the simulator as the pivot (A33, A35), on a platform: runs of MoveLoop on its vehicles. A run
/// that fails is repeated, at most three times; a lost vehicle leaves its runs to the others.
///
/// Invariant: each run waits, is driven by one vehicle, or is complete.
class PredictThenMove final : public PlatformTest {
 public:
  explicit PredictThenMove(PredictThenMoveOptions options);

  [[nodiscard]] std::vector<std::string> subscriptions() const override;
  void on_zone(std::shared_ptr<const zone::TrafficZone> zone) override;
  void on_message(SimTime now, std::string_view topic, std::string_view payload) override;
  [[nodiscard]] Responses tick(SimTime now) override;
  void give_up() override { given_up_ = true; }

  [[nodiscard]] bool done() const override;
  [[nodiscard]] std::vector<std::shared_ptr<const LiveRun>> take_runs() override;
  [[nodiscard]] const std::vector<std::string>& losses() const override { return losses_; }
  /// Each step has its actual position, or the run is not complete.
  [[nodiscard]] std::size_t without_ground_truth() const override { return 0; }
  [[nodiscard]] std::size_t repeated() const override { return repeated_; }
  [[nodiscard]] const std::string& map_id() const override { return map_id_; }
  [[nodiscard]] const GroundTruthSource& source() const override { return source_; }
  [[nodiscard]] Progress progress(SimTime now) const override;

  /// Steps of the complete runs, by run: (PA, PE1, PE2, …).
  [[nodiscard]] const MoveStepsByRun& steps() const { return steps_; }
  /// The calls of the first run, in their order.
  [[nodiscard]] const std::vector<Call>& calls() const { return calls_; }

 private:
  struct Slot {
    wire::VehicleId vehicle;
    bool lost{false};
    std::unique_ptr<MoveLoop> loop;  ///< none: the vehicle waits for a run
    std::size_t index{};             ///< of the run
    unsigned begun{};                ///< number of starts of this run
  };
  void begin(SimTime now, Slot& slot, Responses& responses);
  void supervise(SimTime now, Slot& slot, Responses& responses);
  void complete(SimTime now, Slot& slot, Responses& responses);
  void lose(Slot& slot, const std::string& why);
  void drive_on(SimTime now, const wire::VehicleId& vehicle, Responses& responses) const;
  [[nodiscard]] std::optional<std::string> missing(SimTime now, const MoveLoop& loop) const;

  PredictThenMoveOptions options_;
  GroundTruthSource source_;
  std::vector<Slot> slots_;
  std::deque<std::size_t> to_drive_;
  std::map<std::size_t, std::shared_ptr<const LiveRun>> complete_;
  MoveStepsByRun steps_;
  std::vector<Call> calls_;
  std::map<std::string, std::shared_ptr<const zone::TrafficZone>, std::less<>> zones_;
  std::string map_id_;  ///< named by the first complete run
  std::vector<std::string> losses_;
  std::vector<std::string> operator_messages_;
  std::optional<SimTime> began_;
  std::size_t sessions_{0};
  std::size_t repeated_{0};
  bool given_up_{false};
};

/// A line per step: run, vehicle's travelled distance, PA, and each PE with its error.
[[nodiscard]] std::string steps_csv(const MoveStepsByRun& runs, const std::vector<std::string>& algorithms);
/// A line per call of the first run: time, from, to, text.
[[nodiscard]] std::string calls_text(const std::vector<Call>& calls);

}  // namespace cosiva::experiments
