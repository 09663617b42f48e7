#include "cosiva/app/platform/virtual_time.h"

#include <algorithm>
#include <memory>

#include "cosiva/app/cli/console.h"
#include "cosiva/app/cli/progress.h"
#include "cosiva/app/platform/virtual_page.h"
#include "cosiva/app/platform/virtual_run.h"

namespace cosiva::app {
namespace {

constexpr SimDuration step = std::chrono::milliseconds{500};

/// Runs as fast as possible.
int run_to_the_end(VirtualRun& run) {
  if (!run.plan().arguments.duration_s) run.set_duration(run.duration_s_default());
  Progress progress;
  while (run.world().now() < *run.end()) {
    run.world().run_for(std::min(step, *run.end() - run.world().now()));
    progress.at(to_seconds(run.elapsed()), *run.plan().arguments.duration_s);
  }
  return run.finish(false);
}

}  // namespace

int run_virtual_time(const UpArguments& arguments) {
  if (!arguments.record_file.empty())
    return report_error({"up.record", "a run in virtual time is repeated by its seed; --record is for live runs", {}});
  auto plan = plan_run(arguments);
  if (!plan) return report_error(plan.error());
  auto run = VirtualRun::make(std::move(*plan));
  if (!run) return report_error(run.error());
  return arguments.page ? run_virtual_page(**run) : run_to_the_end(**run);
}

}  // namespace cosiva::app
