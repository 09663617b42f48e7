#pragma once

#include <cstdint>
#include <optional>
#include <string>

namespace cosiva::app {

/// The options of `cosiva traffic`.
struct FleetTrafficArguments {
  std::string zone{"lacet4"};
  std::string zones;  ///< several zones: a TOML file or a list; empty: one zone
  double away_ratio{0.2};
  double transfer_s{10.0};
  std::string sidecar;
  std::uint64_t aivs{12};
  double duration_s{3600.0};
  double warm_up_s{120.0};
  std::uint64_t seed{1};
  std::optional<double> jobs_per_hour;
  std::string jobs_file;
  double handling_s{10.0};
  std::string rules{"fuzzy"};
  double step_s{0.1};
  std::uint32_t threads{1};
  std::string out_directory;
  bool json{false};
};

}  // namespace cosiva::app
