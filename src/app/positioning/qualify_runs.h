#pragma once

#include <cstddef>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "cosiva/app/positioning/qualify_arguments.h"
#include "cosiva/base/result.h"
#include "cosiva/experiments/positioning/metrology/qualification.h"
#include "cosiva/experiments/positioning/metrology/result.h"

namespace cosiva::app {

/// Sources of runs: simulated in virtual time, read from folders, or recorded live on a running platform.
struct Runs {
  experiments::TrialSource source;
  std::size_t count{};
  bool on_track{};
  bool complete{true};  ///< as many as requested
  experiments::Conditions conditions;
  std::vector<std::pair<std::string, std::string>> files{};  ///< further files of the result: name and content
  std::shared_ptr<void> kept;                                ///< what the source refers to
};
[[nodiscard]] Result<Runs> virtual_runs(const QualifyArguments& arguments);
[[nodiscard]] Result<Runs> recorded_runs(const QualifyArguments& arguments);

}  // namespace cosiva::app
