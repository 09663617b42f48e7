#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "aiv/agent_rules.h"
#include "app/gvs_source.h"
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
  bool v2x{true};
  bool convoys{true};
  bool gvs{false};  ///< a camera watches
  GvsSource gvs_source;
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
  std::optional<double> speed_mps;  ///< its own, towards what stands; nothing: `closing` says it
  std::string zone{"lacet4"};       ///< whose medium speed that counts by

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

/// Of `qualify` and `compare`.
struct QualifyArguments {
  std::vector<std::string> algorithms;  ///< names, or "all"; empty: what suits
  bool list{false};
  bool json{false};
  std::string out_folder;
  std::string command;       ///< as it was typed, for the report
  std::uint32_t threads{0};  ///< 0: as many as there are cores

  // virtual time
  std::string zone;  ///< empty: lacet4; with recordings: none
  double way_m{100.0};
  std::uint32_t runs{30};
  std::uint64_t seed{1};
  std::string marks{"pitch"};  ///< pitch, tags or beacons
  double pitch_m{0.5};
  double reach_m{0.02};  ///< of the reader, for beacons
  double speed_mps{0.5};
  double rate_hz{20.0};
  double odometry_m{0.01};  ///< standard deviation after one metre
  double reading_m{0.01};   ///< of a reading
  double missed{0.0};
  double scale{0.0};
  double survey_m{0.0};
  std::uint32_t particles{500};
  std::uint32_t horizon{4};

  // judging
  double threshold_m{0.01};
  double tolerance_m{0.05};
  double reliability{0.95};
  double confidence{0.95};
  std::optional<double> reference_m;
  std::string reference_budget;  ///< a file: reference_budget.json or a calibration.json

  // others'
  std::vector<std::string> recordings;
  double gap_s{0.5};
  std::vector<std::string> external;  ///< NAME=COMMAND
  double patience_s{10.0};
  std::string reference;
  std::vector<std::string> estimates;
  std::string associate{"interpolate"};
  std::string align{"none"};  ///< none, se2, se3 or origin
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
int run_traffic(const FleetTrafficArguments& arguments);
int run_site(const FleetTrafficArguments& arguments);
int run_capacity(const CapacityArguments& arguments);
int run_qualify(const QualifyArguments& arguments);
int run_compare(const QualifyArguments& arguments);
int run_agent_explain(const AgentArguments& arguments);
int run_agent_surface(const AgentArguments& arguments);

}  // namespace cosiva::app
