#pragma once

#include <functional>
#include <string>

#include "cosiva/adapters/clock.h"
#include "cosiva/adapters/event_loop.h"
#include "cosiva/experiments/runs/scenario/scenario.h"
#include "cosiva/experiments/runs/scenario/scenario_player.h"

namespace cosiva::app {

/// Plays a scenario to a live server, step by step by the wall's clock. A server that was killed and started again goes
/// on where it was: with the beginning and the number of steps that its earlier life announced.
class LiveScenario {
 public:
  struct Handlers {
    std::function<void(std::string command)> give;  ///< to the server
    /// Each step as it is played, with its running number from 1 on and the time since the beginning.
    std::function<void(std::uint64_t number, SimDuration at, const experiments::Scenario::Step&)> on_step;
  };
  /// @param steps_done  so many were played by an earlier life, and are not played again
  LiveScenario(adapters::EventLoop& loop, experiments::Scenario scenario, std::uint64_t steps_done, Handlers handlers);

  /// The fleet is complete: t_s counts from `began`, which may lie in the past. What is due is played at once.
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
