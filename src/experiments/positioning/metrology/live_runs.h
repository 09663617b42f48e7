#pragma once

#include <cstdint>
#include <deque>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "cosiva/base/time.h"
#include "cosiva/experiments/positioning/metrology/platform_test.h"
#include "cosiva/wire/messages/topics.h"
#include "cosiva/wire/own/estimate_exchange.h"
#include "cosiva/wire/runtime/core.h"
#include "cosiva/zone/layout/traffic_zone.h"

namespace cosiva::experiments {

struct LiveRunsOptions {
  std::vector<wire::VehicleId> vehicles;  ///< each drives one run at a time, until all runs are driven
  std::size_t runs{1};
  double distance_m{100.0};             ///< TDTmax
  double rate_hz{20.0};                 ///< rate of nextEstimatedPosition
  std::vector<std::string> algorithms;  ///< on board
  std::uint64_t seed{1};                ///< of the first run; the following runs count up
  std::uint32_t particles{500};
  std::uint32_t horizon{4};
  std::optional<double> speed_mps;  ///< commanded speed of the vehicles; none: their present speed
  /// The topic of the vehicles' actual positions: {"timestamp","vehicles":[{"number","x","y","heading"}…]} from the
  /// plant, or {"detections":[{"vehicle":"CoSiVA/AIV1","at","x","y","heading"}…]} from a global vision system.
  /// Empty: the GVS where one is in operation, otherwise the plant (GroundTruthSource).
  std::string ground_truth_topic{};
  SimDuration gap_max{
      std::chrono::milliseconds{500}};  ///< greatest distance of stamps between which the ground truth is interpolated
  SimDuration timeout{std::chrono::seconds{10}};     ///< a vehicle without a response for this time is lost
  SimDuration stopped_max{std::chrono::minutes{1}};  ///< and so is a vehicle without motion
  std::string name;  ///< of this test, among all tests that the vehicles receive requests of
};

/// The scenarios of figures 16 and 17 on a running platform, over its bus (A33, A35), with vehicles that
/// drive on. In each run the move is commanded, and until
/// the vehicle has driven TDTmax, requests for its nextEstimatedPosition are sent repeatedly and its responses
/// recorded; the actual position comes from the global vision system, or from the plant instead. A lost request is
/// repeated; a vehicle that restarts repeats the run; a lost vehicle leaves its run to the others.
///
/// Invariant: each run waits, is driven by one vehicle, or is complete.
class LiveRuns final : public PlatformTest {
 public:
  explicit LiveRuns(LiveRunsOptions options);

  [[nodiscard]] std::vector<std::string> subscriptions() const override;
  void on_zone(std::shared_ptr<const zone::TrafficZone> zone) override;
  void on_message(SimTime now, std::string_view topic, std::string_view payload) override;
  [[nodiscard]] Responses tick(SimTime now) override;
  void give_up() override;

  [[nodiscard]] bool done() const override;
  [[nodiscard]] std::vector<std::shared_ptr<const LiveRun>> take_runs() override;
  [[nodiscard]] const std::vector<std::string>& losses() const override { return losses_; }
  [[nodiscard]] std::size_t without_ground_truth() const override { return without_ground_truth_; }
  [[nodiscard]] std::size_t repeated() const override { return repeated_; }
  [[nodiscard]] const std::string& map_id() const override { return map_id_; }
  [[nodiscard]] const GroundTruthSource& source() const override { return source_; }
  [[nodiscard]] Progress progress(SimTime now) const override;

 private:
  struct Slot {
    wire::VehicleId vehicle;
    bool lost{false};
    std::vector<TrueFix> ground_truth;             ///< since its run began
    std::optional<SimTime> ground_truth_received;  ///< or its run began, where there is none yet
    std::optional<RunLog> run;                     ///< none: the vehicle waits for a run
    std::size_t index{};                           ///< of the run
    std::string session;
    std::uint32_t sequence{};
    bool waiting{false};  ///< for the response
    SimTime requested{};
    SimTime received{};  ///< time of the last response
    SimTime moved{};
    unsigned begun{};  ///< number of starts of this run
  };
  void on_ground_truth(SimTime now, std::string_view payload);
  void on_response(SimTime now, Slot& slot, std::string_view payload);
  void begin(SimTime now, Slot& slot, Responses& responses);
  void send_requests(SimTime now, Slot& slot, Responses& responses);
  void begin_anew(Slot& slot, const std::string& why);
  void supervise(SimTime now, Slot& slot, Responses& responses);
  void complete(Slot& slot);
  void lose(Slot& slot, const std::string& why);
  [[nodiscard]] std::optional<std::string> missing(SimTime now, const Slot& slot) const;

  LiveRunsOptions options_;
  GroundTruthSource source_;
  std::vector<Slot> slots_;
  std::deque<std::size_t> to_drive_;
  std::map<std::size_t, std::shared_ptr<const LiveRun>> complete_;
  std::map<std::string, std::shared_ptr<const zone::TrafficZone>, std::less<>> zones_;
  std::string map_id_;  ///< named by the first response
  std::vector<std::string> losses_;
  std::vector<std::string> operator_messages_;
  std::optional<SimTime> began_;
  std::size_t sessions_{0};
  std::size_t without_ground_truth_{0};
  std::size_t repeated_{0};
  bool given_up_{false};
};

}  // namespace cosiva::experiments
