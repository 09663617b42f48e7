#pragma once

#include <functional>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "cosiva/aiv/estimation/algorithm.h"
#include "cosiva/base/result.h"

namespace cosiva::estimation {

/// An algorithm that can be requested by name.
struct Registered {
  std::string name;  ///< "arc_kalman"
  std::string what;  ///< one line for people
  bool needs_track;  ///< it follows a track, and cannot run without
  bool backtracks;   ///< its results come from the whole run: not for use on board
  std::function<std::unique_ptr<Algorithm>(const Setting&)> make;
};

/// Algorithms by name, in the order in which they were added. Invariant: no two have the same name.
class Registry {
 public:
  /// With the algorithms that come with the platform.
  Registry();
  /// Fails ("algorithm.duplicate") where the name is taken, ("algorithm.name") on one that is not [a-z0-9_]+.
  Result<void> add(Registered algorithm);
  [[nodiscard]] const std::vector<Registered>& all() const { return all_; }
  /// Fails ("algorithm.unknown") with the existing names.
  [[nodiscard]] Result<const Registered*> find(std::string_view name) const;
  /// Fails as find does, ("algorithm.track") where the algorithm needs a track and there is none, and
  /// ("algorithm.start") where it needs a known start and there is none.
  [[nodiscard]] Result<std::unique_ptr<Algorithm>> make(std::string_view name, const Setting& setting) const;

 private:
  std::vector<Registered> all_;
};

}  // namespace cosiva::estimation
