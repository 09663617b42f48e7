#pragma once

#include <cstdint>
#include <string>

#include "cosiva/app/cli/common_arguments.h"

namespace cosiva::app {

/// The options of `cosiva server`.
struct ServerArguments {
  PartArguments part;
  std::string area;  ///< of several servers on one broker, this one's; empty: the only one
  std::string zone;  ///< empty: from the broker
  bool watch{false};
  std::uint16_t port{8080};
  std::string map_link;  ///< where vehicles of other makes download the zone's file; empty: from us, on this machine
  bool no_drive{false};
  bool v2x{true};  ///< of its virtual AIVs
  bool convoys{true};
  bool headless{false};
  std::string web_directory;
  std::string state_file;
  std::string scenario;        ///< a ready one's name or a file
  std::string name;            ///< of the run, for the page
  std::string rules{"fuzzy"};  ///< of its virtual AIVs: crisp, fuzzy or a file
  // For `up`:
  std::uint32_t fleet{0};       ///< announce when so many vehicles are matched
  std::string zone_file;        ///< where edits of the zone may be saved
  std::string watch_file;       ///< the zone's file, to be watched
  bool emulated{false};         ///< there is a plant, whose truth the page may show
  std::int64_t began_ms{0};     ///< when an earlier life of this server began the scenario, Unix time; 0: none did
  std::uint64_t steps_done{0};  ///< how many of its steps it had played
};

/// `cosiva server`: the server of the virtual side alone. Gives the exit status: 0 done, 1 the run's own checks failed,
/// 2 bad usage or bad input.
int run_server(const ServerArguments& arguments);

}  // namespace cosiva::app
