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
#include "cosiva/experiments/positioning/metrology/live_run.h"
#include "cosiva/wire/messages/topics.h"
#include "cosiva/wire/own/estimate_exchange.h"
#include "cosiva/wire/runtime/core.h"
#include "cosiva/zone/layout/traffic_zone.h"

namespace cosiva::experiments {

struct LiveRunsOptions {
  std::vector<wire::VehicleId> vehicles;  ///< each drives one run at a time, until all are driven
  std::size_t runs{1};
  double distance_m{100.0};             ///< TDTmax
  double rate_hz{20.0};                 ///< nextEstimatedPosition so often
  std::vector<std::string> algorithms;  ///< on board
  std::uint64_t seed{1};                ///< of the first run; the others count on
  std::uint32_t particles{500};
  std::uint32_t horizon{4};
  std::optional<double> speed_mps;  ///< the vehicles are told; none: as they drive
  /// Who says where the vehicles truly are: {"timestamp","vehicles":[{"number","x","y","heading"}…]} as the plant does,
  /// or {"sights":[{"vehicle":"CoSiVA/AIV1","at","x","y","heading"}…]} as a global vision system.
  std::string ground_truth_topic{std::string(wire::ground_truth_topic)};
  SimDuration gap_max{std::chrono::milliseconds{500}};  ///< the truth is interpolated between stamps no further apart
  SimDuration timeout{std::chrono::seconds{10}};        ///< who says nothing for so long is lost
  SimDuration stopped_max{std::chrono::minutes{1}};     ///< and who does not move
  std::string name;                                     ///< of this test, among all that the vehicles hear
};

/// The scenarios of figures 16 and 17 on a platform that runs, over its bus (A33, A35): told what comes, it answers
/// what is to be said. It owns no link, clock or file. Each run: move is commanded, and until the vehicle has gone
/// TDTmax it is asked for its nextEstimatedPosition again and again, and what it says is noted; where it then truly
/// was, the global vision system says, or the plant that plays it. What is lost is asked for again; a vehicle that
/// begins anew drives the run anew; one that is lost leaves its run to the others.
class LiveRuns {
 public:
  struct Responses {
    std::vector<wire::Publish> messages;
    std::vector<std::string> commands;           ///< to the server, as /api/v1/commands takes them, in this order
    std::vector<std::string> operator_messages;  ///< to the operator
  };
  explicit LiveRuns(LiveRunsOptions options);

  [[nodiscard]] std::vector<std::string> subscriptions() const;
  /// A zone that somebody hands out: the vehicles name the one that they drive in.
  void on_zone(std::shared_ptr<const zone::TrafficZone> zone);
  void on_message(SimTime now, std::string_view topic, std::string_view payload);
  /// Due some hundred times a second.
  [[nodiscard]] Responses tick(SimTime now);
  /// Ended by its operator: the runs that are complete count.
  void give_up();

  [[nodiscard]] bool done() const;
  /// Complete ones, in the order of their seeds.
  [[nodiscard]] std::vector<std::shared_ptr<const LiveRun>> take_runs();
  /// Why there are fewer than were asked for: a line per vehicle that was lost.
  [[nodiscard]] const std::vector<std::string>& losses() const { return losses_; }
  /// Answers beside which nobody said where the vehicle was.
  [[nodiscard]] std::size_t without_ground_truth() const { return without_ground_truth_; }
  [[nodiscard]] std::size_t repeated() const { return repeated_; }  ///< requests
  [[nodiscard]] const std::string& map_id() const { return map_id_; }

  struct Progress {
    std::size_t complete{};
    double ratio{};  ///< of the way of all runs
    std::optional<double> left_s;
  };
  [[nodiscard]] Progress progress(SimTime now) const;

 private:
  struct Slot {
    wire::VehicleId vehicle;
    bool lost{false};
    std::vector<TrueFix> ground_truth;  ///< since its run began
    std::optional<SimTime> ground_truth_received;
    std::optional<RunLog> run;  ///< none: it waits for one
    std::size_t index{};        ///< of the run
    std::string session;
    std::uint32_t sequence{};
    bool waiting{false};  ///< for the answer to it
    SimTime requested{};
    SimTime received{};  ///< an answer, last
    SimTime moved{};
    unsigned begun{};  ///< times that this run was
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
  std::vector<Slot> slots_;
  std::deque<std::size_t> to_drive_;
  std::map<std::size_t, std::shared_ptr<const LiveRun>> complete_;
  std::map<std::string, std::shared_ptr<const zone::TrafficZone>, std::less<>> zones_;
  std::string map_id_;  ///< that the first answer named
  std::vector<std::string> losses_;
  std::vector<std::string> operator_messages_;
  std::optional<SimTime> began_;
  std::size_t sessions_{0};
  std::size_t without_ground_truth_{0};
  std::size_t repeated_{0};
  bool given_up_{false};
};

}  // namespace cosiva::experiments
