#pragma once

#include <CLI/CLI.hpp>

#include "cosiva/app/positioning/campaign_command.h"

/// The options of `cosiva campaign`.
namespace cosiva::app {

/// `cosiva campaign`.
[[nodiscard]] CLI::App* describe_campaign(CLI::App& root, CampaignArguments& campaign);

}  // namespace cosiva::app
