#pragma once

#include <functional>
#include <string>

#include "cosiva/adapters/clock.h"
#include "cosiva/adapters/event_loop.h"
#include "cosiva/experiments/runs/scenario/scenario.h"
#include "cosiva/experiments/runs/scenario/scenario_player.h"

namespace cosiva::app {

/// Plays a scenario to a live server, step by step in real time. A restarted server continues the scenario, with the
/// beginning and the number of steps that its previous run announced.
class LiveScenario {
 public:
  struct Handlers {
    std::function<void(std::string command)> give;  ///< to the server
    /// Called with each step as it is played, with its running number from 1 on and the time since the beginning.
    std::function<void(std::uint64_t number, SimDuration at, const experiments::Scenario::Step&)> on_step;
  };
  /// @param steps_done  this number of steps was played by a previous run, and is not played again
  LiveScenario(adapters::EventLoop& loop, experiments::Scenario scenario, std::uint64_t steps_done, Handlers handlers);

  /// The fleet is complete: t_s counts from `began`, which may lie in the past. Steps that are due are played at once.
  void begin(SimTime began);

 private:
  void play_due();

  Handlers handlers_;
  adapters::WallClock clock_;
  experiments::ScenarioPlayer player_;
  std::uint64_t done_;
  SimTime began_{};
  adapters::Timer timer_;
};

}  // namespace cosiva::app
