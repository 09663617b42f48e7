#pragma once

#include <cstdint>
#include <string>
#include <vector>

namespace cosiva::app {

/// The options of `cosiva battery analyse`.
struct BatteryAnalyseArguments {
  std::vector<std::string> files;   ///< tables, or results of tests
  std::vector<std::string> only;    ///< series of the files; none: all
  std::vector<std::string> failed;  ///< BATTERY=SECONDS: evaluated as if the battery's vehicle had failed at this time
  std::string time;                 ///< columns; empty: the usual names
  std::string battery;
  std::string vehicle;
  std::string run;
  double half_width_percent{0.0};
  std::string out_directory;
  std::uint64_t seed{1};
  bool json{false};
};

/// `cosiva battery analyse`: evaluates tests that were made before, with CoSiVA or elsewhere. Gives the exit status: 0
/// done, 1 the run's own checks failed, 2 bad usage or bad input.
int run_battery_analyse(const BatteryAnalyseArguments& arguments);

}  // namespace cosiva::app
