#pragma once

#include <memory>
#include <string>

#include "cosiva/app/platform/run_plan.h"
#include "cosiva/app/platform/run_summary.h"
#include "cosiva/app/platform/trace_writer.h"
#include "cosiva/base/result.h"
#include "cosiva/experiments/runs/world/world.h"

namespace cosiva::app {

/// The whole platform in this process and in virtual time, with its trace and its scenario: what the run as fast as the
/// machine can and the run with a page have in common.
class VirtualRun {
 public:
  [[nodiscard]] static Result<std::unique_ptr<VirtualRun>> make(RunPlan plan);

  [[nodiscard]] experiments::World& world() { return *world_; }
  [[nodiscard]] const RunPlan& plan() const { return plan_; }
  /// Virtual time since the start.
  [[nodiscard]] SimDuration elapsed() const { return world_->now() - start_; }
  /// When it is over: its duration after the scenario began, or after the start where there is none. Nothing where it
  /// goes on until somebody ends it.
  [[nodiscard]] std::optional<SimTime> end() const;
  /// So long it lasts where nobody said: a minute, or until ten seconds after the scenario's last step.
  [[nodiscard]] double duration_s_default() const;
  void set_duration(double duration_s) { plan_.arguments.duration_s = duration_s; }
  /// Also told of each message, after the trace.
  void also_tap(experiments::World::Tap tap) { more_ = std::move(tap); }

  /// Prints the summary; gives the exit status. A run that a person ended early promised no fleet.
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
