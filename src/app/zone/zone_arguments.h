#pragma once

#include <cstdint>
#include <optional>
#include <string>

#include "cosiva/app/cli/common_arguments.h"

/// The options of `cosiva zone`.
namespace cosiva::app {

/// Of the subcommands of `zone`; each uses its own arguments.
struct ZoneArguments {
  std::string zone;     ///< name of a ready zone, or a file
  std::string sidecar;  ///< empty: the sidecar file next to the zone's file, if any
  bool json{false};
  std::optional<double> pitch_m;          ///< of the squares of a map; none: as its sidecar file states
  std::optional<std::uint32_t> stations;  ///< distributed over a map; none: likewise

  // show
  std::string svg_file;
  std::string png_file;
  std::uint32_t width_px{1600};

  // convert
  std::string out_file;
  std::string format;  ///< empty: by the ending of out_file

  // switch
  std::string url{"http://127.0.0.1:8080"};
  BrokerArguments broker;  ///< with an address: published there instead
  double wait_s{30.0};
};

}  // namespace cosiva::app
