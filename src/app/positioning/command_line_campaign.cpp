// The options of `cosiva campaign`, and what its help says.
#include "cosiva/app/positioning/command_line_campaign.h"

#include "cosiva/app/positioning/campaign_command.h"

namespace cosiva::app {
namespace {

constexpr const char* examples =
    "Examples:\n"
    "  cosiva campaign examples/campaign.toml --dry-run           how much that is\n"
    "  cosiva campaign examples/campaign.toml --out density       again after a kill: it goes on where it was\n"
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
    "docs/guide/metrology.md tells all that can be in it.";

}  // namespace

CLI::App* describe_campaign(CLI::App& root, CampaignArguments& campaign) {
  CLI::App* command = root.add_subcommand(
      "campaign", "Sweep position estimators over beacon pitch, noise, speed and more; goes on after a kill");
  command->footer(examples);
  command->add_option("plan", campaign.plan_file, "what is swept: a TOML file")->type_name("PLAN.toml")->required();
  command
      ->add_option("--out", campaign.out_folder,
                   "keeps its state there, and writes report.html, result.json, CSV and campaign.sqlite; without: "
                   "nothing is kept")
      ->type_name("DIR");
  command->add_option("--threads", campaign.threads, "how many work on it; without: one for each core")
      ->type_name("N")
      ->check(CLI::Range(1, 1024));
  command->add_flag("--json", campaign.json, "print the result as JSON");
  command->add_flag("--anew", campaign.anew, "forget what is finished in --out");
  command->add_flag("--dry-run", campaign.dry_run, "say how much there is to do, and do nothing");
  return command;
}

}  // namespace cosiva::app
