#pragma once

#include "cosiva/app/cli/options.h"
#include "cosiva/app/positioning/campaign_command.h"

/// The options of `cosiva campaign`.
namespace cosiva::app {

/// `cosiva campaign`.
[[nodiscard]] Command describe_campaign(Command root, CampaignArguments& campaign);

}  // namespace cosiva::app
