#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "cosiva/app/cli/common_arguments.h"
#include "cosiva/app/gvs/gvs_source.h"
#include "cosiva/app/platform/direct_arguments.h"
#include "cosiva/app/platform/limit_arguments.h"

namespace cosiva::app {

/// The options of `cosiva up`.
struct UpArguments {
  std::string scenario;  ///< name of a ready scenario, or a file; empty: none
  std::string name;      ///< of the run; empty: default_run_name
  /// Options given on the command line, which override the scenario.
  struct Given {
    bool zone{false};
    bool aivs{false};
    bool seed{false};
    bool duration{false};
    bool crossing_units{false};
  };
  Given given;
  std::string zone{"lacet4"};
  bool watch{false};
  std::uint32_t aivs{4};
  bool headless{false};
  std::optional<double> duration_s;
  bool json{false};
  std::uint64_t seed{1};
  std::uint16_t port{8080};
  BrokerArguments broker;
  std::string record_file;
  std::string log_directory;
  LogLimitArguments log_limits;
  ServerLimitArguments limits;
  std::string store;  ///< its folder, which the run continues; empty: a new one in the folder of the logs
  std::string keep;   ///< how much of the store is retained (parse_keep); empty: the default
  double respawn_s{5.0};
  std::string run_directory;
  bool virtual_time{false};
  bool page{false};             ///< with virtual time: at the page's own speed, with the page
  std::optional<double> speed;  ///< virtual seconds per second, with `page`
  double loss{0.0};
  std::string trace_file;
  std::string web_directory;
  bool v2x{true};
  DirectArguments direct;
  std::vector<std::string> crossing_units;  ///< crossings with a unit, or all
  bool convoys{true};
  bool gvs{false};  ///< a camera observes the zone
  GvsSource gvs_source;
  std::vector<std::string> line_tracking;  ///< NAME or VEHICLE=NAME
  std::vector<std::string> without_rali;   ///< numbers of vehicles, or all
  std::string rules;                       ///< crisp, fuzzy or a file; empty: fuzzy
};

}  // namespace cosiva::app
