#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "cosiva/experiments/positioning/campaign/work.h"

/// The stored state of a campaign in progress: text, a line for the plan and one for each finished unit, in the order
/// in which the units were finished. Numbers are written so that they read back to the same bits; each line ends with
/// its digest.
namespace cosiva::experiments {

/// The first line, with its line end.
[[nodiscard]] std::string state_header(const CampaignWork& work);
/// A unit's line, with its line end.
[[nodiscard]] std::string state_line(const UnitRecord& record);
/// Reads a line, without its end. Nothing where the line is damaged.
[[nodiscard]] std::optional<UnitRecord> unit_of(std::string_view line, const CampaignWork& work);

struct CampaignState {
  std::vector<UnitRecord> records;  ///< in the order of the file; of a repeated unit only the first
  bool torn{false};                 ///< the last line was incomplete, and does not count
  std::size_t whole_bytes{};        ///< size of the file up to the last complete line
};
/// Reads a state. Fails ("campaign.state") where the text is no state, is of another plan, or is damaged before its
/// last line, with advice.
[[nodiscard]] Result<CampaignState> read_state(std::string_view text, const CampaignWork& work,
                                               const std::string& origin);

}  // namespace cosiva::experiments
