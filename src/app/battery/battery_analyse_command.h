#pragma once

#include <cstdint>
#include <string>
#include <vector>

namespace cosiva::app {

/// The options of `cosiva battery analyse`.
struct BatteryAnalyseArguments {
  std::vector<std::string> files;   ///< tables, or results of tests
  std::vector<std::string> only;    ///< series of them; none: all
  std::vector<std::string> failed;  ///< BATTERY=SECONDS: as if it had failed then
  std::string time;                 ///< columns; empty: the usual names
  std::string battery;
  std::string vehicle;
  std::string run;
  double half_width_percent{0.0};
  std::string out_directory;
  std::uint64_t seed{1};
  bool json{false};
};

/// `cosiva battery analyse`: tests that were made before, here or by others. Gives the exit status: 0 done, 1 the run's
/// own checks failed, 2 bad usage or bad input.
int run_battery_analyse(const BatteryAnalyseArguments& arguments);

}  // namespace cosiva::app
