#pragma once

#include <cstdint>
#include <string>
#include <string_view>

#include "cosiva/base/result.h"

namespace cosiva::app {

/// What a run of the whole platform gave, from the summaries of its parts.
struct RunSummary {
  std::string
      json;  ///< {"bijection","aivs","collisions","laps","longest_wait_s","deadlocks","digest","duration_s","zone","seed","scenario"?}
  std::string text;    ///< the same for people: two lines, and a third where something was only virtual
  bool collided{};     ///< some vehicle touched something
  bool all_matched{};  ///< every vehicle asked for had exactly one twin at the end, and nothing else was there
};

struct RunMetadata {
  std::string zone;
  std::uint32_t aivs{};
  std::uint64_t seed{};
  double duration_s{};
  std::string digest;
  std::string scenario;  ///< empty: none
};

/// Fails ("run.summary") when a summary is not what its core writes.
[[nodiscard]] Result<RunSummary> summarise(const RunMetadata& metadata, std::string_view server_summary,
                                           std::string_view plant_summary);

}  // namespace cosiva::app
