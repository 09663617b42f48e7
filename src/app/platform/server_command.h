#pragma once

#include <cstdint>
#include <string>

#include "cosiva/app/cli/common_arguments.h"
#include "cosiva/app/platform/keep_option.h"
#include "cosiva/app/platform/limit_arguments.h"

namespace cosiva::app {

/// The options of `cosiva server`.
struct ServerArguments {
  PartArguments part;
  std::string area;  ///< this server's control area, where several share a broker; empty: the only server
  std::string zone;  ///< empty: from the broker
  bool watch{false};
  std::uint16_t port{8080};
  std::string
      map_link;  ///< where third-party vehicles download the zone's file; empty: from this server, on this machine
  bool no_drive{false};
  bool v2x{true};  ///< of its virtual AIVs
  bool convoys{true};
  std::string autonomy{"server"};
  ServerLimitArguments limits;
  bool headless{false};
  std::string web_directory;
  /// The folder of its store; empty: `$XDG_STATE_HOME/cosiva/store`, with the name of the area where there is one.
  std::string store;
  std::string keep{keep_default};  ///< how much of the store is retained (parse_keep)
  std::string scenario;            ///< name of a ready scenario, or a file
  std::string name;                ///< of the run, for the page
  std::string rules{"fuzzy"};      ///< of its virtual AIVs: crisp, fuzzy or a file
  // For `up`:
  std::string parts_file;       ///< the parts of the platform, which the page shows (Supervisor)
  std::uint32_t fleet{0};       ///< announce when this number of vehicles is matched
  std::string zone_file;        ///< where edits of the zone may be saved
  std::string watch_file;       ///< the zone's file to watch
  bool emulated{false};         ///< there is a plant, whose ground truth the page may show
  std::int64_t began_ms{0};     ///< when a previous run of this server began the scenario, Unix time; 0: none did
  std::uint64_t steps_done{0};  ///< how many of its steps the previous run had played
};

/// `cosiva server`: the server of the virtual side alone. Gives the exit status: 0 done, 1 the run's own checks failed,
/// 2 bad usage or bad input.
int run_server(const ServerArguments& arguments);

}  // namespace cosiva::app
