#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "cosiva/experiments/positioning/campaign/work.h"

/// What a campaign keeps while it goes on: text, a line for the plan and one for each finished unit, in the order in
/// which they were finished. Numbers are written so that they read back to the same bits; each line ends with a digest
/// of itself.
namespace cosiva::experiments {

/// The first line, with its end.
[[nodiscard]] std::string state_header(const CampaignWork& work);
/// A unit's line, with its end.
[[nodiscard]] std::string state_line(const UnitRecord& record);
/// A line, without its end, read back; Nothing where it is
/// damaged.
[[nodiscard]] std::optional<UnitRecord> unit_of(std::string_view line, const CampaignWork& work);

struct CampaignState {
  std::vector<UnitRecord> records;  ///< in the order of the file; of a unit that is there twice only the first
  bool torn{false};                 ///< the last line was not whole, and does not count
  std::size_t whole_bytes{};        ///< of the file, up to there
};
/// Reads a state back. Fails ("campaign.state") where it is none, is of another plan, or is damaged before its last
/// line, and says what to do.
[[nodiscard]] Result<CampaignState> read_state(std::string_view text, const CampaignWork& work,
                                               const std::string& origin);

}  // namespace cosiva::experiments
