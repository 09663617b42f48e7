#include "cosiva/app/positioning/qualify_candidates.h"

#include <algorithm>
#include <thread>

#include "cosiva/app/positioning/external_algorithm.h"
#include "cosiva/app/resources/reference_budget.h"

namespace cosiva::app {
namespace {

using experiments::Candidate;

Candidate candidate_of(const estimation::Registry& registry, const estimation::Registered& registered,
                       const QualifyArguments& arguments) {
  const auto make = [&registry, name = registered.name, particles = arguments.particles,
                     horizon = arguments.horizon](estimation::Setting setting) {
    setting.particles = particles;
    setting.horizon = horizon;
    return registry.make(name, setting);
  };
  return {registered.name, registered.what, registered.backtracks, make};
}

Result<Candidate> external_of(const std::string& text, std::chrono::milliseconds timeout) {
  const std::size_t equals = text.find('=');
  if (equals == 0 || equals == std::string::npos || equals + 1 == text.size())
    return fail("algorithm.external", "expected NAME=COMMAND, such as \"mine=python3 mine.py\"", "--external " + text);
  const std::string name = text.substr(0, equals);
  const std::string command = text.substr(equals + 1);
  const auto make = [name, command, timeout](const estimation::Setting& setting) {
    return ExternalAlgorithm::start(name, command, setting, timeout);
  };
  return Candidate{name, "external: " + command, false, make};
}

}  // namespace

std::size_t threads_for(const QualifyArguments& arguments) {
  return arguments.threads > 0 ? arguments.threads : std::max(1U, std::thread::hardware_concurrency());
}

experiments::Alignment alignment_of(const QualifyArguments& arguments) {
  for (const auto how : {experiments::Alignment::se2, experiments::Alignment::se3, experiments::Alignment::origin}) {
    if (arguments.align == to_string(how)) return how;
  }
  return experiments::Alignment::none;
}

Result<experiments::ReferenceBudget> reference_of(const QualifyArguments& arguments) {
  if (arguments.reference_budget.empty()) {
    experiments::ReferenceBudget budget;
    if (arguments.reference_m) budget.parts.push_back({"all of it", *arguments.reference_m, "--reference-error"});
    return budget;
  }
  if (arguments.reference_m)
    return fail("compare.reference", "both options state the same uncertainty: give one of them",
                "--reference-budget, --reference-error");
  return load_reference_budget(arguments.reference_budget);
}

Result<std::vector<Candidate>> candidates_of(const QualifyArguments& arguments, const estimation::Registry& registry,
                                             bool on_track, const std::vector<std::string>& usual) {
  std::vector<Candidate> candidates;
  std::vector<std::string> names = arguments.algorithms;
  const bool all = names == std::vector<std::string>{"all"};
  std::vector<Candidate> externals;
  for (const std::string& text : arguments.external) {
    auto external = external_of(text, std::chrono::milliseconds{static_cast<int>(1e3 * arguments.timeout_s)});
    if (!external) return tl::unexpected(external.error());
    // An external program's name may be among the other names, to define its position in the list.
    std::erase(names, external->name);
    if (registry.find(external->name))
      return fail("algorithm.duplicate", "an algorithm of the platform has this name", external->name);
    externals.push_back(std::move(*external));
  }
  if (arguments.algorithms.empty() && (externals.empty() || !usual.empty())) names = usual;
  if (all) names.clear();
  for (const estimation::Registered& one : registry.all()) {
    if (all && (on_track || !one.needs_track)) names.push_back(one.name);
  }
  for (const std::string& name : names) {
    const auto registered = registry.find(name);
    if (!registered) return tl::unexpected(registered.error());
    candidates.push_back(candidate_of(registry, **registered, arguments));
  }
  std::ranges::move(externals, std::back_inserter(candidates));
  for (std::size_t i = 0; i < candidates.size(); ++i) {
    for (std::size_t k = 0; k < i; ++k) {
      if (candidates[i].name == candidates[k].name)
        return fail("algorithm.duplicate", "the name is given twice", candidates[i].name);
    }
  }
  return candidates;
}

std::vector<std::string> usual_algorithms(const QualifyArguments& arguments, bool on_track, std::size_t at_least) {
  if (at_least == 1) {
    if (!arguments.external.empty()) return {};
    return {on_track ? "arc_kalman" : "calibrating"};
  }
  if (on_track)
    return {"dead_reckoning", "reset_rule", "arc_kalman", "arc_kalman_scale", "ekf", "iekf", "ufir", "arc_smoother"};
  return {"dead_reckoning", "ekf", "ukf", "iekf", "calibrating", "smoother"};
}

}  // namespace cosiva::app
