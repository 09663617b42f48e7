#pragma once

#include <cstdint>
#include <string>
#include <vector>

namespace cosiva::app {

/// The options of `cosiva capacity`.
struct CapacityArguments {
  std::string zone{"lacet4"};
  std::string rules{"fuzzy"};
  std::uint64_t vehicles_max{1'000'000};
  double seconds{2.0};  ///< measuring time of each size
  std::vector<std::uint32_t> live{4, 12};
  std::string live_zone{"lacet4"};
  double live_s{15.0};
  std::string out_file;
  bool json{false};
};

/// `cosiva capacity`. Gives the exit status: 0 done, 1 the run's own checks failed, 2 bad usage or bad input.
int run_capacity(const CapacityArguments& arguments);

}  // namespace cosiva::app
