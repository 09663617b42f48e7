#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

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
  std::string zone{"lacet4"};
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
  double loss{0.0};
  std::string trace_file;
  std::string web_directory;
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
  std::uint16_t port{8080};
  bool no_drive{false};
  bool headless{false};
  std::string web_directory;
  std::uint32_t fleet{0};  ///< for `up`: announce when so many vehicles are matched
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
};

struct ReplayArguments {
  std::string file;
  bool json{false};
};

struct ZoneArguments {
  std::string zone;
  std::string svg_file;
  bool json{false};
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

}  // namespace cosiva::app
