#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "cosiva/aiv/decision/speed_rules.h"
#include "cosiva/aiv/onboard/onboard_core.h"
#include "cosiva/base/digest.h"
#include "cosiva/base/result.h"
#include "cosiva/experiments/runs/scenario/scenario.h"
#include "cosiva/experiments/runs/world/antennas.h"
#include "cosiva/experiments/runs/world/core_store.h"
#include "cosiva/experiments/runs/world/fault_injection.h"
#include "cosiva/physical/plant/plant_core.h"
#include "cosiva/physical/plant/plant_options.h"
#include "cosiva/virtual/server/core/server_core.h"
#include "cosiva/wire/runtime/network.h"
#include "cosiva/zone/rtm/rtm.h"

namespace cosiva::experiments {

/// The server of another control area, on the same broker.
struct OtherServer {
  virtual_side::ServerOptions options;
  std::shared_ptr<CoreStore> store{};  ///< as WorldOptions::server_store
};

/// A crossing unit of a world.
struct WorldUnit {
  std::string crossing;  ///< "X1"
  bool off{false};       ///< it begins switched off
};

struct WorldOptions {
  zone::ZoneConfiguration zone;
  std::uint32_t aivs{4};
  std::uint64_t seed{1};
  wire::NetworkFaults network;  ///< V2X messages bypass the broker, unless another prefix is given
  physical::PlantNoise noise;
  /// Of the physical AIVs; virtual AIVs have the server's.
  aiv::SpeedRules rules{aiv::SpeedRules::Kind::fuzzy, {}, {}};
  bool v2x{true};                                       ///< likewise
  std::vector<physical::VehicleEquipment> equipment{};  ///< as PlantOptions::equipment
  /// Physical AIVs have a direct link to each other, with these faults and its own random numbers; nothing: none.
  std::optional<wire::NetworkFaults> radio{};
  std::optional<RadioReach> reach{};  ///< of the direct link; nothing: the whole zone
  /// Processes first_unit, first_unit + 1, …
  std::vector<WorldUnit> units{};
  /// What is special about the options of a physical AIV; empty: nothing.
  std::function<void(aiv::OnboardOptions&)> adapt_aiv{};
  virtual_side::ServerOptions server;
  /// Orders, frequent messages of vehicles and the frames of their boards are passed on as values, without writing or
  /// reading texts and bytes (wire/in_process/typed_message.h, board_frames.h): the same run, to the last bit of all
  /// estimates, in less than half of the time. A tap receives such messages without their text.
  bool as_values{false};
  /// The common period of all components: the plant and its boards, then the vehicles, then the server, one after
  /// another within a hundredth of a second. Nothing: each component has its own period, as on the live platform (10
  /// and 20 ms), and they are out of phase. From 20 to 100 ms (checked): with longer periods boards and drives time
  /// out.
  std::optional<SimDuration> cycle{};
  bool ground_truth{true};  ///< the plant publishes the ground truth for instruments, ten times per second
  /// Built from `zone` already, where it is known; null: the world builds it, once for all of its programs.
  std::shared_ptr<const zone::Rtm> rtm{};
  /// Stores the server's inputs and state; null: its state alone survives a crash, at once. Not together with
  /// `as_values` (checked), because a store needs texts.
  std::shared_ptr<CoreStore> server_store{};
  /// Processes first_other_server, first_other_server + 1, …: with several servers each has a control area
  /// (ServerOptions::area) and a zone of its own, and `zone` is the floor with all their paths.
  std::vector<OtherServer> other_servers{};
};

/// Whether an experiment's run with this seed passes messages on as values: all but one seed in ten, which keeps the
/// texts and frames of the real wire in the experiment. The outcome is the same.
[[nodiscard]] constexpr bool passes_values(std::uint64_t seed) { return seed % 10 != 0; }

/// The whole platform in virtual time.
///
/// Invariant: time never goes back.
class World {
 public:
  [[nodiscard]] static Result<std::unique_ptr<World>> make(WorldOptions options);
  ~World();

  /// Runs every event due in the next `duration`.
  void run_for(SimDuration duration);
  [[nodiscard]] SimTime now() const;

  /// Gives an operator's command to the server or the plant, as Input::command.
  /// @param decoded  the server's command where the sender has decoded it; null: the server decodes it
  void command_server(std::string json, std::shared_ptr<const wire::InProcessMessage> decoded = {});
  void command_plant(std::string json);
  /// Plays a scenario from the moment the fleet is complete (each AIV with its one twin), step by step at their times,
  /// independent of how the run is divided; a scenario played before is discarded. Steps due while the server is down
  /// are played once the server is up and the fleet is complete again.
  void play(const Scenario& scenario);
  /// When the fleet was complete and the scenario began.
  [[nodiscard]] std::optional<SimTime> scenario_began() const;
  [[nodiscard]] bool scenario_done() const;  ///< true without a scenario as well
  /// Sets a handler that is called with each step when it is played.
  using OnStep = std::function<void(SimTime, const Scenario::Step&)>;
  void on_step(OnStep action);
  /// Processes that die and are restarted: kill breaks the core's connections at once, without a disconnect message.
  void kill_aiv(std::uint32_t number);
  void start_aiv(std::uint32_t number);
  void kill_server();
  void start_server();
  /// Valid as long as the world.
  [[nodiscard]] FaultInjection& faults();
  /// Sets a handler of every message as it is published (time, from, message).
  using Tap = std::function<void(SimTime, const std::string& from, const wire::Publish&)>;
  void tap(Tap tap);
  /// Sets a handler of every input of the server with the effects that it had, after the server has handled it.
  using ServerObserver = std::function<void(const wire::Input&, const wire::Effects&)>;
  void observe_server(ServerObserver observer);

  [[nodiscard]] const physical::PlantCore& plant() const;
  /// @param process  of a server (checked)
  [[nodiscard]] const virtual_side::ServerCore& server(Process process = server_process) const;
  [[nodiscard]] const aiv::OnboardCore& aiv(std::uint32_t number) const;
  [[nodiscard]] const wire::Network& network() const;
  /// Warnings and errors that the cores logged, with time and name; at most 10 000.
  [[nodiscard]] const std::vector<std::string>& log() const;
  /// Combines every core's digest.
  [[nodiscard]] Digest digest() const;
  /// Combines the present estimates of all running cores, without their previous messages.
  [[nodiscard]] Digest estimates() const;

 private:
  World();
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace cosiva::experiments
