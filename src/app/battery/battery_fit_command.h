#pragma once

#include <string>
#include <vector>

namespace cosiva::app {

/// The options of `cosiva battery fit`.
struct BatteryFitArguments {
  std::vector<std::string> files;
  std::vector<std::string> series;   ///< only those whose name contains one of these; empty: all
  std::vector<std::string> predict;  ///< logs, or series of the files, that are predicted instead of fitted
  std::string name{"fitted"};
  std::string source;
  std::string licence;
  double capacity_ah{0.0};
  double floor_v{0.0};
  std::string out_file;
  bool json{false};
};

/// `cosiva battery fit`: fits a battery type to a tester's logs. Gives the exit status: 0 done, 1 the run's own checks
/// failed, 2 bad usage or bad input.
int run_battery_fit(const BatteryFitArguments& arguments);

}  // namespace cosiva::app
