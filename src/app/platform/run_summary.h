#pragma once

#include <cstdint>
#include <string>
#include <string_view>

#include "cosiva/base/result.h"

namespace cosiva::app {

/// The results of a run of the whole platform, from the summaries of its parts.
struct RunSummary {
  std::string
      json;  ///< {"bijection","aivs","collisions","laps","longest_wait_s","routes"?,"deadlocks","digest","duration_s","zone","seed","scenario"?}
  std::string text;    ///< the same as text: two lines, and a third where there were virtual objects
  bool collided{};     ///< some vehicle touched another body
  bool deadlocked{};   ///< at the end a deadlock was not resolved that no vehicle could resolve by yielding
  bool all_matched{};  ///< every requested vehicle had exactly one twin at the end, and no other vehicle was present
};

struct RunMetadata {
  std::string zone;
  std::uint32_t aivs{};
  std::uint64_t seed{};
  double duration_s{};
  std::string digest;
  std::string scenario;  ///< empty: none
};

/// Fails ("run.summary") when a summary does not have the format that its core writes.
[[nodiscard]] Result<RunSummary> summarise(const RunMetadata& metadata, std::string_view server_summary,
                                           std::string_view plant_summary);

}  // namespace cosiva::app
