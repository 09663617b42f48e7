#pragma once

#include <cstddef>
#include <memory>

#include "cosiva/app/positioning/qualify_arguments.h"
#include "cosiva/base/result.h"
#include "cosiva/experiments/positioning/metrology/qualification.h"
#include "cosiva/experiments/positioning/metrology/result.h"

namespace cosiva::app {

/// Where runs come from: made in virtual time, read from folders, or lived on a platform that runs.
struct Runs {
  experiments::TrialSource source;
  std::size_t count{};
  bool on_track{};
  bool complete{true};  ///< as many as were asked for
  experiments::Conditions conditions;
  std::shared_ptr<void> kept;  ///< what the source refers to
};
[[nodiscard]] Result<Runs> virtual_runs(const QualifyArguments& arguments);
[[nodiscard]] Result<Runs> recorded_runs(const QualifyArguments& arguments);

}  // namespace cosiva::app
