#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "cosiva/app/cli/common_arguments.h"

/// What the command line said of `cosiva battery`, as plain values.
namespace cosiva::app {

struct BatteryFitArguments {
  std::vector<std::string> files;
  std::vector<std::string> series;   ///< only those whose name holds one of these; empty: all
  std::vector<std::string> predict;  ///< logs, or series of the files, that are not fitted but foretold
  std::string name{"fitted"};
  std::string source;
  std::string licence;
  double capacity_ah{0.0};
  double floor_v{0.0};
  std::string out_file;
  bool json{false};
};

struct BatteryTestArguments {
  std::string zone{"lacet4"};
  std::uint32_t aivs{4};
  std::string type{"lipo850"};  ///< a shipped one's name or a file
  std::uint32_t series{0};      ///< 0: as the type says; of the carts' usual type, as they have it
  std::uint32_t parallel{0};
  double scale{0.0};
  std::string gauge{"kalman"};
  double floor_percent{20.0};
  std::size_t repeat{1};
  bool swap{false};
  double pause_every_s{0.0};
  double pause_s{0.0};
  double failures_per_hour{0.0};
  double load_sd_percent{2.0};
  double ambient_c{22.0};
  double measure_s{120.0};
  bool whole{false};
  std::optional<double> hz;  ///< of everybody in the loop, with `whole`
  double half_width_percent{0.0};
  std::string state_file;
  std::string out_directory;
  std::string rules;
  std::uint64_t seed{1};
  bool json{false};
  // Of tests on a platform that runs:
  bool live{false};
  std::string url{"http://127.0.0.1:8080"};
  BrokerArguments broker;
  std::vector<std::string> vehicles;   ///< MANUFACTURER/SERIAL; none: AIV1, AIV2 …
  std::vector<std::string> batteries;  ///< what people call them; none: lipo850-1 …
  bool by_hand{false};                 ///< people change batteries
  std::string park;                    ///< a station
  double lost_after_s{30.0};
  std::string notify;  ///< a shell command
};

struct BatteryReadyArguments {
  std::string vehicle;
  std::string battery;
  std::string type{"unknown"};
  double cycles{0.0};
  double rest_s{0.0};
  double temperature_c{22.0};
  double charge_percent{100.0};
  BrokerArguments broker;
};

struct BatteryPlanArguments {
  double cv_percent{1.4};
  double half_width_percent{1.0};
  double difference_percent{0.0};  ///< between two types; 0: not asked
  std::size_t aivs{0};             ///< the square for so many; 0: not asked
  bool json{false};
};

struct BatteryDischargeArguments {
  std::string type;                ///< a shipped one's name or a file
  std::vector<double> currents_a;  ///< of the whole pack …
  std::vector<double> powers_w;    ///< … as power …
  std::vector<double> rates;       ///< … or in multiples of the capacity; none of all: 0.2, 0.5, 1 and 2
  double floor_v{0.0};             ///< of a cell; 0: the type's
  double ambient_c{25.0};
  double step_s{1.0};
  std::uint32_t series{1};
  std::uint32_t parallel{1};
  double scale{1.0};
  std::string csv_file;
  bool json{false};
};

struct BatteryAnalyseArguments {
  std::vector<std::string> files;   ///< tables, or results of tests
  std::vector<std::string> only;    ///< series of them; none: all
  std::vector<std::string> failed;  ///< BATTERY=SECONDS: as if it had failed then
  std::string time;                 ///< columns; empty: the usual names
  std::string battery;
  std::string vehicle;
  std::string run;
  double half_width_percent{0.0};
  std::string out_directory;
  std::uint64_t seed{1};
  bool json{false};
};

struct BatteryFilesArguments {
  std::vector<std::string> files;
  bool json{false};
};

int run_battery_fit(const BatteryFitArguments& arguments);
int run_battery_sampled(const BatteryTestArguments& arguments);
int run_battery_fleet(const BatteryTestArguments& arguments);
/// batteryReady, said by whoever has changed it.
int run_battery_ready(const BatteryReadyArguments& arguments);
/// What a type's battery does under one load, from full to its floor.
int run_battery_discharge(const BatteryDischargeArguments& arguments);
/// Tests that were made before, here or by others.
int run_battery_analyse(const BatteryAnalyseArguments& arguments);
/// Whether the wanted half width of the mean was reached, and after how many batteries.
[[nodiscard]] std::string stop_text(const std::optional<std::size_t>& stopped_after, double half_width_percent);
int run_battery_plan(const BatteryPlanArguments& arguments);
/// Two results of battery tests, whose batteries are compared.
int run_battery_compare(const BatteryFilesArguments& arguments);
/// Whether files are battery types, and what is wrong with them.
int run_battery_check(const BatteryFilesArguments& arguments);

}  // namespace cosiva::app
