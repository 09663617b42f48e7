#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "cosiva/app/cli/common_arguments.h"

namespace cosiva::app {

/// The options of `cosiva battery sampled` and `fleet`.
struct BatteryTestArguments {
  std::string zone;  ///< empty: lacet4 of a sampled test, and oval, which has no crossings, of a fleet's
  std::uint32_t aivs{4};
  std::string type{"lipo850"};  ///< name of a shipped type, or a file
  std::uint32_t series{0};      ///< 0: as in the type; for the carts' usual type, as in the carts
  std::uint32_t parallel{0};
  double scale{0.0};
  std::string gauge{"kalman"};
  double floor_percent{20.0};
  std::size_t repeat{1};
  bool swap{false};
  double pause_every_s{0.0};
  double pause_s{0.0};
  double failures_per_hour{0.0};
  double load_sd_percent{2.0};
  double ambient_c{22.0};
  double measure_s{120.0};
  bool whole{false};
  std::optional<double> hz;  ///< rate of all components in the loop, with `whole`
  double half_width_percent{0.0};
  std::string state_file;
  std::string out_directory;
  std::string rules;
  std::uint64_t seed{1};
  bool json{false};
  // Of tests on a running platform:
  bool live{false};
  std::string url{"http://127.0.0.1:8080"};
  BrokerArguments broker;
  std::vector<std::string> vehicles;   ///< MANUFACTURER/SERIAL; none: AIV1, AIV2 …
  std::vector<std::string> batteries;  ///< names of the batteries; none: lipo850-1 …
  bool by_hand{false};                 ///< operators change the batteries
  std::string park;                    ///< a station
  double lost_after_s{30.0};
  std::string notify;  ///< a shell command
};

}  // namespace cosiva::app
