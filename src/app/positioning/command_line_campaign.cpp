// The options of `cosiva campaign`, with its help text.
#include "cosiva/app/positioning/command_line_campaign.h"

#include "cosiva/app/positioning/campaign_command.h"

namespace cosiva::app {
namespace {

constexpr const char* examples =
    "Examples:\n"
    "  cosiva campaign examples/campaign.toml --dry-run           the amount of work\n"
    "  cosiva campaign examples/campaign.toml --out density       the same command continues after a kill\n"
    "  mpirun -n 4 cosiva campaign plan.toml --out density        on many cores or machines, with the same digest\n"
    "\n"
    "A plan:\n"
    "  runs = 20\n"
    "  tolerance_m = 0.01\n"
    "  [vary]\n"
    "  algorithm = [\"reset_rule\", \"arc_kalman\"]\n"
    "  pitch_m = { from = 0.1, to = 4.0, steps = 6, log = true }\n"
    "  missed_ratio = [0.0, 0.3]\n"
    "\n"
    "docs/guide/metrology.md describes all keys of a plan.";

}  // namespace

Command describe_campaign(Command root, CampaignArguments& campaign) {
  const Command command = root.add_subcommand(
      "campaign", "Sweep position estimators over beacon pitch, noise, speed and more; continues after a kill");
  command.footer(examples);
  command.add_option("plan", campaign.plan_file, "what is swept: a TOML file").value_name("PLAN.toml").required();
  command
      .add_option(
          "--out", campaign.out_folder,
          "folder of the state, and of the results: report.html, result.json, CSV and campaign.sqlite; without: "
          "nothing is stored")
      .value_name("DIR");
  command.add_option("--threads", campaign.threads, "number of threads; without: one for each core")
      .value_name("N")
      .in_range(1, 1024);
  command.add_flag("--json", campaign.json, "print the result as JSON");
  command.add_flag("--anew", campaign.anew, "discard the finished units in --out");
  command.add_flag("--dry-run", campaign.dry_run, "print the amount of work, and do nothing");
  return command;
}

}  // namespace cosiva::app
