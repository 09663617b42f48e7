#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "aiv/agent_rules.h"
#include "zone/generate.h"

/// What the command line said, verb by verb, as plain values.
namespace cosiva::app {

struct BrokerArguments {
  std::string address;  ///< "HOST:PORT"; empty: 127.0.0.1:1883, or for `up` a private one
  std::string ca_file;
  std::string certificate_file;
  std::string key_file;
  std::string user;
  std::string password_file;
};

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
  std::string rules;  ///< crisp, fuzzy or a file; empty: crisp for physical AIVs, fuzzy for virtual ones
};

/// What all parts that run alone have in common.
struct PartArguments {
  BrokerArguments broker;
  std::string record_file;
  std::string summary_file;
  std::optional<double> duration_s;
  bool json{false};
  bool announce{false};  ///< for `up`: events as JSON lines on standard output
};

struct ServerArguments {
  PartArguments part;
  std::string zone;  ///< empty: from the broker
  bool watch{false};
  std::uint16_t port{8080};
  std::string map_link;  ///< where vehicles of other makes download the zone's file; empty: from us, on this machine
  bool no_drive{false};
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
};

struct ReplayArguments {
  std::string file;
  bool json{false};
};

/// Of the verbs of `zone`; each uses its own.
struct ZoneArguments {
  std::string zone;       ///< a ready one's name or a file
  std::string companion;  ///< empty: the one beside the file, if any
  bool json{false};

  // show
  std::string svg_file;
  std::string png_file;
  std::uint32_t width_px{1600};

  // convert
  std::string out_file;
  std::string format;  ///< empty: by the ending of out_file

  // switch
  std::string url{"http://127.0.0.1:8080"};
  BrokerArguments broker;  ///< an address in it: published there instead
  double wait_s{30.0};
};

struct GenerateArguments {
  std::string out_file;
  std::optional<std::uint64_t> sections;  ///< given: the plant's own numbers follow from it
  zone::PlantOptions plant;
  bool json{false};
};

struct ScenarioArguments {
  std::string scenario;
  bool json{false};
};

/// Of the verbs of `agent`.
struct AgentArguments {
  std::string rules{"fuzzy"};  ///< fuzzy or a file
  bool json{false};
  aiv::AgentInputs inputs{aiv::free_way_inputs()};
  std::string instruction{"none"};  ///< a profile's word, or none

  // explain
  std::string present;  ///< a profile's word; empty: none
  bool every_rule{false};

  // surface
  std::string x{"gap"};
  std::string y{"closing"};
  std::string of{"speed"};
  std::string out_file;
  std::uint32_t width_px{1200};
};

/// Each runs one verb and gives the exit status: 0 done, 1 the run's own checks failed, 2 bad usage or bad input.
int run_up(const UpArguments& arguments);
int run_virtual_time(const UpArguments& arguments);
int run_server(const ServerArguments& arguments);
int run_plant(const PlantArguments& arguments);
int run_aiv(const AivArguments& arguments);
int run_replay(const ReplayArguments& arguments);
int run_zone_check(const ZoneArguments& arguments);
int run_zone_show(const ZoneArguments& arguments);
int run_zone_convert(const ZoneArguments& arguments);
int run_zone_generate(const GenerateArguments& arguments);
int run_zone_switch(const ZoneArguments& arguments);
int run_scenario_check(const ScenarioArguments& arguments);
int run_scenario_list(const ScenarioArguments& arguments);
int run_agent_explain(const AgentArguments& arguments);
int run_agent_surface(const AgentArguments& arguments);

}  // namespace cosiva::app
