#pragma once

#include "cosiva/app/cli/common_arguments.h"
#include "cosiva/app/gvs/gvs_source.h"

namespace cosiva::app {

/// The options of `cosiva gvs watch`.
struct GvsWatchArguments {
  PartArguments part;
  GvsSource source;
};

/// `cosiva gvs watch`: publishes the actual positions of a running platform's AIVs on the broker. Gives the exit
/// status: 0 done, 1 the run's own checks failed, 2 bad usage or bad input.
int run_gvs_watch(const GvsWatchArguments& arguments);

}  // namespace cosiva::app
