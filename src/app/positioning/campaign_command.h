#pragma once

#include <cstdint>
#include <string>

namespace cosiva::app {

/// The options of `cosiva campaign`.
struct CampaignArguments {
  std::string plan_file;
  std::string out_folder;    ///< empty: nothing is written or stored
  std::uint32_t threads{0};  ///< 0: one per core
  bool json{false};
  bool anew{false};
  bool dry_run{false};
};

/// `cosiva campaign`. Gives the exit status: 0 done, 1 some cell is below its limit, 2 bad usage or bad input.
int run_campaign(const CampaignArguments& arguments);

}  // namespace cosiva::app
