#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

/// What the command line said of `cosiva traffic` and `cosiva capacity`, as plain values.
namespace cosiva::app {

/// Of `traffic`.
struct FleetTrafficArguments {
  std::string zone{"lacet4"};
  std::string zones;  ///< several: a TOML file or a list; empty: one
  double away_share{0.2};
  double passage_s{10.0};
  std::string companion;
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

/// Of `capacity`.
struct CapacityArguments {
  std::string zone{"lacet4"};
  std::string rules{"fuzzy"};
  std::uint64_t vehicles_max{1'000'000};
  double seconds{2.0};  ///< of measuring, for each size
  std::vector<std::uint32_t> live{4, 12};
  std::string live_zone{"lacet4"};
  double live_s{15.0};
  std::string out_file;
  bool json{false};
};

/// Each runs one verb and gives the exit status: 0 done, 1 the run's own checks failed, 2 bad usage or bad input.
int run_traffic(const FleetTrafficArguments& arguments);
int run_site(const FleetTrafficArguments& arguments);
int run_capacity(const CapacityArguments& arguments);

}  // namespace cosiva::app
