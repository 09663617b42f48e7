#pragma once

#include <cstdint>
#include <optional>
#include <string>

#include "cosiva/app/cli/common_arguments.h"
#include "cosiva/app/gvs/gvs_source.h"

/// What the command line said of the platform and its parts, verb by verb, as plain values.
namespace cosiva::app {

struct UpArguments {
  std::string scenario;  ///< a ready one's name or a file; empty: none
  std::string name;      ///< of the run; empty: default_run_name
  /// What the command line said itself: it wins over the scenario.
  struct Given {
    bool zone{false};
    bool aivs{false};
    bool seed{false};
    bool duration{false};
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
  double respawn_s{5.0};
  std::string run_directory;
  bool virtual_time{false};
  bool page{false};             ///< with virtual time: at the page's own speed, with the page
  std::optional<double> speed;  ///< virtual seconds per second, with `page`
  double loss{0.0};
  std::string trace_file;
  std::string web_directory;
  bool v2x{true};
  bool convoys{true};
  bool gvs{false};  ///< a camera watches
  GvsSource gvs_source;
  std::string rules;  ///< crisp, fuzzy or a file; empty: crisp for physical AIVs, fuzzy for virtual ones
};

struct ServerArguments {
  PartArguments part;
  std::string hall;  ///< of several servers on one broker, this one's; empty: the only one
  std::string zone;  ///< empty: from the broker
  bool watch{false};
  std::uint16_t port{8080};
  std::string map_link;  ///< where vehicles of other makes download the zone's file; empty: from us, on this machine
  bool no_drive{false};
  bool v2x{true};  ///< of its virtual AIVs
  bool convoys{true};
  bool headless{false};
  std::string web_directory;
  std::string memory_file;
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

struct PlantArguments {
  PartArguments part;
  std::string zone;
  std::uint32_t vehicles{4};
  std::uint64_t seed{1};
  std::string sockets_directory;
};

struct AivArguments {
  PartArguments part;
  std::uint32_t number{1};
  std::string serial;  ///< empty: "AIV<number>"
  std::string sockets_directory;
  std::string zone;   ///< empty: from the broker
  std::string start;  ///< "section:s"; empty: not known until a tag or an initPosition tells
  std::string memory_file;
  bool emulated{false};        ///< its radio is the emulated world's
  std::string rules{"crisp"};  ///< crisp, fuzzy or a file
  bool v2x{true};
};

struct ReplayArguments {
  std::string file;
  bool json{false};
};

struct ScenarioArguments {
  std::string scenario;
  bool json{false};
};

/// Each runs one verb and gives the exit status: 0 done, 1 the run's own checks failed, 2 bad usage or bad input.
int run_up(const UpArguments& arguments);
int run_virtual_time(const UpArguments& arguments);
int run_server(const ServerArguments& arguments);
int run_plant(const PlantArguments& arguments);
int run_aiv(const AivArguments& arguments);
int run_replay(const ReplayArguments& arguments);
int run_scenario_check(const ScenarioArguments& arguments);
int run_scenario_list(const ScenarioArguments& arguments);

}  // namespace cosiva::app
