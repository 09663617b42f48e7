#pragma once

#include <memory>
#include <string>

#include "cosiva/app/platform/run_plan.h"
#include "cosiva/app/platform/run_summary.h"
#include "cosiva/app/platform/trace_writer.h"
#include "cosiva/base/result.h"
#include "cosiva/experiments/runs/world/world.h"

namespace cosiva::app {

/// The whole platform in this process and in virtual time, with its trace and its scenario: common to runs as fast as
/// possible and runs with a page.
class VirtualRun {
 public:
  [[nodiscard]] static Result<std::unique_ptr<VirtualRun>> make(RunPlan plan);

  [[nodiscard]] experiments::World& world() { return *world_; }
  [[nodiscard]] const RunPlan& plan() const { return plan_; }
  /// Virtual time since the start.
  [[nodiscard]] SimDuration elapsed() const { return world_->now() - start_; }
  /// The end of the run: its duration after the beginning of the scenario, or after the start without a scenario.
  /// Nothing where the run has no end of its own.
  [[nodiscard]] std::optional<SimTime> end() const;
  /// The default duration: a minute, or until ten seconds after the scenario's last step.
  [[nodiscard]] double duration_s_default() const;
  void set_duration(double duration_s) { plan_.arguments.duration_s = duration_s; }
  /// Sets a handler that is called with each message, after the trace.
  void also_tap(experiments::World::Tap tap) { more_ = std::move(tap); }

  /// Prints the summary; gives the exit status. For a run that the operator ended early, no complete fleet is required.
  int finish(bool interrupted) const;

 private:
  VirtualRun(RunPlan plan, std::unique_ptr<experiments::World> world);

  RunPlan plan_;
  std::unique_ptr<experiments::World> world_;
  std::unique_ptr<TraceWriter> trace_;
  experiments::World::Tap more_;
  SimTime start_;
};

}  // namespace cosiva::app
