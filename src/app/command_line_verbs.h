#pragma once

#include <CLI/CLI.hpp>
#include <memory>
#include <optional>
#include <string>

#include "app/arguments.h"
#include "app/battery_arguments.h"
#include "app/campaign_arguments.h"
#include "app/gvs_arguments.h"
#include "app/qualify_live.h"

/// The parts of the command line: who describes which verb's options. Only the command line includes this.
namespace cosiva::app {

/// @param without  what is used where no --broker is given
void add_broker(CLI::App& verb, BrokerArguments& broker, const std::string& without);

/// `cosiva zone` and its verbs.
struct ZoneVerbs {
  CLI::App* zone;
  CLI::App* check;
  CLI::App* show;
  CLI::App* convert;
  CLI::App* generate;
  CLI::App* switch_to;
};
[[nodiscard]] ZoneVerbs describe_zone(CLI::App& root, ZoneArguments& zone, GenerateArguments& generate);
/// The exit status of the one that was asked for, if any.
[[nodiscard]] std::optional<int> run_zone_verb(const ZoneVerbs& verbs, const ZoneArguments& zone,
                                               const GenerateArguments& generate);

/// `cosiva agent` and its verbs.
struct AgentVerbs {
  CLI::App* agent;
  CLI::App* explain;
  CLI::App* surface;
};
[[nodiscard]] AgentVerbs describe_agent(CLI::App& root, AgentArguments& agent);
/// The exit status of the one that was asked for, if any.
[[nodiscard]] std::optional<int> run_agent_verb(const AgentVerbs& verbs, const AgentArguments& agent);
/// `cosiva traffic`.
[[nodiscard]] CLI::App* describe_traffic(CLI::App& root, FleetTrafficArguments& traffic);
/// `cosiva capacity`.
[[nodiscard]] CLI::App* describe_capacity(CLI::App& root, CapacityArguments& capacity);
/// `cosiva battery` and its verbs.
struct BatteryArguments {
  BatteryFitArguments fit;
  BatteryReadyArguments ready;
  BatteryTestArguments test;
  BatteryPlanArguments plan;
  BatteryAnalyseArguments analyse;
  BatteryDischargeArguments discharge;
  BatteryFilesArguments compare;
  BatteryFilesArguments check;
};
struct BatteryVerbs {
  CLI::App* battery;
  CLI::App* sampled;
  CLI::App* fleet;
  CLI::App* fit;
  CLI::App* ready;
  CLI::App* plan;
  CLI::App* analyse;
  CLI::App* discharge;
  CLI::App* compare;
  CLI::App* check;
};
[[nodiscard]] BatteryVerbs describe_battery(CLI::App& root, BatteryArguments& battery);
/// The exit status of the one that was asked for, if any.
[[nodiscard]] std::optional<int> run_battery_verb(const BatteryVerbs& verbs, const BatteryArguments& battery);
/// `cosiva qualify` and `cosiva compare`.
struct QualifyVerbs {
  CLI::App* qualify;
  CLI::App* compare;
  std::shared_ptr<LiveQualifyArguments> live;
};
[[nodiscard]] QualifyVerbs describe_qualify(CLI::App& root, QualifyArguments& qualify);
/// The exit status of the one that was asked for, if any.
[[nodiscard]] std::optional<int> run_qualify_verb(const QualifyVerbs& verbs, QualifyArguments& qualify, int argc,
                                                  const char* const* argv);

/// `cosiva campaign`.
[[nodiscard]] CLI::App* describe_campaign(CLI::App& root, CampaignArguments& campaign);
/// `cosiva gvs` and its verbs.
struct GvsVerbs {
  CLI::App* gvs;
  CLI::App* watch;
  CLI::App* calibrate;
  CLI::App* track;
  CLI::App* render;
};
[[nodiscard]] GvsVerbs describe_gvs(CLI::App& root, GvsArguments& gvs);
/// The exit status of the one that was asked for, if any.
[[nodiscard]] std::optional<int> run_gvs_verb(const GvsVerbs& verbs, const GvsArguments& gvs);

/// Where a running platform's pictures come from: --gvs-… of `up`, the same without gvs of `gvs watch`.
void add_gvs_source(CLI::App& verb, GvsSource& source, const std::string& prefix);

/// --rules, of those who drive.
void add_rules(CLI::App& verb, std::string& rules, const std::string& what);
/// An option that is on or off; as `on` says unless it is given.
void add_switch(CLI::App& verb, const std::string& name, bool& on, const std::string& what);

}  // namespace cosiva::app
